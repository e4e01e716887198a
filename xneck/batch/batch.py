"""Many recordings: which are there, which are done, and the others over the workers, none lost with the one that fails."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from xneck.batch.spread import cores, spread, workers
from xneck.recording.recording_folder import NAME, Recording, read_recording
from xneck.recording.result_folder import refusal_of, result_of, sweep, within
from xneck_foundation.errors import Refused


@dataclass(frozen=True)
class Asked:
    """How recordings are to be run."""

    out: Path
    """results go to folders of their names here"""
    jobs: int | None = None
    """processes on this machine; None: one a core"""
    cluster: str | None = None
    """a scheduler's address, in their stead"""
    redo: bool = False
    """also what holds still, and what was refused"""
    rerun: bool = False
    """with recording.rrd"""


@dataclass(frozen=True)
class Ended:
    """What became of a recording: its record as result.json holds it, or why there is none."""

    name: str
    record: dict[str, Any] | None
    failure: str | None
    """one line, or None where it did not fail"""
    before: bool
    """whether an earlier run came to this"""


def named(folders: Sequence[Path], out: Path) -> dict[str, Path]:
    """Recordings by their folders' names, each once. The folder `out`, which `*/` takes along, is left out.

    Raises Refused where two have the same name, or nothing is left.
    """
    places: dict[str, Path] = {}
    for given in folders:
        place = given.resolve()
        if place == out.resolve() and not (place / NAME).exists():
            continue
        name = (place.parent if place.is_file() else place).name
        if places.setdefault(name, given).resolve() != place:
            what = f"two recordings are called {name}: {places[name]} and {given}"
            raise Refused("run", what, "run them into different --out folders")
    if not places:
        raise Refused("run", "no recording is given", f"name folders with a {NAME}")
    return places


def run_batch(places: Mapping[str, Path], asked: Asked, step: Callable[[int], object]) -> dict[str, Ended]:
    """All recordings; `step` is told of each as it ends. In the order given.

    What holds still is not made again, nor is what was refused tried again, unless it is asked for.
    Raises Refused where there are no workers, or they are lost.
    """
    asked = replace(asked, out=asked.out.resolve())
    ended: dict[str, Ended] = {}
    left: dict[str, Recording] = {}
    for name, place in places.items():
        try:
            recording = read_recording(place.resolve())
            known = None if asked.redo else _known(name, recording, asked)
        except Refused as refusal:
            ended[name] = Ended(name, None, within(place.resolve(), str(refusal)), before=False)
            continue
        if known is None:
            left[name] = recording
        else:
            ended[name] = known
    step(len(ended))
    for one in _spread(left, asked) if left else ():
        ended[one.name] = one
        step(1)
    return {name: ended[name] for name in places}


def _known(name: str, recording: Recording, asked: Asked) -> Ended | None:
    if record := result_of(recording, asked.out / name, asked.rerun):
        return Ended(name, record, None, before=True)
    refused = refusal_of(recording, asked.out / name)
    return None if refused is None else Ended(name, None, refused, before=True)


def _spread(left: Mapping[str, Recording], asked: Asked) -> Iterator[Ended]:
    from xneck.recording.task import run_one  # what has nothing left to do needs none of the stages

    files = [path for recording in left.values() for path in (recording.config, *recording.files.values())]
    try:
        with workers(min(asked.jobs or cores(), len(left)), asked.cluster, asked.out, files) as client:
            for task in spread(client, run_one, {name: (r, asked.out / name, asked.rerun) for name, r in left.items()}):
                failure = None if task.failure is None else within(left[task.name].folder, task.failure)
                yield Ended(task.name, task.result, failure, before=False)
    finally:
        if asked.cluster is None:  # those of a cluster may still be at work
            for name in left:
                sweep(asked.out / name)
