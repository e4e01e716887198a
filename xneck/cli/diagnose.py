"""xneck diagnose."""

from pathlib import Path

import click

from xneck.cli.output import FILE, FOLDER, report_result, results


@click.command(epilog="Example: xneck diagnose monday.mcap --held-out tuesday.mcap --out diagnosis")
@click.argument("datasets", metavar="DATASET...", nargs=-1, required=True, type=FILE)
@click.option(
    "--held-out", multiple=True, type=FILE, help="A data set of the same arm that is not fitted; may be repeated."
)
@click.option(
    "--out",
    type=FOLDER,
    required=True,
    help="Folder for diagnosis.html, diagnosis.json, the extended neck.yaml and model.yaml.",
)
@results
def command(
    datasets: tuple[Path, ...], held_out: tuple[Path, ...], out: Path, json_out: str | None, quiet: bool
) -> None:
    """Show what the simulation gets wrong, name the cause, extend the model, and measure the gain on data it was not fitted to.

    The verdict is `consistent`, `cause`, `ambiguous` (several causes explain the data alike), `unknown` (something is wrong that
    no known cause explains) or `insufficient` (the recordings could not tell).
    """
    from tqdm import tqdm

    from xneck.diagnosis_folder import diagnose_into

    with tqdm(total=4, desc="diagnose", disable=True if quiet else None, leave=False) as bar:

        def told(step: str) -> None:
            bar.set_postfix_str(step)
            bar.update()

        result, text = diagnose_into(out, datasets, held_out, told)
    report_result(result, f"{text}\n{out}", json_out, quiet)
