"""A long recording to one data set: one clock from all parts, then the state part by part, into a file.

Each part is the whole of what `synchronise` does with a short recording, with some seconds of its neighbours on either side, so
that filters and splines have settled where it begins. Priors of motion and laws of elongation are fitted to each part alone.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.columns_on_disk import SeriesOnDisk
from identification.dataset.dataset import DataSet
from identification.dataset.encoder_steps import count_angles
from identification.dataset.frames import FrameAngles
from identification.dataset.series import Series, concatenated
from identification.dataset.stretches import PART_S, consecutive_spans
from identification.fasquelle.series import FASQUELLE_CUTOFF_HZ, FASQUELLE_RATE_HZ, fasquelle_series
from mechanism.arm import Arm, arm_of
from mechanism.description import Neck
from state_estimation.motors import motors_of
from state_estimation.state import estimate_state
from synchronisation.angles import Angles
from synchronisation.check.check import Check, check_elongations
from synchronisation.check.checked_parts import merged_checks
from synchronisation.clocks.clock_estimate import ClockEstimate
from synchronisation.clocks.log_gaps import repair_log
from synchronisation.clocks.usable_frames import GAP_MARGIN_S
from synchronisation.encoder_counts import counts_warnings
from synchronisation.long.parts_clock import OVERLAP_S, clock_of_parts
from synchronisation.long.recording_parts import EvenRows, even_rows
from synchronisation.synchronise import COVARIANCE_HZ, UNCHECKED, clock_json, state_columns
from synchronisation.tested_sigma import with_tested_sigma
from synchronisation.thinned_log import forces_held, rows_left_out, rows_left_out_warning
from xneck_foundation.errors import Refused
from xneck_foundation.one_blas_thread import one_blas_thread

Array = NDArray[np.float64]

MAX_WHOLE_S = 1.5 * PART_S
"""s of a recording that is worked through at once (docs/thresholds.md)"""
MAX_WARNINGS = 8
"""warnings that are listed of the parts of a recording (docs/thresholds.md)"""


def is_long(log: Series) -> bool:
    """Whether a log is worked through in parts."""
    return log.time[-1] - log.time[0] > MAX_WHOLE_S


@one_blas_thread
def synchronise_parts(
    neck: Neck,
    neck_yaml: str,
    angles: Angles,
    log: Series,
    provenance: dict[str, Any],
    scratch: Path,
    cutoff: float = FASQUELLE_CUTOFF_HZ,
    progress: Callable[[int], object] = lambda steps: None,
) -> DataSet:
    """The data set of angles and log as `synchronise` gives it, of a long recording in memory that hardly grows with its length.

    The columns of its state lie on the disk of the folder `scratch`, until the data set is given up. progress: called with the
    number of steps done since the last call, of `steps_of`. Raises Refused as `synchronise` does, naming the part.
    """
    arm = arm_of(neck)
    angles, of_sigma = with_tested_sigma(angles.from_zero(neck.zero_angles))
    viscosity = np.array([np.nan if motor.fv is None else motor.fv for motor in neck.motors])
    clock = clock_of_parts(neck, arm, angles, repair_log(log), viscosity, progress)
    warnings = (*of_sigma, *counts_warnings(neck, log))
    if rows_left_out(log, clock):
        warnings = (*warnings, rows_left_out_warning(log, clock))
        held = repair_log(forces_held(log, clock))
        clock = clock_of_parts(neck, arm, angles, held, viscosity, lambda steps: None)
    left_out = len(clock.warnings) - MAX_WARNINGS
    more = (f"{left_out} more warnings of parts",) if left_out > 0 else ()
    clock = replace(clock, warnings=(*warnings, *clock.warnings[:MAX_WARNINGS], *more))
    recording = _Recording.of(neck, arm, angles, clock, count_angles(neck, log))
    first, last = recording.rows
    state = SeriesOnDisk(scratch, last - first)
    others = list[_Part]()
    for begin, end in _row_spans(recording):
        part = _part(recording, begin, end, cutoff)
        assert part.state is not None
        state.write(part.state)
        others.append(replace(part, state=None))
        progress(1)
    has_force = "f1" in log.columns
    notes = _merged_notes([part.notes for part in others])
    record = clock_json(clock, angles, log) | {"noise": angles.noise, "state": notes}
    return DataSet(
        neck=neck,
        neck_yaml=neck_yaml,
        state=state.series(),
        fasquelle=concatenated([part.fasquelle for part in others]),
        angles=angles.series,
        log=log,
        clock=record | {"parts": len(others)},
        check=merged_checks([p.check for p in others if p.check]).as_json() if has_force else dict(UNCHECKED),
        provenance={**provenance, "angles": angles.notes},
        covariance=concatenated([part.covariance for part in others]),
    )


def steps_of(angles: Angles) -> int:
    """Number of steps of `synchronise_parts`, about: each part's clock and each part's state."""
    return 2 * len(consecutive_spans(float(angles.time[0]), float(angles.time[-1])))


@dataclass(frozen=True)
class _Recording:
    """What all parts are cut from."""

    neck: Neck
    arm: Arm
    clock: ClockEstimate
    frames: FrameAngles
    known: NDArray[np.bool_]
    """(F,): frames with all angles"""
    log: EvenRows
    count_angles: Array
    """(M,), rad"""

    @classmethod
    def of(cls, neck: Neck, arm: Arm, angles: Angles, clock: ClockEstimate, count_angles: Array) -> "_Recording":
        frames = FrameAngles(clock.log_time(angles.time), angles.alpha, angles.white_sigma, angles.shared)
        return cls(neck, arm, clock, frames, angles.complete, even_rows(clock.repaired.log), count_angles)

    @property
    def rows(self) -> tuple[int, int]:
        """First row of the log within the video, and the one after the last."""
        time, (first, last) = self.log.time, self.frames.time[self.known][[0, -1]]
        return int(np.searchsorted(time, first)), int(np.searchsorted(time, last, side="right"))

    @property
    def decimation(self) -> int:
        """Rows of the log to each of Fasquelle's."""
        return max(1, round(1 / (FASQUELLE_RATE_HZ * float(np.median(np.diff(self.log.time[:1000]))))))


