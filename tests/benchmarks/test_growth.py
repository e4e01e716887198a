"""Growth: recordings that are repeated are whole ones, and what is said of figures follows from them."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.growth import FLAT, Spent, of_data, spent, words
from benchmarks.long_recordings import chain, repeat_video
from samples.generator.prescribed import World, prescribe
from samples.worlds.clock_worlds import NECK_FILE, NOISE_RAD
from tests.paths import SAMPLES
from vision.video import describe_video
from xneck_foundation.errors import Refused
from xneck_foundation.strict_yaml import parse_yaml

VIDEO = SAMPLES / "recording/video.mp4"


def test_motions_one_after_another_are_one_recording() -> None:
    """The log has no hole, motors do not jump, and by the clocks of the first motion frames show where the arm was in the last."""
    world = World(parse_yaml(NECK_FILE.read_text(), "neck.yaml"))
    angles, log = chain(world, 5.0, 3, 4, NOISE_RAD)
    first, *_, last = made = [prescribe(world, 5.0, [4, turn]) for turn in range(3)]
    assert len(log.time) == sum(len(p.log_time) for p in made)
    assert np.diff(log.time) == pytest.approx(0.002, abs=1e-9)
    shift = log.time[-1] - last.log_time[-1]
    at = first.clocks.log_time(angles.time[-len(last.frame_times) :]) - shift
    assert at == pytest.approx(last.clocks.log_time(last.frame_times), abs=1e-6)
    assert np.std(angles.alpha - np.concatenate([p.frame_alpha for p in made])) == pytest.approx(NOISE_RAD, rel=0.1)
    steps = np.abs(np.diff(log.matrix("theta"), axis=0)).max(axis=1)
    assert steps[len(first.log_time) - 1] < 0.1 * steps.max()


def test_a_repeated_video_has_all_its_frames(tmp_path: Path) -> None:
    """Counted in its index, and in the pieces that are followed one by one; the second turn comes after the first."""
    twice = tmp_path / "twice.mp4"
    repeat_video(VIDEO, twice, 2)
    once, both = describe_video(VIDEO), describe_video(twice)
    assert both.frames == 2 * once.frames
    assert sum(piece.count for piece in both.segments) == both.frames
    assert both.segments[-1].first_stamp > 2 * once.segments[-1].first_stamp


def test_what_a_command_takes_is_its_own() -> None:
    """Not the memory of the process that asks, here 800 MB."""
    held = np.ones(100_000_000)
    decoding = spent("decode", 24.0, VIDEO)
    assert held[-1] == 1
    assert 20 < decoding.megabytes < 400
    assert decoding.seconds > 0


def test_a_command_that_is_refused_ends_the_measurement_with_its_reason(tmp_path: Path) -> None:
    with pytest.raises(Refused, match=r"xneck check, 20 s: .*nothing\.mcap"):
        spent("check", 20.0, tmp_path / "nothing.mcap")


def test_memory_is_flat_where_it_is() -> None:
    def said(megabytes: float) -> str:
        return words([Spent("sync", 20.0, 2.0, 100.0), Spent("sync", 1200.0, 60.0, megabytes)])

    assert said(99 * FLAT).endswith("100 to 109 MB: flat.")
    assert "20 s to 20 min" in said(100)
    assert "100 to 50 ms" in said(100)
    assert said(690).endswith("100 to 690 MB: 30 MB more a minute.")


def test_two_hours_fit_into_a_gigabyte(tmp_path: Path) -> None:
    """By the peaks of 160 and 320 s, in parts of the same length.

    From there the peak may grow, to stay below 1000 MB in two hours, by what is left of them in the share of the two hours that
    160 s are; 40 MB are what one run differs from the next. A command that held the recording would take 160 MB more. `identify`
    takes stretches of 300 s together of a recording of any length (tests/xneck/cli/test_sample.py).
    """
    short, long = ({one.stage: one for one in of_data(_folder(tmp_path, n), n, ("sync", "check"))} for n in (8, 16))
    for stage, one in short.items():
        more, seconds = long[stage].megabytes - one.megabytes, long[stage].length - one.length
        left = (1000 - one.megabytes) * seconds / (7200 - one.length)
        assert more < left + 40, (stage, one, long[stage])


def _folder(inside: Path, turns: int) -> Path:
    folder = inside / str(turns)
    folder.mkdir()
    return folder
