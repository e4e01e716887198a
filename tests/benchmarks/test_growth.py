"""Growth: recordings that are repeated are whole ones, and what is said of figures follows from them."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.clock_worlds import NECK_FILE, NOISE
from benchmarks.growth import FLAT, Spent, _spent, words
from benchmarks.repeated import repeat_recording, repeat_video
from samples.generator.prescribed import World, prescribe
from vision.video import describe
from xneck.errors import Refused
from xneck.strict_yaml import parse

VIDEO = Path(__file__).parents[2] / "samples/recording/video.mp4"


def test_a_repeated_recording_is_one_recording() -> None:
    """Clocks run on as they were, the log has no hole, motors do not jump, and frames show what they showed a turn ago."""
    made = prescribe(World(parse(NECK_FILE.read_text(), "neck.yaml")), 5.0, 3)
    angles, log = repeat_recording(made, NOISE, 3)
    rows, count = len(made.log_time), len(made.frame_times)
    assert (len(log.time), len(angles.time)) == (3 * rows, 3 * count)
    assert np.diff(log.time) == pytest.approx(np.diff(made.log_time)[0], abs=1e-9)
    at = made.clocks.log_time(angles.time)
    assert at[-count:] - at[:count] == pytest.approx(log.time[2 * rows] - log.time[0], abs=1e-9)
    assert np.std(angles.alpha - np.tile(made.frame_alpha, (3, 1))) == pytest.approx(NOISE, rel=0.1)
    steps = np.abs(np.diff(log.matrix("theta"), axis=0)).max(axis=1)
    assert steps[rows - 1] < steps.max()


def test_a_repeated_video_has_all_its_frames(tmp_path: Path) -> None:
    """Counted in its index, and in the pieces that are followed one by one; the second turn comes after the first."""
    twice = tmp_path / "twice.mp4"
    repeat_video(VIDEO, twice, 2)
    once, both = describe(VIDEO), describe(twice)
    assert both.frames == 2 * once.frames
    assert sum(piece.count for piece in both.segments) == both.frames
    assert both.segments[-1].first > 2 * once.segments[-1].first


def test_what_a_command_takes_is_its_own() -> None:
    """Not the memory of the process that asks, here 800 MB."""
    held = np.ones(100_000_000)
    spent = _spent("decode", 24.0, VIDEO)
    assert held[-1] == 1
    assert 20 < spent.megabytes < 400
    assert spent.seconds > 0


def test_a_command_that_is_refused_ends_the_measurement_with_its_reason(tmp_path: Path) -> None:
    with pytest.raises(Refused, match=r"xneck check, 20 s: .*nothing\.mcap"):
        _spent("check", 20.0, tmp_path / "nothing.mcap")


def test_memory_is_flat_where_it_is() -> None:
    def said(megabytes: float) -> str:
        return words([Spent("sync", 20.0, 2.0, 100.0), Spent("sync", 1200.0, 60.0, megabytes)])

    assert said(99 * FLAT).endswith("100 to 109 MB: flat.")
    assert "20 s to 20 min" in said(100)
    assert "100 to 50 ms" in said(100)
    assert said(690).endswith("100 to 690 MB: 30 MB more a minute.")
