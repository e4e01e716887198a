"""Undecided diagnoses, and the motion that comes with them: how often it settles them, against a motion of the usual kind.

Arms off their drawing, with one effect of the catalogue hidden or nothing, move slowly and little, under one tension. Where the
verdict is `ambiguous` or `insufficient`, the arm plays the motion that `xneck diagnose` writes for it, and another time a motion
of the usual kind, as long, as fast and about as far. Each is diagnosed together with the recording that left it open. A case is
settled where the hidden effect is then named alone, or, with nothing hidden, the verdict is `consistent`. Cases are kept, and runs
go on where they were stopped.

`python -m benchmarks.deciding_motions --out FOLDER [--seeds 1500-1502] [--share 0/2]` makes the cases alone.
"""

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from benchmarks.figures.rate import Rate
from benchmarks.forward_arm_runs import (
    Record,
    Scene,
    percent,
    seed_range,
    seen,
    share,
    sources_digest,
    topic_folder,
)
from benchmarks.ladder import OFF_DRAWING, RUNG_1, RUNG_2, hidden_in
from benchmarks.table import Table
from benchmarks.verdict_record import verdict_record
from diagnosis.deciding_motion import DecidingMotion, answers_json, deciding_motion
from diagnosis.diagnose import diagnose
from identification.dataset.dataset import DataSet
from identification.design.trajectory import USUAL_LIMITS
from samples.forward_arms.arms import make_arms
from samples.forward_arms.drawing import drawn
from samples.forward_arms.given_motion import GivenMotion
from samples.forward_arms.laws import Law
from samples.forward_arms.settings import Settings
from xneck_foundation.errors import Refused
from xneck_foundation.json_text import json_text, read_record
from xneck_foundation.whole_file import write_text

SEEDS = range(1601, 1603)
SCENES = (RUNG_1, *RUNG_2)
NOISE_DEG = 0.03
USUAL = replace(OFF_DRAWING, seconds=12.0, recordings=1, first_recording=1, offset=(-0.2, 0.2), columns=128)
"""the motion of the usual kind; clocks that begin closer together save time"""
POOR = replace(USUAL, first_recording=0, motion="slow", tension="constant", peak_deg=(7.0, 12.0))
LIMITS = replace(USUAL_LIMITS, speed=USUAL.motor_speed)
"""of the designed motion: no faster than the usual one, and no further than that goes on the mean"""
UNDECIDED = ("ambiguous", "insufficient")


@dataclass(frozen=True)
class Case:
    """An arm with something hidden in it, or nothing."""

    scene: Scene
    seed: int

    @property
    def laws(self) -> Sequence[Law]:
        """What is hidden."""
        return self.scene.laws(drawn(POOR, self.seed))

    def file(self, folder: Path) -> Path:
        """Where its record is kept."""
        return folder / f"{self.scene.name}_arm{self.seed}.json"


def cases(seeds: Sequence[int], scenes: Sequence[Scene] = SCENES) -> list[Case]:
    """Every scene with every seed."""
    return [Case(scene, seed) for seed in seeds for scene in scenes]


def complete(folder: Path, wanted: Sequence[Case]) -> Iterator[Record]:
    """Makes the cases that the folder lacks, and writes each record as soon as it is decided, or both motions were played."""
    source = sources_digest()
    folder.mkdir(parents=True, exist_ok=True)
    missing = [case for case in wanted if not case.file(folder).exists()]
    open_cases: list[tuple[Case, Record, DataSet, DecidingMotion]] = []
    for case, data in zip(missing, _recordings(missing, POOR), strict=True):
        record: Record = {"scene": case.scene.name, "seed": case.seed, "source": source}
        record["poor"], motion = _first_verdict(data)
        if motion and not isinstance(data, str):
            record["asked"] = answers_json(motion)
            open_cases.append((case, record, data, motion))
        else:
            write_text(case.file(folder), json_text(record))
            yield record
    # both by one integration, each arm twice: clocks and noise of both are the same
    twice = [case for case, *_ in open_cases for _ in range(2)]
    given = [played for *_, motion in open_cases for played in (_given(motion), None)]
    second = _recordings(twice, USUAL, given)
    for (case, record, data, _), by_design, as_usual in zip(open_cases, second, second, strict=True):
        record["designed"], record["usual"] = _verdict(data, by_design), _verdict(data, as_usual)
        write_text(case.file(folder), json_text(record))
        yield record