@dataclass(frozen=True)
class _Part:
    """What is made of one part, without what reaches into its neighbours."""

    state: Series | None
    fasquelle: Series
    covariance: Series
    check: Check | None
    notes: Mapping[str, Any]


def _row_spans(recording: _Recording) -> list[tuple[int, int]]:
    """First rows of all parts, and those after their last."""
    first, last = recording.rows
    if last - first < 2:
        raise Refused("sync", "log and video do not overlap", "are they of one recording?")
    time = recording.log.time
    edges = np.rint(np.linspace(first, last, len(consecutive_spans(time[first], time[last - 1])) + 1)).astype(int)
    return list(zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True))


def _part(recording: _Recording, begin: int, end: int, cutoff: float) -> _Part:
    """Rows begin to end of the log at even steps."""
    log, arm, clock, neck = recording.log, recording.arm, recording.clock, recording.neck
    first, last = recording.rows
    step, decimation = float(log.time[1] - log.time[0]), recording.decimation
    beyond = round(OVERLAP_S / step)
    # Fasquelle's rows are every so manieth of the whole log
    from_row, to_row = max(first, begin - beyond), min(last, end + beyond)
    log_begin = max(0, from_row - beyond) // decimation * decimation
    even = log.part(log_begin, min(len(log.time), to_row + beyond))
    inside = np.zeros(len(even), dtype=bool)
    inside[from_row - log_begin : to_row - log_begin] = True
    at = even.time[inside]
    frames = _frames_around(recording.frames, at[0], at[-1])
    motors = motors_of(even, recording.count_angles, clock.delay[0] if clock.delay else 0.0)
    has_force = "f1" in even.columns
    away = (at[0] + at[-1]) / 2 - clock.offset - clock.middle
    clock_sigma = (float(np.hypot(clock.offset_sigma, clock.skew_sigma * away)), clock.skew_sigma)
    estimate = estimate_state(arm, frames, motors, at, clock_sigma, fuse=has_force)
    state = state_columns(arm, estimate, motors, inside, frames)
    check = None
    if has_force:
        near = frames.within(at[0], at[-1]).clear_of(clock.repaired.gaps, GAP_MARGIN_S)
        check = check_elongations(arm, state, near, clock_sigma[0], tolerance=neck.tolerance)
    own = slice(begin - from_row, end - from_row)
    seen = np.isfinite(frames.alpha).all(axis=1)
    to_time = log.time[end] if end < last else np.inf
    return _Part(
        state=state.part(own),
        fasquelle=_between(
            fasquelle_series(arm, even, frames.time[seen], frames.alpha[seen], cutoff), log.time[begin], to_time
        ),
        covariance=_between(estimate.covariance_series(COVARIANCE_HZ), log.time[begin], to_time),
        check=check,
        notes=dict(estimate.notes) | {"rows_bridged": int(estimate.bridged[own].any(axis=1).sum())},
    )


def _frames_around(frames: FrameAngles, first: float, last: float) -> FrameAngles:
    """Frames from first to last, s, and those beyond in which every joint is seen before and after."""
    seen = [frames.time[np.isfinite(alpha)] for alpha in frames.alpha.T]
    before = min(float(time[max(int(np.searchsorted(time, first, side="right")) - 1, 0)]) for time in seen)
    after = max(float(time[min(int(np.searchsorted(time, last)), len(time) - 1)]) for time in seen)
    return frames.within(before, after)


def _between(series: Series, first: float, last: float) -> Series:
    return series.part((series.time >= first) & (series.time < last))


def _merged_notes(parts: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """The notes of the states: those of a part by the method of most, and what they add up to."""
    methods = [part["method"] for part in parts]
    usual = max(set(methods), key=methods.count)
    merged = dict(next(part for part in parts if part["method"] == usual))
    return merged | {
        "rows_bridged": sum(part["rows_bridged"] for part in parts),
        "parts_by_method": {method: methods.count(method) for method in sorted(set(methods))},
    }
