"""xneck simulate."""

from pathlib import Path
from typing import Literal

import click

from xneck.cli.finite_range import FiniteRange
from xneck.cli.output import export_beside, export_option, progress_bar, report_result, result_options
from xneck.cli.path_types import INPUT_FILE, OUTPUT_FILE

MAX_WINDOW_S = 60.0
"""s of a window of a long recording, which is simulated part by part (docs/thresholds.md)"""


@click.command(epilog="Example: xneck simulate dataset.mcap --model model.yaml --out simulated.mcap")
@click.argument("dataset", type=INPUT_FILE)
@click.option("--model", "model_file", type=INPUT_FILE, required=True, help="model.yaml from `xneck identify`.")
@click.option("--out", type=OUTPUT_FILE, required=True, help="simulated.mcap.")
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
@click.option("--free", is_flag=True, help="Never restart: free-running from the first sample.")
@export_option
@result_options
def command(
    dataset: Path,
    model_file: Path,
    out: Path,
    source: Literal["f", "theta"],
    window: float,
    free: bool,
    export_as: str | None,
    json_out: Path | None,
    quiet: bool,
) -> None:
    """Send the recorded forces, or the motor angles, through the model and lay the motion beside what was measured.

    Of every channel the error is held against its noise floor: what state, sensors and parameters leave unknown.
    """
    from identification.dataset.stretches import is_long, parts_of
    from identification.files import joint_state
    from identification.model_file import read_model
    from identification.simulation.channels import as_text
    from identification.simulation.simulated_parts import simulate_parts
    from identification.simulation.simulated_recording import simulate_recording
    from xneck_foundation.errors import Refused
    from xneck_foundation.provenance import note_inputs, provenance

    inputs = note_inputs({"dataset": dataset, "model": model_file})
    model, long = read_model(model_file), is_long(dataset)
    if long and (free or window > MAX_WINDOW_S):
        what = f"is simulated over windows of at most {MAX_WINDOW_S:.0f} s, as it is long"
        raise Refused(dataset, what, "give a shorter --window, without --free, or a shorter recording")
    if long and export_as in ("npz", "mat"):
        raise Refused(out, f"a recording of this length is not exported as {export_as}", "export csv")
    if long:
        with progress_bar(None, "simulate", quiet) as done:
            simulated = simulate_parts(parts_of(dataset, window=window), model, window, source, done, out.parent)
    else:
        data = next(parts_of(dataset))
        with progress_bar(len(data.state) if free else None, "simulate", quiet) as done:
            simulated = simulate_recording(data, model, None if free else window, source, done)
    origin = provenance(inputs, {"window_s": simulated.window_s, "from": source})
    joint_state.write(out, {"simulated": simulated.series}, {"provenance": origin})
    export_beside(simulated.series, out, export_as)
    result = {
        "window_s": simulated.window_s,
        "from": source,
        "channels": [channel.as_json() for channel in simulated.channels],
        "rms": simulated.rms,
    }
    text = f"{out}: simulated less measured over windows of {simulated.window_s:.2f} s\n{as_text(simulated.channels)}"
    report_result(result, text, json_out, quiet)
