"""xneck simulate."""

from pathlib import Path
from typing import Literal

import click

from xneck.cli.finite_range import FiniteRange
from xneck.cli.output import export_beside, export_option, progress_bar, report_result, result_options
from xneck.cli.path_types import DATA_SET_OUTPUT, INPUT_FILE, OUTPUT_FILE
from xneck_foundation.errors import Refused, one_of

PICTURE_FORMATS = ("svg", "pdf", "png")

MAX_WINDOW_S = 60.0
"""s of a window of a long recording, which is simulated part by part (docs/thresholds.md)"""


@click.command(
    epilog="Example: xneck simulate dataset.mcap --model model.yaml --out simulated.mcap; "
    "xneck simulate motion.csv --neck neck.yaml --model model.yaml --out simulated.mcap --picture motion.svg"
)
@click.argument("dataset", metavar="DATASET | MOTION.csv", type=INPUT_FILE)
@click.option(
    "--model",
    "model_file",
    type=INPUT_FILE,
    help="model.yaml from `xneck identify`; a MOTION.csv may do without it, by one like Fasquelle's.",
)
@click.option("--out", type=DATA_SET_OUTPUT, required=True, help="simulated.mcap.")
@click.option("--neck", "neck_file", type=INPUT_FILE, help="neck.yaml of the arm that is to play a MOTION.csv.")
@click.option("--picture", type=OUTPUT_FILE, help="The joints' angles of a motion as .svg, .pdf or .png.")
@click.option(
    "--from",
    "source",
    type=click.Choice(["f", "theta"]),
    default="f",
    show_default=True,
    help="What is given: the recorded motor forces, or the recorded motor angles.",
)
@click.option(
    "--window",
    type=FiniteRange(0.05, 1e6),
    default=0.5,
    show_default=True,
    help="Restart from the measured state every so many seconds.",
)
@click.option(
    "--free", is_flag=True, help="Never restart: free-running from the first sample, as a motion always does."
)
@export_option
@result_options
def command(
    dataset: Path,
    model_file: Path | None,
    out: Path,
    neck_file: Path | None,
    picture: Path | None,
    source: Literal["f", "theta"],
    window: float,
    free: bool,
    export_as: str | None,
    json_out: Path | None,
    quiet: bool,
) -> None:
    """Send the recorded forces, or the motor angles, through the model and lay the motion beside what was measured.

    Of every channel the error is held against its noise floor: what state, sensors and parameters leave unknown.

    With --neck it takes a motion of `xneck design` that was not played yet, and lays what the arm would do beside what was
    designed: before anything was recorded too, by a model like that of Fasquelle's arm.
    """
    if neck_file is not None and dataset.suffix.lower() == ".mcap":
        what = "is a data set, and no motion by `xneck design`"
        raise Refused(dataset, what, "leave --neck out: a data set holds its arm's description")
    if neck_file is not None:
        _simulate_motion(dataset, neck_file, model_file, out, picture, source, export_as, json_out, quiet)
        return
    if dataset.suffix.lower() == ".csv":
        raise Refused(
            dataset, "is no data set", "of a motion by `xneck design` say which arm is to play it: --neck neck.yaml"
        )
    if model_file is None:
        raise click.UsageError("Missing option '--model'.")
    if picture is not None:
        raise click.UsageError("--picture is of a motion, with --neck; of recordings `xneck run` makes pages")
    from identification.dataset.stretches import is_long, parts_of
    from identification.files import joint_state
    from identification.model_file import read_model
    from identification.simulation.simulated_parts import simulate_parts
    from identification.simulation.simulated_recording import simulate_recording
    from xneck.cli.model_of_arm import of_the_models_arm
    from xneck.export.result_words import as_record, in_words
    from xneck_foundation.provenance import note_inputs, provenance

    inputs = note_inputs({"dataset": dataset, "model": model_file})
    model, long = read_model(model_file), is_long(dataset)
    if long and (free or window > MAX_WINDOW_S):
        what = f"is simulated over windows of at most {MAX_WINDOW_S:.0f} s, as it is long"
        raise Refused(dataset, what, "give a shorter --window, without --free, or a shorter recording")
    if long and export_as in ("npz", "mat"):
        raise Refused(out, f"a recording of this length is not exported as {export_as}", "export csv")
    parts = of_the_models_arm(parts_of(dataset, window=window if long else 0.0), model, model_file, dataset)
    if long:
        with progress_bar(None, "simulate", quiet) as done:
            simulated = simulate_parts(parts, model, window, source, done, out.parent)
    else:
        data = next(parts)
        with progress_bar(len(data.state) if free else None, "simulate", quiet) as done:
            simulated = simulate_recording(data, model, None if free else window, source, done)
    origin = provenance(inputs, {"window_s": simulated.window_s, "from": source})
    joint_state.write(out, {"simulated": simulated.series}, {"provenance": origin})
    export_beside(simulated.series, out, export_as)
    report_result(as_record(simulated), f"{out}: {in_words(simulated)}", json_out, quiet)


def _simulate_motion(
    file: Path,
    neck_file: Path,
    model_file: Path | None,
    out: Path,
    picture: Path | None,
    source: Literal["f", "theta"],
    export_as: str | None,
    json_out: Path | None,
    quiet: bool,
) -> None:
    """A motion that was designed, through the model."""
    from identification.files import joint_state
    from identification.model_file import read_model
    from identification.simulation.simulated_motion import simulate_motion
    from mechanism.description import read_neck
    from xneck.cli.model_of_arm import warn_of_another_arm
    from xneck.export.motion_file import read_motion
    from xneck_foundation.provenance import note_inputs, provenance

    if picture is not None:
        one_of(picture, picture.suffix.removeprefix(".").lower(), PICTURE_FORMATS, "suffix")
    inputs = note_inputs({"motion": file, "neck": neck_file} | ({"model": model_file} if model_file else {}))
    neck, model = read_neck(neck_file), read_model(model_file) if model_file else None
    if model is not None and model_file is not None:
        warn_of_another_arm(model, model_file, neck, neck_file)
    simulated = simulate_motion(read_motion(file, neck), neck, model, source, file)
    joint_state.write(out, {"simulated": simulated.series}, {"provenance": provenance(inputs, {"from": source})})
    export_beside(simulated.series, out, export_as)
    if picture is not None:
        from xneck.export.result_figures import write_picture
        from xneck.report.simulation_figures import simulated_beside_designed

        write_picture(simulated_beside_designed, simulated, picture)
    report_result(simulated.as_json(), f"{out}: {simulated.as_text()}", json_out, quiet)
