"""The clock of a light is compared with that of the motion at one and the same moment."""

import numpy as np
import pytest

from identification.dataset.clock_record import LostFrames
from identification.dataset.series import Series
from synchronisation.angles import Angles
from synchronisation.clocks.clock import _with_light
from synchronisation.clocks.clock_estimate import ClockEstimate
from synchronisation.clocks.log_gaps import repair_log

EXPOSURE_S = 0.01
SWITCHED_S = np.cumsum(np.random.default_rng(4).uniform(0.3, 0.7, 40)) + 100.0
"""s, log clock"""


def lit_until(t: np.ndarray) -> np.ndarray:
    """Seconds for which the light was on, which begins dark."""
    on = np.append(0.0, np.cumsum(np.diff(SWITCHED_S) * (np.arange(39) % 2 == 0)))
    return np.interp(t, SWITCHED_S, on)


def motion_clock(offset: float, log: Series) -> ClockEstimate:
    """Told to 0.1 ms at 5 s of the camera's clock; the log's runs 100 ppm faster."""
    return ClockEstimate(
        offset=offset,
        offset_sigma=1e-4,
        skew=1e-4,
        skew_sigma=1e-6,
        middle=5.0,
        correlation=1.0,
        second_peak=0.0,
        residual_rms=np.zeros(4),
        source="cables and arm",
        lost=LostFrames(period=1 / 30),
        repaired=repair_log(log),
        warnings=(),
    )


@pytest.mark.parametrize(("offset", "warnings"), [(2.0, 0), (2.01, 1)], ids=["agree", "differ"])
def test_only_clocks_that_differ_where_the_light_was_seen_are_said_to_differ(offset: float, warnings: int) -> None:
    """A hundred seconds after the middle of the motion 100 ppm are 10 ms."""
    camera = np.arange(100.0, 110.0, 1 / 30)
    middle = (camera[0] + camera[-1]) / 2
    at = camera + 2.0 + 1e-4 * (camera - 5.0)
    light = (lit_until(at + EXPOSURE_S / 2) - lit_until(at - EXPOSURE_S / 2)) / EXPOSURE_S
    time = np.arange(99.0, 120.0, 0.002)
    log = Series(time, {"led": (np.searchsorted(SWITCHED_S, time) % 2).astype(float)})
    notes = {"light": {"exposure_s": EXPOSURE_S}}
    angles = Angles(camera, np.zeros((len(camera), 3)), np.ones((len(camera), 3)), notes, 20 + 200 * light)
    clock = _with_light(motion_clock(offset, log), angles, log)
    assert clock.offset == pytest.approx(2.0 + 1e-4 * (middle - 5.0), abs=1.5e-3)
    assert clock.motion_offset == pytest.approx((offset + 1e-4 * (middle - 5.0), 1e-4))
    assert len(clock.warnings) == warnings
    assert all("ms away from the light" in words for words in clock.warnings)
