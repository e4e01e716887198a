"""A lost frame puts all cables off at once, a slip one cable for good: the clock takes neither for the other."""

import numpy as np
import pytest

from identification.dataset.series import Series, numbered_columns
from samples.worlds.clock_worlds import ClockRecording, arm, clock_recording, with_lost_frames
from synchronisation.clocks.clock import fit_clock
from synchronisation.clocks.clock_estimate import ClockEstimate


def slipped(made: ClockRecording, cable: int, size: float) -> Series:
    """The log with a step of the cable's travel, m, in the middle."""
    theta = made.log.matrix("theta").copy()
    theta[:, cable] += np.where(made.log.time > made.log.time.mean(), size / arm().drum[cable], 0.0)
    return Series(made.log.time, {**made.log.columns, **numbered_columns("theta", theta)})


def slips(clock: ClockEstimate) -> list[str]:
    return [warning for warning in clock.warnings if "moved on its drum" in warning]


@pytest.mark.parametrize(("kind", "seed", "share"), [("linear elastic", 7500, 0.01), ("everything", 3008, 0.05)])
def test_lost_frames_are_no_slips(kind: str, seed: int, share: float) -> None:
    """The first was refused with slips that were none, the second because a window of 12 s with 18 losses shows no motion of the
    log's. Frames are put right but for those of a loss while the arm rests at either end."""
    made = clock_recording(kind, seed, 30.0)
    angles, true, gone = with_lost_frames(made, share, seed)
    clock = fit_clock(arm(), angles, made.log)
    error = clock.log_time(angles.time) - made.clocks.log_time(true)
    assert not slips(clock)
    assert len(gone) - 2 <= sum(loss.frames for loss in clock.lost.losses) <= len(gone)
    assert np.mean(np.abs(error) < 1 / 60) > 0.95
    assert abs(np.median(error)) < 3.5 * clock.offset_sigma < 0.5e-3


def test_a_slip_is_no_loss_of_frames() -> None:
    """3 mm of cable 1: decoded as lost frames it would leave no clock."""
    made = clock_recording("everything", 3002, 30.0)
    clock = fit_clock(arm(), made.angles, slipped(made, 0, 3e-3))
    error = clock.log_time(made.angles.time) - made.clocks.log_time(made.angles.time)
    assert [warning[:50] for warning in slips(clock)] == ["cable 1 seems to have moved on its drum by +3.0 mm"]
    assert not clock.lost.losses
    assert abs(np.median(error)) < 3.5 * clock.offset_sigma < 0.5e-3
