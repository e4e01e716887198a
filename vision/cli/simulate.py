"""xneck simulate."""

from pathlib import Path

import click

from vision.cli.output import FILE, OUT, export_beside, exported, progress, report_result, results


@click.command(epilog="Example: xneck simulate dataset.mcap --model model.yaml --out simulated.mcap --window 1")
@click.argument("dataset", type=FILE)
@click.option("--model", "model_file", type=FILE, required=True, help="model.yaml from `xneck identify`.")
@click.option("--out", type=OUT, required=True, help="simulated.mcap.")
@click.option("--window", type=click.FloatRange(0.05), help="Restart from the measured state every so many seconds.")
@exported
@results
def command(
    dataset: Path,
    model_file: Path,
    out: Path,
    window: float | None,
    export_as: str | None,
    json_out: str | None,
    quiet: bool,
) -> None:
    """Send the recorded forces through the model and lay the motion beside what was measured.

    Free-running from the first sample, unless --window restarts it.
    """
    from math import degrees

    from identification import joint_state
    from identification.dataset_file import read_dataset
    from identification.model import read_model
    from identification.simulated import simulate_recording
    from xneck.provenance import provenance

    data, model = read_dataset(dataset), read_model(model_file)
    with progress(None if window else len(data.state), "simulate", quiet) as done:
        found = simulate_recording(data, model, window, done)
    origin = provenance({"dataset": dataset, "model": model_file}, {"window_s": window})
    joint_state.write(out, {"simulated": found.series}, {"provenance": origin})
    export_beside(found.series, out, export_as)
    result = {"window_s": found.window_s, "rms": found.rms}
    errors = ", ".join(f"{name} {degrees(rms):.2f} deg" for name, rms in found.rms.items())
    text = f"{out}: simulated less measured, rms over windows of {found.window_s:.2f} s: {errors}"
    report_result(result, text, json_out, quiet)
