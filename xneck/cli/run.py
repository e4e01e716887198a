"""xneck run."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from xneck.cli.cluster_options import worker_options
from xneck.cli.output import progress_bar, report_result, result_options
from xneck.cli.path_types import INPUT_FILE, OutputFolder
from xneck.cli.terminal import print_error
from xneck.recording.result_files import BATCH_FILES, SUMMARY_PAGE, SUMMARY_RECORD
from xneck_foundation.one_line import printable
from xneck_foundation.recovery import warn_recovered

if TYPE_CHECKING:
    from xneck.batch.cluster import Cluster
    from xneck.batch.run_batch import BatchOptions

_MAX_STAGES = 6
"""stages of one recording, for the progress bar"""
_DIAGNOSIS_STEPS = 4


@click.command(epilog="Example: xneck run recordings/*/ --out results --jobs 4")
@click.argument("folders", metavar="RECORDING...", nargs=-1, required=True, type=INPUT_FILE)
@click.option(
    "--out",
    type=OutputFolder(BATCH_FILES),
    default=Path("results"),
    show_default=True,
    help="A folder for each recording here.",
)
@click.option("--neck", type=INPUT_FILE, help="neck.yaml of all of them, in the place of those that they name.")
@click.option("--camera", type=INPUT_FILE, help="camera.yaml of all of them, likewise.")
@click.option("--held-out", metavar="NAME", help="Diagnose the others, and hold this recording against what is found.")
@worker_options
@click.option("--rerun", is_flag=True, help="Also recording.rrd for the Rerun viewer. Needs the extra `rerun`.")
@click.option("--redo", is_flag=True, help="Do all again, also what has not changed, and what was refused.")
@result_options
def command(
    folders: tuple[Path, ...],
    out: Path,
    neck: Path | None,
    camera: Path | None,
    held_out: str | None,
    jobs: int | None,
    cluster: "Cluster | None",
    redo: bool,
    rerun: bool,
    json_out: Path | None,
    quiet: bool,
) -> int:
    """All of it for recording folders (each with a recording.yaml), one HTML report each and a summary of all.

    Several recordings are spread over processes, or over a cluster, whose workers must see the recordings and --out by the same
    paths. What is done stays done: run the same command again to go on after an interruption. Done again is what changed: an input,
    recording.yaml, or xneck. One that was refused is not tried again before it changes; one whose process died is.

    One arm and one camera are named once, by --neck and --camera; a recording.yaml then need not name them.

    With --held-out, what the simulation gets wrong is sought in all recordings but that one, as `xneck diagnose` does: its page and
    files go to the folder `diagnosis` in --out, and the summary begins with what it found.

    Exit status 0: every recording has its result. 1: one or more were refused or failed (a line each on standard error); the
    others have their results all the same, and summary.json says which.
    """
    from xneck.batch.run_batch import BatchOptions
    from xneck.recording.recording_folder import SharedFiles

    shared = SharedFiles(neck, camera)
    options = BatchOptions(out=out, jobs=jobs, cluster=cluster, redo=redo, rerun=rerun, shared=shared)
    return run_recordings(folders, options, json_out, quiet, held_out)


def run_recordings(
    folders: tuple[Path, ...], options: "BatchOptions", json_out: Path | None, quiet: bool, held_out: str | None = None
) -> int:
    """Runs recordings, reports them and returns the exit status.

    `held_out`: name of a recording; the others are diagnosed and held against it.
    """
    from xneck.batch.run_batch import named_twice, recordings_by_name
    from xneck.viewers.rerun_sdk import rerun_sdk
    from xneck_foundation.folder_lock import only_run_in

    if options.rerun:
        rerun_sdk("--rerun")
    named_folders = recordings_by_name(folders, options.out)
    if held_out is not None:
        _check_held_out(held_out, list(named_folders))
    for given, first in named_twice(folders, named_folders).items():
        print_error(f"warning: {given} was left out: it is {first} under another name")
    with only_run_in(options.out), _told_how_to_go_on():
        if len(named_folders) == 1 and options.cluster is None:
            ((name, folder),) = named_folders.items()
            return _run_single(name, folder, options, json_out, quiet)
        return _run_many(named_folders, options, json_out, quiet, held_out)


def _check_held_out(held_out: str, names: list[str]) -> None:
    from xneck_foundation.errors import Refused
    from xneck_foundation.spelling import quoted, valid_words

    if held_out not in names:
        raise Refused("--held-out", f"no recording is called {quoted(held_out)}", valid_words(held_out, names))
    if len(names) == 1:
        raise Refused("--held-out", f"{held_out} is the only recording", "name one more, which is diagnosed")


@contextmanager
def _told_how_to_go_on() -> Iterator[None]:
    """An interruption says that what is done stays so."""
    try:
        yield
    except KeyboardInterrupt as interruption:
        raise click.Abort("what is done is kept: the same command does the rest") from interruption


def _run_single(name: str, source: Path, options: "BatchOptions", json_out: Path | None, quiet: bool) -> int:
    """Runs one recording in this process: no cluster to wait for, and an error is raised where it happens."""
    from tqdm import tqdm

    from synchronisation.check.wording import sentence
    from xneck.recording.recording_folder import read_recording
    from xneck.recording.result_folder import stored_result
    from xneck.report.batch_table import identified_lines

    recording, folder = read_recording(source, options.shared), options.out / name
    record = None if options.redo else stored_result(recording, folder, options.rerun)
    done_before = record is not None
    if record is None:
        from xneck.batch.recording_task import run_recording_task

        with tqdm(total=_MAX_STAGES, disable=True if quiet else None, leave=False) as bar:

            def show_stage(stage: str) -> None:
                bar.set_description(printable(f"{name}: {stage}"))
                bar.update()

            record = run_recording_task(recording, folder, options.rerun, show_stage)
    sync, report = record["sync"], str(folder / record["report"])
    line = (
        f"{name}: {sync['frames_used']} of {sync['frames']} frames, offset {sync['offset_s']:.4f} s "
        f"+- {1e3 * sync['offset_sigma_s']:.2f} ms, {record['check']['verdict']}; {report}"
    )
    _warn_recovered(name, record)
    result = {"recordings": {name: record | {"report": report}}, "done": 1, "failed": {}}
    lines = [
        line + (" (done before)" if done_before else ""),
        *(f"  {sentence(fault)}" for fault in record["check"]["faults"]),
        *(f"  warning: {warning}" for warning in record["sync"]["warnings"]),
        *identified_lines(record["identify"]["parameters"]),
        *([f"  {record['adequacy']['sentence']}"] if record["adequacy"] else []),
    ]
    report_result(result, "\n".join(lines), json_out, quiet)
    return 0


def _run_many(
    named_folders: dict[str, Path], options: "BatchOptions", json_out: Path | None, quiet: bool, held_out: str | None
) -> int:
    """Runs recordings on processes or a cluster; writes summary.json and summary.html, and prints their table."""
    from xneck.batch.run_batch import run_batch
    from xneck.report import batch_table
    from xneck.report.batch_page import write_batch_report
    from xneck_foundation.json_text import json_text
    from xneck_foundation.provenance import versions
    from xneck_foundation.whole_file import check_output, write_text

    out = options.out
    page, numbers = out / SUMMARY_PAGE, out / SUMMARY_RECORD
    check_output(page)
    check_output(numbers)
    with progress_bar(len(named_folders), "recordings", quiet) as step:
        outcomes = run_batch(named_folders, options, step)
    rows = {name: outcome.summary_row() for name, outcome in outcomes.items()}
    failures = {name: outcome.failure for name, outcome in outcomes.items() if outcome.failure is not None}
    records = {name: outcome.record for name, outcome in outcomes.items() if outcome.record is not None}
    summary: dict[str, Any] = {"recordings": rows, "done": len(records), "failed": len(failures)}
    diagnosis = None
    diagnosed = [name for name in records if name != held_out]
    if held_out in records and diagnosed:
        diagnosis = _diagnose(out, diagnosed, held_out, quiet)
        summary["diagnosis"] = batch_table.diagnosis_row(diagnosis)
    elif held_out is not None:
        print_error(
            f"nothing was diagnosed: it takes {held_out}, which is held out, and a recording more with a result"
        )
    write_text(numbers, json_text({**summary, **versions()}))
    write_batch_report(rows, versions(), page, summary.get("diagnosis"))
    for name, record in records.items():
        _warn_recovered(name, record)
    for name, failure in failures.items():
        print_error(f"{name} failed: {failure}")
    text = batch_table.batch_text(rows)
    result: dict[str, Any] = {
        "recordings": {
            name: record | {"report": str(out / name / record["report"])} for name, record in records.items()
        },
        "done": len(records),
        "failed": failures,
    }
    if diagnosis is not None:
        text += f"\n{diagnosis['verdict']}: {diagnosis['sentence']}"
        result["diagnosis"] = diagnosis | {"report": str(out / summary["diagnosis"]["report"])}
    report_result(result, f"{text}\n{page}", json_out, quiet)
    return 1 if failures else 0


def _diagnose(out: Path, names: list[str], held_out: str, quiet: bool) -> dict[str, Any]:
    """The record of a diagnosis in out/diagnosis, made anew where the data sets have changed."""
    from xneck.batch.diagnosis_task import run_diagnosis_task, stored_diagnosis
    from xneck.recording.result_files import DATASET, DIAGNOSIS_FOLDER

    folder = out / DIAGNOSIS_FOLDER
    fitted, unfitted = [out / name / DATASET for name in names], [out / held_out / DATASET]
    record = stored_diagnosis(folder, fitted, unfitted)
    if record is None:
        with progress_bar(_DIAGNOSIS_STEPS, "diagnose", quiet) as step:
            record, _ = run_diagnosis_task(folder, fitted, unfitted, lambda _: step(1), in_batch=True)
    return record


def _warn_recovered(name: str, record: dict[str, Any]) -> None:
    for line in record["recovered"]:
        warn_recovered(name, line)
