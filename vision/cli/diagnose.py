"""xneck diagnose."""

from pathlib import Path

import click

from vision.cli.output import FILE, FOLDER, report_result, results
from vision.result_folder import DATASET


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

    from identification.dataset_file import read_dataset
    from identification.diagnosis import diagnose, extended, record
    from identification.model import write_model
    from vision.report.diagnosis_page import DiagnosisResult, write_diagnosis_report
    from xneck.json_text import as_json
    from xneck.provenance import provenance
    from xneck.whole_file import write_text

    fitted, others = [read_dataset(p) for p in datasets], [read_dataset(p) for p in held_out]
    with tqdm(total=4, desc="diagnose", disable=True if quiet else None, leave=False) as bar:

        def told(step: str) -> None:
            bar.set_postfix_str(step)
            bar.update()

        found = diagnose(fitted, others, progress=told)
    inputs = {f"dataset{i + 1}": p for i, p in enumerate(datasets)} | {
        f"held_out{i + 1}": p for i, p in enumerate(held_out)
    }
    origin = provenance(inputs, {})
    result = record.as_json(found) | {"provenance": origin}
    out.mkdir(parents=True, exist_ok=True)
    write_text(out / "neck.yaml", extended.neck_yaml(extended.description(found.search.last, found.extended)))
    write_model(extended.model(found.search.last, found.extended, origin), out / "model.yaml")
    write_text(out / "diagnosis.json", as_json(result))
    name = f"{' and '.join(map(_called, datasets))}, diagnosed"
    write_diagnosis_report(DiagnosisResult(name, found, origin), out / "diagnosis.html")
    report_result(result, f"{record.as_text(found)}\n{out}", json_out, quiet)


def _called(dataset: Path) -> str:
    """By its recording where it lies in that one's folder of results, where all have the same name."""
    return dataset.resolve().parent.name if dataset.name == DATASET else dataset.stem
