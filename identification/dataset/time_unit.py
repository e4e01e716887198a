"""Whether times of rows or frames are in seconds, each row's its own: other units and rows that are written twice are named."""

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import MAX_TIME_S, Series
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

MAX_STEP_S = 0.25
"""s from row to row, or from frame to frame, in the median: more is another unit than seconds, or too rare (docs/thresholds.md)"""
MIN_STEP_S = 5e-4
"""s: a shorter step is not thought of where a unit is named (docs/thresholds.md)"""
MAX_REPEATED_SHARE = 0.1
"""share of stamps equal to the one before, beyond which digits are missing (docs/thresholds.md)"""
MIN_MEDIAN_STEP_S = 4.5e-5
"""s from row to row in the median: less, 22 kHz, is a longer unit than seconds (docs/thresholds.md)"""
MAX_LIKELY_STEP_S = 0.025
"""s: a longer step is not thought of where a longer unit is named (docs/thresholds.md)"""
_LEAST_SHARE, _LEAST_SPAN = 0.5, 0.1
"""of frames that are within a log, below which their unit is doubted; and of the log's length, which they cover in another unit
(docs/thresholds.md)"""
LONG_UNITS = (("minutes", 60.0), ("hours", 3600.0), ("days", 86400.0))
UNITS = (("milliseconds", 1e-3), ("microseconds", 1e-6), ("nanoseconds", 1e-9))


def check_repeated_rows(series: Series, where: str, what: str) -> None:
    """Refused where rows repeat the one before, time and all, and no others have its time; what: `rows` or `frames`."""
    stands = np.diff(series.time) == 0
    if len(stands) == 0 or np.mean(stands) <= MAX_REPEATED_SHARE:
        return
    rows = np.flatnonzero(stands)
    if all(np.array_equal(c[rows], c[rows + 1], equal_nan=True) for c in series.columns.values()):
        share = f"{100 * np.mean(stands):.0f} % of its {what}"
        raise Refused(where, f"{share} repeat the one before, its time too", f"write each of the {what} once")


def check_time_unit(time: Array, where: str, what: str) -> None:
    """Refused where finite stamps (T,) are in no seconds, number what they stamp, or lack digits; what: `rows` or `frames`."""
    steps = np.diff(time)
    if len(steps) == 0 or not np.all(np.isfinite(time)) or not np.any(steps > 0):
        return
    if (share := float(np.mean(steps == 0))) > MAX_REPEATED_SHARE:
        raise Refused(
            where,
            f"{100 * share:.0f} % of its {what} have the time of the one before: time is written with too few digits",
            "write it in seconds with six digits behind the point",
        )
    step = float(np.median(steps[steps > 0]))
    # of rows that come in bursts the mean step is that of a log
    if max(step, float(np.mean(steps))) < MIN_MEDIAN_STEP_S:
        _refuse_long_unit(time, step, where, what)
    if step <= MAX_STEP_S:
        return
    follow = f"{what} follow each other every {step:.6g} in the median, and times must be seconds"
    if step == 1.0 and np.all(steps == np.rint(steps)):
        raise Refused(
            where,
            f"time grows by one from {what[:-1]} to {what[:-1]}: it counts {what}, or milliseconds at 1000 Hz",
            f"write each {what[:-1]}'s time in seconds",
        )
    for name, unit in UNITS:
        if MIN_STEP_S <= step * unit <= MAX_STEP_S:
            raise Refused(where, f"time is in {name}: {follow}", _to_seconds(unit, what))
    raise Refused(where, follow, f"write seconds, and at least {1 / MAX_STEP_S:g} {what} in each")


def check_times_on_log(time: Array, log_time: Array, where: str) -> None:
    """Refused where most times of frames, (F,), are not within the log's, (T,), s: other units that would be are named.

    Frames that were taken now and then may be minutes apart: their steps tell no unit."""
    first, last = float(log_time[0]), float(log_time[-1])

    def share_within(unit: float) -> float:
        return float(np.mean((time * unit >= first) & (time * unit <= last)))

    share = share_within(1.0)
    if share >= _LEAST_SHARE:
        return
    outside = f"{100 * (1 - share):.0f} % of its frames are not within the log's times, {first:.6g} to {last:.6g} s"
    if len(time) > 2 and np.all(np.diff(time) == 1.0):
        raise Refused(where, f"time counts frames: {outside}", "write each frame's time in seconds, on the log's clock")
    for name, unit in (*UNITS, *LONG_UNITS):
        if share_within(unit) >= _LEAST_SHARE and np.ptp(time) * unit > _LEAST_SPAN * (last - first):
            raise Refused(where, f"time is in {name}: {outside}", _to_seconds(unit, "frames"))
    if share == 0:
        raise Refused(where, outside, "give angles on the log's clock")


def long_units(step: float) -> list[tuple[str, float]]:
    """Units longer than a second, with the seconds of each, in which a step is one from row to row of a log."""
    return [(name, unit) for name, unit in LONG_UNITS if MIN_STEP_S <= step * unit <= MAX_LIKELY_STEP_S]


def _refuse_long_unit(time: Array, step: float, where: str, what: str) -> None:
    """Refused: stamps (T,) whose median step is too short for seconds."""
    follow = f"{what} follow each other every {step:.3g} in the median, and times must be seconds"
    likely = long_units(step)
    if len(likely) != 1:
        raise Refused(where, follow, "is time in days or hours? write seconds")
    ((name, unit),) = likely
    too_late = abs(time[-1]) * unit > MAX_TIME_S
    do = f"subtract the first time from all, and multiply by {unit:g}" if too_late else _to_seconds(unit, what)
    raise Refused(where, f"time is in {name}: {follow}", do)


def _to_seconds(unit: float, what: str) -> str:
    """What makes seconds of times in a unit, s."""
    by_neck = f", or write log: {{time_scale: {unit:g}}} into neck.yaml" if what == "rows" else ""
    return f"multiply time by {unit:g}{by_neck}"
