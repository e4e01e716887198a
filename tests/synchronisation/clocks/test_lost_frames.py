"""Lost frames decoded from one cable's winding that is known but for what the cable does at rest."""

import numpy as np
import pytest

from synchronisation.clocks.frame_geometry import FrameGeometry
from synchronisation.clocks.lost_frames import decode_lost_frames
from synchronisation.clocks.signals import cubic_spline

PERIOD_S, ERROR_M = 1 / 30, 1e-4


def winding(time: np.ndarray) -> np.ndarray:
    """(T, 1), m: a second of rest with a slow sway, then a lively motion, then rest again."""
    lively = 0.02 * np.clip(time - 1, 0, 1) * np.clip(11 - time, 0, 1) * np.sin(4 * time)
    return (2e-4 * np.sin(3 * time) + lively)[:, None]


def decoded(true_time: np.ndarray, stamps: np.ndarray, disturbance: np.ndarray) -> np.ndarray:
    """Counts (F,) of frames at stamps, truly taken at other times, s, with a disturbance of their windings (F, 1), m."""
    log_time = np.arange(-1, 14, 0.01)
    seen = winding(true_time) + disturbance
    nothing = np.zeros((len(stamps), 1, 1))
    frames = FrameGeometry(
        time=stamps,
        alpha=seen,
        sigma=seen,
        correlation=np.eye(1),
        winding=seen,
        Z=nothing,
        winding_by_geometry=nothing,
        middle=6.0,
    )
    whitening = np.full((len(stamps), 1, 1), 1 / ERROR_M)
    return decode_lost_frames(frames, cubic_spline(log_time, winding(log_time)), (0.0, 0.0), whitening, PERIOD_S, 180)


@pytest.mark.parametrize("end", ["first", "last"])
def test_what_cables_do_at_rest_feigns_no_loss(end: str) -> None:
    """An error of five sigma in each frame of a rest, of the sign that frames taken later would have."""
    stamps = PERIOD_S * np.arange(360)
    rest = (stamps < 1) if end == "first" else (stamps > 11)
    sign = np.sign(np.cos(3 * stamps)) * (-1 if end == "first" else 1)
    disturbance = np.where(rest, 5 * ERROR_M * sign, 0.0)[:, None]
    assert np.ptp(decoded(stamps, stamps, disturbance)) == 0


def test_a_loss_in_motion_is_decoded() -> None:
    """One frame lost a second and a half before the motion ends."""
    stamps = PERIOD_S * np.arange(360)
    late = stamps >= 9.5
    count = decoded(stamps + PERIOD_S * late, stamps, np.zeros((360, 1)))
    assert np.array_equal(count - count[0], late.astype(int))


@pytest.mark.parametrize("frames_late", [3, 6])
def test_what_looks_late_for_a_while_feigns_no_loss(frames_late: int) -> None:
    """For a second and a half cables are where they would be some frames later, and then they are not."""
    stamps = PERIOD_S * np.arange(360)
    for first in (4.0, 6.5):
        passing = (stamps > first) & (stamps < first + 1.5)
        late = winding(stamps + PERIOD_S * frames_late) - winding(stamps)
        assert np.ptp(decoded(stamps, stamps, np.where(passing[:, None], late, 0.0))) == 0
