"""How each stage grows with the length of a recording: processor time for each second of it, and peak memory.

Every stage is the command of that name in a process of its own, reading and writing files, on one core; decoding alone stands
beside `extract`. The video is the sample's over and over, angles and log of the other stages are motions of 20 s one after the
other. Time has what it takes to load Python's libraries in it, which counts in the short recordings. `extract` is left out of
the two hours, which it would take for hours.

    python -m benchmarks.growth                     the whole table, an hour or more
    python -m benchmarks.growth --data 1 6 60       without videos, up to 20 min
"""

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.hard import true_camera
from benchmarks.long_recordings import chain, repeat_video
from benchmarks.table import Claim, Table
from calibration.camera_file import write_camera
from identification.dataset.dataset_file import export_series
from samples.generator.camera import SAMPLE_CAMERA
from samples.generator.prescribed import World
from samples.worlds.clock_worlds import NECK_FILE, NOISE_RAD
from synchronisation.angles import write_angles
from xneck_foundation.errors import Refused
from xneck_foundation.strict_yaml import parse_yaml

SAMPLES = Path(__file__).parents[1] / "samples"
VIDEO_S, TURN_S = 24, 20
"""one turn of the video, and of angles and log"""
VIDEO_TURNS, TURNS = (1, 5, 50), (1, 6, 60, 360)
"""24 s or 20 s, 2 min, 20 min; of angles and log two hours too"""
DATA_STAGES = ("sync", "check", "identify", "simulate", "diagnose")
"""that need no video"""
FLAT = 1.1
"""times the memory of the shortest recording, up to which that of the longest counts as the same"""
COLUMNS = ("s", "ms per s", "peak MB")


@dataclass(frozen=True)
class Spent:
    """What a stage took for a recording of `length` s."""

    stage: str
    length: float
    seconds: float
    """of the processor"""
    megabytes: float

    @property
    def each(self) -> float:
        """ms for each second of the recording."""
        return 1e3 * self.seconds / self.length


def measure(video_turns: Sequence[int] = VIDEO_TURNS, turns: Sequence[int] = TURNS) -> Table:
    """For each length how long the recording is, the processor's ms for each second of it, and the peak of memory."""
    found: list[Spent] = []
    with tempfile.TemporaryDirectory() as folder:
        for count in video_turns:
            found += _of_video(Path(folder), count)
        for count in turns:
            found += of_data(Path(folder), count)
    return table_of(found)


def table_of(found: Sequence[Spent]) -> Table:
    """Their figures stage by stage, the shortest recording first."""
    stages = {one.stage: [s for s in found if s.stage == one.stage] for one in found}
    ordered = [one for series in stages.values() for one in series]
    rows = tuple((f"{s.stage}, {minutes(s.length)}", (s.length, s.each, s.megabytes)) for s in ordered)
    title = f"Growth with length, {minutes(found[0].length)} to {minutes(max(s.length for s in found))}"
    claims = tuple(claim for series in stages.values() for claim in _claims(series, stages.get("decode", ())))
    return Table(title, COLUMNS, rows, claims, tuple(map(words, stages.values())))


def words(series: Sequence[Spent]) -> str:
    """What a stage's figures, shortest recording first, say of longer ones."""
    first, last = series[0], series[-1]
    more = (last.megabytes - first.megabytes) / (last.length - first.length) * 60
    memory = "flat" if last.megabytes < FLAT * first.megabytes else f"{more:.3g} MB more a minute"
    return (
        f"{first.stage}: from {minutes(first.length)} to {minutes(last.length)} the time for each second goes from "
        f"{first.each:.3g} to {last.each:.3g} ms, memory from {first.megabytes:.0f} to {last.megabytes:.0f} MB: {memory}."
    )


def minutes(seconds: float) -> str:
    """`20 s`, `2 min`."""
    return f"{seconds:g} s" if seconds < 60 else f"{seconds / 60:g} min"


def _claims(series: Sequence[Spent], decoding: Sequence[Spent]) -> Iterator[Claim]:
    """The longest recording beside the one before it, in time, and beside the shortest, in memory."""
    if len(series) < 2:
        return
    first, before, last = series[0], series[-2], series[-1]
    on, stage = minutes(last.length), last.stage
    limit = ("decoding alone", decoding[-1].each) if stage == "extract" and decoding else None
    yield Claim(f"{stage}: ms a second of the recording", on, last.each, (minutes(before.length), before.each), limit)
    yield Claim(f"{stage}: peak of memory, MB", on, last.megabytes, (minutes(first.length), first.megabytes))


def _of_video(folder: Path, turns: int) -> Iterator[Spent]:
    video, camera = folder / "video.mp4", folder / "camera.yaml"
    repeat_video(SAMPLES / "recording/video.mp4", video, turns)
    write_camera(true_camera(SAMPLE_CAMERA), camera)
    files = ["--camera", camera, "--neck", SAMPLES / "recording/neck.yaml", "--out", folder / "angles.mcap"]
    yield spent("decode", turns * VIDEO_S, video)
    yield spent("extract", turns * VIDEO_S, video, *files, "--quiet")


def of_data(folder: Path, turns: int, stages: Sequence[str] = DATA_STAGES) -> Iterator[Spent]:
    """What the stages took, files in `folder`; `sync` comes first, and is needed by the others."""
    length = turns * TURN_S
    data, model, simulated = folder / "fitted.mcap", folder / "model.yaml", folder / "simulated.mcap"
    calls: dict[str, tuple[object, ...]] = {
        "check": (data,),
        "identify": (data, "--out", model),
        "simulate": (data, "--model", model, "--out", simulated),
        "diagnose": (data, "--held-out", folder / "held_out.mcap", "--out", folder / "diagnosis"),
    }
    yield _synced(data, turns, 1)
    if "diagnose" in stages:
        _synced(folder / "held_out.mcap", turns, 2)
    for stage in stages[1:]:
        yield spent(stage, length, *calls[stage], "--quiet")


def _synced(data: Path, turns: int, seed: int) -> Spent:
    """The data set of one recording, and what `sync` took for it."""
    angles, log = chain(World(parse_yaml(NECK_FILE.read_text(), str(NECK_FILE))), TURN_S, turns, seed, NOISE_RAD)
    files = data.with_suffix(".angles.mcap"), data.with_suffix(".csv")
    write_angles(angles, files[0])
    export_series(log, files[1])
    return spent("sync", turns * TURN_S, *files, "--neck", NECK_FILE, "--out", data, "--quiet")


def spent(stage: str, length: float, *words: object) -> Spent:
    """Of `xneck STAGE WORDS...`, on one core."""
    call = [sys.executable, "-m", "benchmarks.command_process", stage, *map(str, words)]
    alone = os.environ | dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    done = subprocess.run(call, capture_output=True, text=True, env=alone, cwd=Path(__file__).parents[1])
    if done.returncode:
        raise Refused(f"xneck {stage}, {minutes(length)}", " ".join(done.stderr.split("\n")[-2:]).strip())
    seconds, megabytes = done.stdout.splitlines()[-1].split()
    return Spent(stage, length, float(seconds), float(megabytes))


def main() -> None:
    """The table, of lengths that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--video", nargs="*", type=int, default=(), help=f"turns of the video, {VIDEO_S} s each")
    parser.add_argument("--data", nargs="*", type=int, default=(), help=f"turns of angles and log, {TURN_S} s each")
    asked = parser.parse_args()
    lengths = (asked.video, asked.data) if asked.video or asked.data else (VIDEO_TURNS, TURNS)
    print(measure(*lengths).text())


if __name__ == "__main__":
    main()
