"""Runs over arms integrated forward: each arm seen through several noises, one record a run, kept in a folder.

What was run before is read back, so that a run of hours can be stopped at any time. All noises of an arm are of one integration:
the camera's clock, its exposure, the frames that are lost and the numbers that noise is drawn from are the same.
"""

import argparse
import json
import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.figures.rate import Rate
from benchmarks.tuned_seeds import FIRST_COUNTED_FORWARD_ARM
from identification.dataset.dataset import DataSet
from identification.dataset.series import Series, numbered_columns
from mechanism.description import Neck
from samples.forward_arms.arms import Arm, Recording, make_arms
from samples.forward_arms.camera import Film
from samples.forward_arms.drawing import drawn, neck
from samples.forward_arms.laws import Law
from samples.forward_arms.plant import ROW, Plant
from samples.forward_arms.settings import Settings
from synchronisation.angles import Angles
from synchronisation.synchronise import synchronise
from xneck_foundation.errors import Refused
from xneck_foundation.json_text import json_text, read_record
from xneck_foundation.source_digest import source_digest
from xneck_foundation.whole_file import write_text

Record = dict[str, Any]

FOLDER_VARIABLE = "XNECK_ARM_RUNS"
"""environment variable: folder in which topics keep their runs, whatever sources these were made by"""
SETTINGS = Settings(base="exact", seconds=60.0, recordings=2, sigma_columns=True, step=ROW, columns=64)


@dataclass(frozen=True)
class Scene:
    """Arms of one kind: what is hidden in each of them, under a name."""

    name: str
    laws: Callable[[Plant], Sequence[Law]] = lambda drawing: ()
    """of the arm as drawn"""


@dataclass(frozen=True)
class SeenArm:
    """An arm with its recordings as the camera has them at one noise."""

    arm: Arm
    films: tuple[Film, ...]

    @property
    def neck(self) -> Neck:
        """The arm as drawn."""
        return Neck.model_validate_json(json.dumps(neck(self.arm.drawing)))

    def synchronised(self, recording: int) -> DataSet:
        """The data set of a recording, counted from 0."""
        return synchronised(self.neck, self.arm.recordings[recording], self.films[recording])


@dataclass(frozen=True)
class Runs:
    """Every scene with every arm at every noise, and where records of them are kept."""

    folder: Path
    scenes: Sequence[Scene]
    seeds: Sequence[int]
    noises: Sequence[float]
    """deg"""
    settings: Settings = SETTINGS

    def file(self, scene: Scene, seed: int, noise: float) -> Path:
        """Where a run's record is kept."""
        return self.folder / f"{scene.name}_arm{seed}_noise{noise:g}_{self.settings.seconds:g}s.json"

    def done(self, scene: Scene, noise: float) -> list[Record]:
        """Records of the runs that were made, in the order of the arms."""
        files = (self.file(scene, seed, noise) for seed in self.seeds)
        return [read_record(file) for file in files if file.exists()]

    def sources(self) -> str:
        """Which sources the records were made by, in a sentence."""
        records = [record for scene in self.scenes for noise in self.noises for record in self.done(scene, noise)]
        counts = {source: sum(r["source"] == source for r in records) for source in {r["source"] for r in records}}
        made = ", ".join(f"{count} by {source}" for source, count in sorted(counts.items()))
        return f"Runs by digest of the sources: {made}."

    def complete(self, judged: Callable[[SeenArm], Record]) -> Iterator[Record]:
        """Makes the runs that are missing, all scenes and noises of an arm before the next one, and writes each record at once.

        An arm that is refused has a record with the reason under `refused`.
        """
        source = sources_digest()  # before hours in which the sources may change
        self.folder.mkdir(parents=True, exist_ok=True)
        missing = [
            (scene, seed, noises)
            for seed in self.seeds
            for scene in self.scenes
            if (noises := [noise for noise in self.noises if not self.file(scene, seed, noise).exists()])
        ]
        hidden = [scene.laws(drawn(self.settings, seed)) for scene, seed, _ in missing]
        arms = make_arms([seed for _, seed, _ in missing], self.settings, hidden)
        for (scene, seed, noises), arm in zip(missing, arms, strict=True):
            for noise in noises:
                heading = {"scene": scene.name, "seed": seed, "noise_deg": noise, "source": source}
                record = heading | _outcome(judged, seen(arm, self.settings, noise))
                write_text(self.file(scene, seed, noise), json_text(record))
                yield record


