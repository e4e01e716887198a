"""Many recordings: those with a result are known, the others run on the workers; one that fails does not stop the rest."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from xneck.batch.cluster import Cluster
from xneck.batch.outcome import RecordingOutcome
from xneck.batch.worker_pool import available_cores, run_tasks, worker_pool
from xneck.recording.progress import no_progress
from xneck.recording.recording_folder import NOTHING_SHARED, RECORDING_FILE, Recording, SharedFiles, read_recording
from xneck.recording.result_folder import remove_partial_files, stored_refusal, stored_result, without_folder
from xneck_foundation.errors import Refused


@dataclass(frozen=True)
class BatchOptions:
    """How recordings are to be run."""

    out: Path
    """results go to folders of the recordings' names in here"""
    jobs: int | None = None
    """processes on this machine; None: one a core"""
    cluster: Cluster | None = None
    """a dask scheduler to use instead of processes on this machine"""
    redo: bool = False
    """run again what has a result, and what was refused"""
    rerun: bool = False
    """write recording.rrd for Rerun too"""
    shared: SharedFiles = NOTHING_SHARED
    """files that are named once for all recordings"""


def recordings_by_name(folders: Sequence[Path], out: Path) -> dict[str, Path]:
    """Recordings by their folders' names, each once. The folder `out`, which `*/` takes along, is left out.

    Raises Refused where two have the same name, or no recording remains.
    """
    recordings: dict[str, Path] = {}
    for given in folders:
        folder = given.resolve()
        if folder == out.resolve() and not (folder / RECORDING_FILE).exists():
            continue
        name = (folder.parent if folder.is_file() else folder).name
        if recordings.setdefault(name, given).resolve() != folder:
            what = f"two recordings are called {name}: {recordings[name]} and {given}"
            raise Refused("run", what, "run them into different --out folders")
    if not recordings:
        raise Refused("run", "no recording is given", f"name folders with a {RECORDING_FILE}")
    return recordings


def named_twice(folders: Sequence[Path], recordings: Mapping[str, Path]) -> dict[Path, Path]:
    """Of folders that were given, those that are links to one of the recordings, which are run once: each with that one."""
    first = {folder.resolve(): folder for folder in recordings.values()}
    meant = {given: first.get(given.resolve(), given) for given in folders}
    return {given: one for given, one in meant.items() if one.absolute() != given.absolute()}


def run_batch(
    folders: Mapping[str, Path], options: BatchOptions, progress: Callable[[int], object]
) -> dict[str, RecordingOutcome]:
    """Runs the recordings in `folders`, by name, and returns what became of each, in the same order.

    One with a result that still holds is not run again, nor one that was refused, unless `options.redo`. `progress` is called
    with the number of recordings that ended. Raises Refused where there are no workers, or they are lost.
    """
    options = replace(options, out=options.out.resolve(), shared=options.shared.resolved())
    outcomes: dict[str, RecordingOutcome] = {}
    pending: dict[str, Recording] = {}
    for name, folder in folders.items():
        try:
            recording = read_recording(folder.resolve(), options.shared)
            earlier = None if options.redo else _earlier_outcome(name, recording, options)
        except Refused as refusal:
            failure = without_folder(folder.resolve(), str(refusal))
            outcomes[name] = RecordingOutcome(name, None, failure, done_before=False)
            continue
        if earlier is None:
            pending[name] = recording
        else:
            outcomes[name] = earlier
    progress(len(outcomes))
    for outcome in _run_pending(pending, options) if pending else ():
        outcomes[outcome.name] = outcome
        progress(1)
    return {name: outcomes[name] for name in folders}


def _earlier_outcome(name: str, recording: Recording, options: BatchOptions) -> RecordingOutcome | None:
    """What an earlier run came to, or None where there is nothing that still holds."""
    if record := stored_result(recording, options.out / name, options.rerun):
        return RecordingOutcome(name, record, None, done_before=True)
    refused = stored_refusal(recording, options.out / name)
    return None if refused is None else RecordingOutcome(name, None, refused, done_before=True)


def _run_pending(pending: Mapping[str, Recording], options: BatchOptions) -> Iterator[RecordingOutcome]:
    """Runs recordings on the workers; yields each as it ends."""
    from xneck.batch.recording_task import run_recording_task  # a batch without pending recordings needs no stage

    files = [path for recording in pending.values() for path in (recording.config, *recording.files.values())]
    jobs = min(options.jobs or available_cores(), len(pending))
    tasks = {
        name: (recording, options.out / name, options.rerun, no_progress, True) for name, recording in pending.items()
    }
    try:
        with worker_pool(jobs, options.cluster, options.out, files) as client:
            for task in run_tasks(client, run_recording_task, tasks):
                failure = None if task.failure is None else without_folder(pending[task.name].folder, task.failure)
                yield RecordingOutcome(task.name, task.result, failure, done_before=False)
    finally:
        if options.cluster is None:  # those of a cluster may still be at work
            for name in pending:
                remove_partial_files(options.out / name)