def _recordings(
    chosen: Sequence[Case], settings: Settings, motions: Sequence[GivenMotion | None] | None = None
) -> Iterator[DataSet | str]:
    """The synchronised recording of each case, or why it was refused."""
    arms = make_arms([case.seed for case in chosen], settings, [case.laws for case in chosen], motions)
    for arm in arms:
        try:
            yield seen(arm, settings, NOISE_DEG).synchronised(0)
        except Refused as refused:
            yield str(refused)


def _first_verdict(data: DataSet | str) -> tuple[Record, DecidingMotion | None]:
    """Of the poor motion, and the motion that comes with it where it is undecided."""
    if isinstance(data, str):
        return {"refused": data}, None
    try:
        found = diagnose([data])
        return verdict_record(found), deciding_motion(found, [data], LIMITS)
    except Refused as refused:
        return {"refused": str(refused)}, None


def _verdict(poor: DataSet, other: DataSet | str) -> Record:
    """Of both recordings together."""
    if isinstance(other, str):
        return {"refused": other}
    try:
        return verdict_record(diagnose([poor, other]))
    except Refused as refused:
        return {"refused": str(refused)}


def _given(motion: DecidingMotion) -> GivenMotion:
    m = motion.designed.motion
    return GivenMotion(m.time, m.alpha, m.tension)


def is_undecided(record: Record) -> bool:
    """Whether the poor motion left it open, and both others were played."""
    return record["poor"].get("verdict") in UNDECIDED and "designed" in record


def settles(record: Record, kind: str) -> bool:
    """Whether a verdict names what was hidden alone, or is `consistent` where nothing was; kind: designed or usual."""
    said, hidden = record[kind], hidden_in(record["scene"], record)
    if not hidden:
        return said.get("verdict") == "consistent"
    return said.get("verdict") == "cause" and said["sets"] == [hidden]


def measure(seeds: Sequence[int] = SEEDS, folder: Path | None = None) -> Table:
    """How many undecided cases each motion settles; misleads: names something else alone, or calls what is hidden consistent."""
    folder, wanted = folder or topic_folder("deciding_motions"), cases(seeds)
    for _ in complete(folder, wanted):
        pass
    return table([read_record(case.file(folder)) for case in wanted])


def table(records: Sequence[Record]) -> Table:
    """What the records come to, a row for each motion."""
    columns = ("arms", "undecided", "settled", "settled, %", "95 % from", "to", "misled")
    undecided = [record for record in records if is_undecided(record)]
    rows = []
    for kind in ("designed", "usual"):
        settled = sum(settles(record, kind) for record in undecided)
        misled = sum(
            record[kind].get("verdict") in ("cause", "consistent", "unknown") and not settles(record, kind)
            for record in undecided
        )
        rate = percent(Rate(settled, len(undecided)))
        rows.append((f"{kind} motion", (len(records), len(undecided), settled, *rate, misled)))
    title = f"Undecided after {POOR.seconds:g} s of poor motion, then {USUAL.seconds:g} s more"
    return Table(title, columns, tuple(rows))


def main(words: Sequence[str]) -> int:
    """Makes the cases that a folder lacks; 130 where it was interrupted."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.deciding_motions",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--out", type=Path, required=True, help="folder of the records")
    parser.add_argument("--seeds", type=seed_range, default=list(SEEDS), metavar="FIRST-LAST", help="of the arms")
    parser.add_argument("--share", type=share, default=(0, 1), metavar="I/N", help="every N-th case from the I-th on")
    chosen = parser.parse_args(words)
    first, every = chosen.share
    wanted = cases(chosen.seeds)[first::every]
    try:
        for record in complete(chosen.out, wanted):
            said = ", ".join(
                f"{kind} {_said(record[kind])}" for kind in ("poor", "designed", "usual") if kind in record
            )
            print(f"{record['scene']}, arm {record['seed']}: {said}", flush=True)
    except KeyboardInterrupt:
        print("benchmarks: interrupted; what is done is kept", file=sys.stderr)
        return 130
    print(table([read_record(case.file(chosen.out)) for case in wanted]).text())
    return 0


def _said(verdict: Record) -> str:
    return verdict.get("refused") or " ".join([verdict["verdict"], *("/".join(names) for names in verdict["sets"])])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
