"""Growth: recordings that are repeated are whole ones, and what is said of figures follows from them."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.clock_worlds import NECK_FILE, NOISE, arm
from benchmarks.growth import FLAT, Spent, _spent, words
from benchmarks.repeated import repeat_recording, repeat_video
from mechanism.cable_lengths import lengths
from samples.generator.prescribed import World, prescribe
from vision.video import describe
from xneck.errors import Refused
from xneck.strict_yaml import parse

VIDEO = Path(__file__).parents[2] / "samples/recording/video.mp4"


def test_a_repeated_recording_is_one_recording() -> None:
    """Clocks run on as one, the log has no hole, motors do not jump; frames and motors tell of the same motion in the last turn."""
    made = prescribe(World(parse(NECK_FILE.read_text(), "neck.yaml")), 5.0, 3)
    angles, log = repeat_recording(made, NOISE, 3)
    assert len(angles.time) == 3 * len(made.frame_times)
    assert np.diff(log.time) == pytest.approx(np.diff(made.log_time)[0], abs=1e-9)
    assert np.all(np.diff(angles.time) > 0)
    theta = log.matrix("theta")
    jump, usual = (np.abs(np.diff(t, axis=0)).max() for t in (theta[len(made.log_time) - 2 :][:4], theta))
    assert jump < usual
    at = made.clocks.log_time(angles.time)
    wound = np.stack([np.interp(at, log.time, t) for t in (arm().drum * theta).T], axis=-1)
    x = lengths(arm(), angles.alpha) + wound
    first, last = np.split(x, 3)[0], np.split(x, 3)[-1]
    cable = NOISE * np.sqrt(3) * arm().N * 0.05
    assert np.sqrt(np.mean((last - first) ** 2)) < cable, "noise alone: bars of 5 cm turned by it"


def test_a_repeated_video_has_all_its_frames(tmp_path: Path) -> None:
    """Counted in its index, and in the pieces that are followed by themselves; a turn starts with a key frame after the one before."""
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
