"""The clock between camera and log: log time = camera time + offset + skew (camera time - its middle).

Camera time is a frame's stamp, put right where frames were lost without a trace. The clock comes from the motion that both show
(motion_clock.py); where the controller switched a light that the video shows, that light (light.py) gives the offset and the skew.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from identification.dataset.clock_record import LostFrames
from identification.dataset.series import Series
from mechanism.arm import Arm
from synchronisation.angles import Angles
from synchronisation.clocks.clock_estimate import ClockEstimate
from synchronisation.clocks.light import edges_of, fit_light
from synchronisation.clocks.log_gaps import RepairedLog, repair_log
from synchronisation.clocks.motion_clock import clock_from_motion, stamped_period
from synchronisation.clocks.undetermined import ClockUndetermined
from xneck_foundation.one_blas_thread import one_blas_thread

Array = NDArray[np.float64]

MAX_QUARTZ_SKEW, SURE_SIGMA = 2e-4, 3.0
"""ratio, of two clocks that are each off by 100 ppm, and standard deviations beyond it that are said (docs/thresholds.md)"""
DISAGREEMENT_SIGMA = 4.0
"""a difference between the clocks of light and motion beyond so many of its standard deviations is a warning
(docs/thresholds.md)"""


@one_blas_thread
def fit_clock(arm: Arm, angles: Angles, log: Series, fv: Array | None = None) -> ClockEstimate:
    """Offset and skew from angles (camera clock) and a log as recorded; fv: (M,), N s/rad, NaN where not known.

    With a light in both (column `led` of the log, `angles.light`) offset and skew are the light's alone: the motion then only
    settles labels and lost frames, and its offset is kept beside the light's.

    Raises Refused where the two do not show the same motion, show too little of it, repeat so that a period could be mistaken,
    overlap too little, or where cables, angles or signs are exchanged.
    """
    repaired = repair_log(log)
    has_light = "led" in log.columns and angles.light is not None
    try:
        clock = clock_from_motion(arm, angles, repaired, fv)
    except ClockUndetermined:
        if not has_light:
            raise
        clock = _undetermined(arm, angles, repaired)
    clock = replace(clock, warnings=(*clock.warnings, *repaired.warnings()))
    if has_light:
        clock = _with_light(clock, angles, log)
    return replace(clock, warnings=(*clock.warnings, *_warnings_of_skew(clock)))


def _warnings_of_skew(clock: ClockEstimate) -> Iterator[str]:
    """What is said of clocks that surely run apart further than those of two devices do that nobody turns."""
    if abs(clock.skew) - SURE_SIGMA * clock.skew_sigma > MAX_QUARTZ_SKEW:
        apart = f"{1e6 * abs(clock.skew):.0f} +- {1e6 * clock.skew_sigma:.0f} ppm {'faster' if clock.skew > 0 else 'slower'}"
        yield (
            f"the log's clock runs {apart} than the camera's, and quartz keeps to less: was one of them slewed (NTP, PTP), "
            "or are the stamps of frames or log those of a nominal rate?"
        )


def _undetermined(arm: Arm, angles: Angles, repaired: RepairedLog) -> ClockEstimate:
    """What is left of a clock that the motion does not determine."""
    return ClockEstimate(
        offset=0.0,
        offset_sigma=np.inf,
        skew=0.0,
        skew_sigma=np.inf,
        middle=0.0,
        correlation=0.0,
        second_peak=0.0,
        residual_rms=np.zeros(arm.M),
        source="",
        lost=LostFrames(period=stamped_period(angles)),
        repaired=repaired,
        warnings=(),
    )


def _with_light(clock: ClockEstimate, angles: Angles, log: Series) -> ClockEstimate:
    """The clock with offset and skew of the light."""
    assert angles.light is not None
    notes = angles.notes.get("light", {})
    exposed = clock.lost.corrected(angles.time) + notes.get("later_s", 0.0)
    light = fit_light(*edges_of(log.time, log.columns["led"]), exposed, angles.light, notes.get("exposure_s", 0.0))
    motion_offset, warnings = None, clock.warnings
    if np.isfinite(clock.offset_sigma):
        motion_offset = (clock.offset + clock.skew * (light.middle - clock.middle), clock.offset_sigma)
        difference = motion_offset[0] - light.offset
        if abs(difference) > DISAGREEMENT_SIGMA * np.hypot(clock.offset_sigma, light.offset_sigma):
            warnings = (*warnings, f"cables and arm put the clock {1e3 * difference:+.2f} ms away from the light")
    return replace(
        clock,
        offset=light.offset,
        offset_sigma=light.offset_sigma,
        skew=light.skew,
        skew_sigma=light.skew_sigma,
        middle=light.middle,
        source="light",
        warnings=warnings,
        light=light,
        motion_offset=motion_offset,
    )