def sources_digest() -> str:
    """Digest of the packages and of the generator."""
    return source_digest(Path(__file__).parents[1] / "samples" / "forward_arms")


def _outcome(judged: Callable[[SeenArm], Record], arm: SeenArm) -> Record:
    try:
        return judged(arm)
    except Refused as refused:
        return {"refused": str(refused)}


def seen(arm: Arm, settings: Settings, noise: float) -> SeenArm:
    """The arm through a camera with this noise, deg."""
    noisy = replace(settings, noise_deg=noise)
    films = [
        r.truth.filmed(noisy, [arm.seed, 2 + i, 1]) for i, r in enumerate(arm.recordings, settings.first_recording)
    ]
    return SeenArm(arm, tuple(films))


def synchronised(described: Neck, recording: Recording, film: Film) -> DataSet:
    """The data set of a recording, its angles with their sigmas."""
    angles = Angles(film.stamp, film.seen, np.full_like(film.seen, film.noise))
    log = Series(recording.time, numbered_columns("theta", recording.theta) | numbered_columns("f", recording.f))
    return synchronise(described, "", angles, log, {})


def verdict(record: Mapping[str, Any]) -> str:
    """Of a run's diagnosis; `refused` where there is none."""
    return "refused" if "refused" in record else record["verdict"]


def percent(rate: Rate) -> tuple[float | None, float | None, float | None]:
    """A rate and the ends of its 95 % interval, in per cent; None where nothing was counted."""
    return (100 * rate.count / rate.of, *rate.interval_percent) if rate.of else (None, None, None)


def topic_folder(topic: str) -> Path:
    """Where a topic keeps its runs: as the environment says, else in a folder of these sources."""
    return Path(os.environ.get(FOLDER_VARIABLE) or f"out/arm_runs/{sources_digest()}") / topic


def main(
    module: str,
    description: str,
    runs: Callable[[Path, Sequence[int], Sequence[float]], Runs],
    judged: Callable[[SeenArm], Record],
    defaults: tuple[Iterable[int], Sequence[float]],
    words: Sequence[str],
) -> int:
    """Command line of a topic without its table: makes the runs that a folder lacks; 130 where it was interrupted."""
    parser = argparse.ArgumentParser(
        prog=f"python -m {module}", description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True, help="folder of the records")
    parser.add_argument("--seeds", type=seed_range, default=list(defaults[0]), metavar="FIRST-LAST", help="of the arms")
    parser.add_argument(
        "--noises", type=float, nargs="+", default=list(defaults[1]), metavar="DEG", help="of the angles"
    )
    parser.add_argument("--share", type=share, default=(0, 1), metavar="I/N", help="every N-th arm from the I-th on")
    chosen = parser.parse_args(words)
    first, every = chosen.share
    try:
        for record in runs(chosen.out, chosen.seeds[first::every], chosen.noises).complete(judged):
            said = record.get("refused") or " ".join([record["verdict"], *record["causes"]])
            print(f"{record['scene']}, arm {record['seed']}, {record['noise_deg']:g} deg: {said}", flush=True)
    except KeyboardInterrupt:
        print("benchmarks: interrupted; what is done is kept", file=sys.stderr)
        return 130
    return 0


def seed_range(text: str) -> list[int]:
    """Such as `1003-1102`, or one seed; none below the first that is counted."""
    found = re.fullmatch(r"(\d+)(?:-(\d+))?", text)
    if found is None:
        raise argparse.ArgumentTypeError(f"{text} is no range of seeds such as 1003-1102")
    seeds = list(range(int(found[1]), int(found[2] or found[1]) + 1))
    if not seeds or seeds[0] < FIRST_COUNTED_FORWARD_ARM:
        raise argparse.ArgumentTypeError(f"seeds begin at {FIRST_COUNTED_FORWARD_ARM}, and increase")
    return seeds


def share(text: str) -> tuple[int, int]:
    """Such as `0/2`."""
    found = re.fullmatch(r"(\d+)/(\d+)", text)
    if found is None or int(found[1]) >= int(found[2]):
        raise argparse.ArgumentTypeError(f"{text} is no share such as 0/2 or 1/2")
    return int(found[1]), int(found[2])
