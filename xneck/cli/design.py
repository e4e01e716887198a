"""xneck design."""

from pathlib import Path

import click

from xneck.cli.finite_range import FiniteRange
from xneck.cli.output import progress_bar, report_result, result_options
from xneck.cli.path_types import INPUT_FILE, OUTPUT_FILE

_POSITIVE = FiniteRange(0, 1e6, min_open=True)
_DEGREES = FiniteRange(0, 180, min_open=True)


@click.command(
    epilog="Example: xneck design neck.yaml --model model.yaml --for actuator_gain --for drum_radius --out motion.csv"
)
@click.argument("neck_file", metavar="NECK.yaml", type=INPUT_FILE)
@click.option("--model", "model_file", type=INPUT_FILE, help="model.yaml of this arm; without it one like Fasquelle's.")
@click.option("--out", type=OUTPUT_FILE, required=True, help="motion.csv (also .npz, .mat).")
@click.option("--seconds", type=FiniteRange(5, 600), default=60.0, show_default=True, help="Rests included.")
@click.option("--peak-deg", type=_DEGREES, default=30.0, show_default=True, help="Largest angle of a joint, deg.")
@click.option(
    "--max-speed", type=_POSITIVE, default=300.0, show_default=True, help="Of a motor, rad/s before its gear."
)
@click.option("--max-force", type=_POSITIVE, help="Of a motor, N on its cable.")
@click.option(
    "--tension", type=(_POSITIVE, _POSITIVE), metavar="LOW HIGH", default=(20.0, 112.0), show_default=True, help="N."
)
@click.option(
    "--for",
    "names",
    multiple=True,
    metavar="NAME",
    help="A parameter, or an effect to be shown and told from each other one; repeatable. [fs, k, ca]",
)
@click.option(
    "--beside", multiple=True, metavar="EFFECT", help="That the effects of --for are told from as well; repeatable."
)
@click.option("--noise-deg", type=_DEGREES, default=0.1, show_default=True, help="Of an angle in a frame, deg.")
@click.option("--frame-hz", type=FiniteRange(1, 1e4), default=30.0, show_default=True, help="Of the camera.")
@click.option(
    "--tries", type=click.IntRange(3, 100_000), default=120, show_default=True, help="Motions that are compared."
)
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Of what is drawn at random.")
@result_options
def command(
    neck_file: Path,
    model_file: Path | None,
    out: Path,
    seconds: float,
    peak_deg: float,
    max_speed: float,
    max_force: float | None,
    tension: tuple[float, float],
    names: tuple[str, ...],
    beside: tuple[str, ...],
    noise_deg: float,
    frame_hz: float,
    tries: int,
    seed: int,
    json_out: Path | None,
    quiet: bool,
) -> None:
    """Design an exciting motion: joint angles, motor angles and forces at 500 Hz for the controller.

    The tension level varies apart from the motion. It begins and ends at rest in the straight pose, where the motors already
    stand as the first row says. With it comes how well each parameter will be told, and whether each effect will show.
    """
    from math import inf, radians

    from diagnosis.deciding_motion import answers_json, answers_text, motion_for
    from diagnosis.motion_questions import effects_among, questions_about
    from identification.dataset.dataset_file import EXPORT_FORMATS, export_series
    from identification.design.information import AngleNoise
    from identification.design.nominal_machine import nominal_machine
    from identification.design.result import as_json, as_text, motion_series
    from identification.design.search import DEFAULT_TARGETS, SearchOptions
    from identification.design.trajectory import MotionLimits
    from identification.model_file import machine_of, read_model
    from mechanism.arm import arm_of
    from mechanism.description import read_neck
    from xneck_foundation.errors import Refused, one_of

    one_of(out, out.suffix.removeprefix(".").lower(), EXPORT_FORMATS, "suffix")
    if not tension[0] < tension[1]:
        raise Refused("design", f"--tension {tension[0]:g} {tension[1]:g} leaves no range", "give the lower one first")
    neck = read_neck(neck_file)
    machine = machine_of(read_model(model_file), arm_of(neck)) if model_file else nominal_machine(neck)
    effects, parameters = effects_among(names or DEFAULT_TARGETS)
    others, not_effects = effects_among(beside)
    if not_effects:
        raise Refused("design --beside", f"{not_effects[0]} is no effect", "name an effect, or leave it out")
    questions = questions_about(effects, neck, others)
    limits = MotionLimits(radians(peak_deg), max_speed, tension, max_force or inf)
    noise = AngleNoise(radians(noise_deg), frame_hz)
    draws = tries // 3
    with progress_bar(tries, "design", quiet) as done:
        options = SearchOptions(seconds, draws=draws, changes=tries - draws, seed=seed)
        judged = motion_for(neck, machine, questions, parameters, limits, noise, options, done)
    export_series(motion_series(judged.designed.motion), out)
    text = "\n".join(filter(None, [f"{out}:", answers_text(judged), as_text(judged.designed)]))
    record = as_json(judged.designed, limits, noise) | {"effects": answers_json(judged)}
    report_result(record, text, json_out, quiet)
