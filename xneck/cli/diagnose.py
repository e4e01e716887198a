"""xneck diagnose."""

from pathlib import Path

import click

from xneck.cli.output import report_result, result_options
from xneck.cli.path_types import INPUT_FILE, OutputFolder
from xneck.recording.result_files import DIAGNOSIS_FILES


@click.command(epilog="Example: xneck diagnose monday.mcap --held-out tuesday.mcap --out diagnosis")
@click.argument("datasets", metavar="DATASET...", nargs=-1, required=True, type=INPUT_FILE)
@click.option(
    "--held-out", multiple=True, type=INPUT_FILE, help="A data set of the same arm that is not fitted; may be repeated."
)
@click.option(
    "--out",
    type=OutputFolder(DIAGNOSIS_FILES),
    required=True,
    help="Folder for diagnosis.html, diagnosis.json, the extended neck.yaml and model.yaml.",
)
@result_options
def command(
    datasets: tuple[Path, ...], held_out: tuple[Path, ...], out: Path, json_out: Path | None, quiet: bool
) -> None:
    """Show what the simulation gets wrong, name the cause, extend the model, and measure the gain on data it was not fitted to.

    The verdict is `consistent`, `cause`, `ambiguous` (several causes explain the data alike), `unknown` (something is wrong that
    no known cause explains) or `insufficient` (the recordings could not tell).
    """
    from tqdm import tqdm

    from xneck.batch.diagnosis_task import run_diagnosis_task

    with tqdm(desc="diagnose", unit=" steps", disable=True if quiet else None, leave=False) as bar:

        def show_step(step: str) -> None:
            bar.set_postfix_str(step)
            bar.update()

        result, text = run_diagnosis_task(out, datasets, held_out, show_step)
    report_result(result, f"{text}\n{out}", json_out, quiet)
