"""xneck run."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from xneck.cli.output import FILE, FOLDER, progress, report_result, results, spreading
from xneck_foundation.recovery import say_recovered

if TYPE_CHECKING:
    from xneck.batch.batch import Asked

_STAGES = 6
"""at most, of one recording"""


@click.command(epilog="Example: xneck run recordings/*/ --out results --jobs 4")
@click.argument("folders", metavar="RECORDING...", nargs=-1, required=True, type=FILE)
@click.option(
    "--out", type=FOLDER, default=Path("results"), show_default=True, help="A folder for each recording here."
)
@spreading
@click.option("--rerun", is_flag=True, help="Also recording.rrd for the Rerun viewer. Needs the extra `rerun`.")
@click.option("--redo", is_flag=True, help="Do all again, also what has not changed, and what was refused.")
@results
def command(
    folders: tuple[Path, ...],
    out: Path,
    jobs: int | None,
    cluster: str | None,
    redo: bool,
    rerun: bool,
    json_out: str | None,
    quiet: bool,
) -> int:
    """All of it for recording folders (each with a recording.yaml), one HTML report each and a summary of all.

    Several recordings are spread over processes, or over a cluster, whose workers must see the recordings and --out by the same
    paths. What is done stays done: run the same command again to go on after an interruption. Done again is what changed: an input,
    recording.yaml, or xneck. One that was refused is not tried again before it changes; one whose process died is.

    Exit status 0: every recording has its result. 1: one or more were refused or failed (a line each on standard error); the
    others have their results all the same, and summary.json says which.
    """
    from xneck.batch.batch import Asked

    return run_all(folders, Asked(out, jobs, cluster, redo, rerun), json_out, quiet)


def run_all(
    folders: tuple[Path, ...], asked: "Asked", json_out: str | None, quiet: bool, held_out: str | None = None
) -> int:
    """Runs recordings and reports them; the exit status. `held_out`: diagnose all but the one of this name, held against it."""
    from xneck.batch.batch import named
    from xneck.viewers.rerun_sdk import rerun_sdk

    if asked.rerun:
        rerun_sdk("--rerun")
    places = named(folders, asked.out)
    if len(places) == 1 and asked.cluster is None:
        ((name, place),) = places.items()
        return _alone(name, place, asked, json_out, quiet)
    return _batch(places, asked, json_out, quiet, held_out)


def _alone(name: str, place: Path, asked: "Asked", json_out: str | None, quiet: bool) -> int:
    """In this process: no cluster to wait for, and a fault shows where it is."""
    from tqdm import tqdm

    from xneck.recording.recording_folder import read_recording
    from xneck.recording.result_folder import result_of

    recording, folder = read_recording(place), asked.out / name
    record = None if asked.redo else result_of(recording, folder, asked.rerun)
    known = record is not None
    if record is None:
        from xneck.recording.task import run_one

        with tqdm(total=_STAGES, disable=True if quiet else None, leave=False) as bar:

            def stage(what: str) -> None:
                bar.set_description(f"{name}: {what}")
                bar.update()

            record = run_one(recording, folder, asked.rerun, stage)
    sync, report = record["sync"], str(folder / record["report"])
    line = (
        f"{name}: {sync['frames_used']} of {sync['frames']} frames, offset {sync['offset_s']:.4f} s "
        f"+- {1e3 * sync['offset_sigma_s']:.2f} ms, {record['check']['verdict']}; {report}"
    )
    _say_lost(name, record)
    told = {"recordings": {name: record | {"report": report}}, "failed": {}}
    report_result(told, line + (" (done before)" if known else ""), json_out, quiet)
    return 0


def _batch(places: dict[str, Path], asked: "Asked", json_out: str | None, quiet: bool, held_out: str | None) -> int:
    """Over processes or a cluster; the table, summary.json and summary.html of all."""
    from xneck.batch.batch import run_batch
    from xneck.report import batch_rows
    from xneck.report.batch_page import write_batch_report
    from xneck_foundation.json_text import as_json
    from xneck_foundation.provenance import versions
    from xneck_foundation.whole_file import check_place, write_text

    out = asked.out
    out.mkdir(parents=True, exist_ok=True)
    page, numbers = out / "summary.html", out / "summary.json"
    check_place(page)
    check_place(numbers)
    with progress(len(places), "recordings", quiet) as step:
        ended = run_batch(places, asked, step)
    rows = {name: batch_rows.as_json(one) for name, one in ended.items()}
    failed = {name: one.failure for name, one in ended.items() if one.failure is not None}
    done = {name: one.record for name, one in ended.items() if one.record is not None}
    told = {"recordings": rows, "done": len(done), "failed": len(failed)}
    found = (
        None if held_out is None or failed else _diagnosed(out, [n for n in places if n != held_out], held_out, quiet)
    )
    if found is not None:
        told["diagnosis"] = batch_rows.diagnosis(found)
    write_text(numbers, as_json({**told, **versions()}))
    write_batch_report(rows, versions(), page, told.get("diagnosis"))
    for name, record in done.items():
        _say_lost(name, record)
    for name, why in failed.items():
        click.echo(f"xneck: {name} failed: {why}", err=True)
    records = {name: record | {"report": str(out / name / record["report"])} for name, record in done.items()}
    text = batch_rows.as_text(rows) + (f"\n{found['verdict']}: {found['sentence']}" if found else "")
    extra = {"diagnosis": found | {"report": str(out / told["diagnosis"]["report"])}} if found else {}
    report_result({"recordings": records, "failed": failed, **extra}, f"{text}\n{page}", json_out, quiet)
    return 1 if failed else 0


def _diagnosed(out: Path, names: list[str], held_out: str, quiet: bool) -> dict[str, Any]:
    """The record of a diagnosis in out/diagnosis, made anew where the data sets are others than before."""
    from xneck.diagnosis_folder import diagnose_into, diagnosis_of
    from xneck.recording.result_folder import DATASET
    from xneck.report.batch_rows import DIAGNOSIS

    folder = out / DIAGNOSIS
    datasets, others = [out / name / DATASET for name in names], [out / held_out / DATASET]
    found = diagnosis_of(folder, datasets, others)
    if found is None:
        with progress(4, "diagnose", quiet) as step:
            found, _ = diagnose_into(folder, datasets, others, lambda _: step(1))
    return found


def _say_lost(name: str, record: dict[str, Any]) -> None:
    for line in record["recovered"]:
        say_recovered(name, line)
