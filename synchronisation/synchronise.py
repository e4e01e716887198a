"""Angles and log to one checked data set on the log's clock."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset import DataSet, state_series
from identification.dataset.encoder_steps import count_angles
from identification.dataset.frames import FrameAngles, spline_through_frames
from identification.dataset.series import Series, numbered_columns
from identification.fasquelle.series import FASQUELLE_CUTOFF_HZ, fasquelle_series
from mechanism.arm import Arm, arm_of
from mechanism.description import Neck
from state_estimation.motors import Motors, motors_of
from state_estimation.state import StateEstimate, estimate_state
from synchronisation.angles import Angles
from synchronisation.check.check import check_elongations
from synchronisation.clocks.clock import fit_clock
from synchronisation.clocks.clock_estimate import ClockEstimate
from synchronisation.clocks.late_forces import with_acting_forces
from synchronisation.clocks.usable_frames import GAP_MARGIN_S
from synchronisation.encoder_counts import counts_warnings
from synchronisation.encoder_log import uniformly_sampled
from synchronisation.log_plausibility import check_log_meaning
from synchronisation.tested_sigma import with_tested_sigma
from synchronisation.thinned_log import forces_held, rows_left_out, rows_left_out_warning
from xneck_foundation.one_blas_thread import one_blas_thread

Array = NDArray[np.float64]

COVARIANCE_HZ = 10.0
"""Hz: rate of the full covariance in the data set; its diagonal stands beside the state at the log's rate"""

UNCHECKED = {"verdict": "cannot tell", "why": "the log holds no forces f", "faults": [], "cables": []}
"""the check's record of a log without forces: how far cables stretch is unknown"""


@one_blas_thread
def synchronise(
    neck: Neck,
    neck_yaml: str,
    angles: Angles,
    log: Series,
    provenance: dict[str, Any],
    cutoff: float = FASQUELLE_CUTOFF_HZ,
) -> DataSet:
    """The data set of angles and log: on one clock, with the state at the log's rate, Fasquelle's series and the check.

    cutoff: Hz, of Fasquelle's low-pass. Raises Refused with the reason where the clocks cannot be aligned.
    """
    arm = arm_of(neck)
    angles, of_sigma = with_tested_sigma(angles.from_zero(neck.zero_angles))
    warnings = (*of_sigma, *check_log_meaning(neck, arm, angles, log), *counts_warnings(neck, log))
    viscosity = np.array([np.nan if motor.fv is None else motor.fv for motor in neck.motors])
    clock = fit_clock(arm, angles, log, viscosity)
    if rows_left_out(log, clock):
        warnings = (*warnings, rows_left_out_warning(log, clock))
        clock = fit_clock(arm, angles, forces_held(log, clock), viscosity)
    clock = replace(clock, warnings=(*warnings, *clock.warnings))
    even_log = uniformly_sampled(clock.repaired.log)
    frames = FrameAngles(clock.log_time(angles.time), angles.alpha, angles.white_sigma, angles.shared)
    known = angles.complete
    first, last = frames.time[known][[0, -1]]
    inside = (even_log.time >= first) & (even_log.time <= last)
    motors = motors_of(even_log, count_angles(neck, log), clock.delay[0] if clock.delay else 0.0)
    has_force = "f1" in log.columns
    clock_sigma = (clock.offset_sigma, clock.skew_sigma)
    estimate = estimate_state(arm, frames, motors, even_log.time[inside], clock_sigma, fuse=has_force)
    state = state_columns(arm, estimate, motors, inside, frames)
    # what the log does not hold is no elongation
    logged = frames.clear_of(clock.repaired.gaps, GAP_MARGIN_S)
    check = dict(UNCHECKED)
    if has_force:
        acting = with_acting_forces(state, clock.delay[0] if clock.delay else 0.0)
        check = check_elongations(arm, acting, logged, clock.offset_sigma, tolerance=neck.tolerance).as_json()
    bridged = {"rows_bridged": int(estimate.bridged.any(axis=1).sum())}
    return DataSet(
        neck=neck,
        neck_yaml=neck_yaml,
        state=state,
        fasquelle=fasquelle_series(arm, even_log, frames.time[known], angles.alpha[known], cutoff),
        angles=angles.series,
        log=log,
        clock=clock_json(clock, angles, log) | {"noise": angles.noise, "state": estimate.notes | bridged},
        check=check,
        provenance={**provenance, "angles": angles.notes},
        covariance=estimate.covariance_series(COVARIANCE_HZ),
    )


def state_columns(
    arm: Arm, estimate: StateEstimate, motors: Motors, inside: NDArray[np.bool_], frames: FrameAngles
) -> Series:
    """The state at the log's rows within the video, with the angles by vision alone and the motors' own sigmas beside it."""
    time = motors.time[inside]
    state = state_series(
        arm,
        time,
        (estimate.alpha, estimate.alpha_d, estimate.alpha_dd),
        (motors.theta[inside], motors.theta_d[inside], motors.theta_dd[inside]),
        motors.f[inside],
        estimate.sigma,
    )
    encoder_sigma: dict[str, Array] = {}
    for suffix, sigma in zip(("", "_d", "_dd"), motors.sigma or (), strict=False):
        encoder_sigma |= numbered_columns("sigma_theta", sigma[inside], suffix)
    bridged = numbered_columns("bridged", estimate.bridged.astype(float))
    alpha, alpha_d, _ = spline_through_frames(frames.time, frames.alpha, time)
    vision = numbered_columns("vision", alpha) | numbered_columns("vision", alpha_d, "_d")
    return Series(time, {**state.columns, **encoder_sigma, **bridged, **vision})


def clock_json(clock: ClockEstimate, angles: Angles, log: Series) -> dict[str, Any]:
    """The clock's record in a data set and in `sync --json`; identification/dataset/clock_record.py reads it."""
    steps = np.diff(angles.time)
    # frames that are missing between two stamps, by the stamps themselves
    dropped = np.maximum(np.rint(steps / np.median(steps)) - 1, 0)
    return {
        "offset_s": clock.offset,
        "offset_sigma_s": clock.offset_sigma,
        "skew_ppm": clock.skew * 1e6,
        "skew_sigma_ppm": clock.skew_sigma * 1e6,
        "camera_middle_s": clock.middle,
        "likeness": clock.correlation,
        "second_best": clock.second_peak,
        "residual_m": clock.residual_rms.tolist(),
        "source": clock.source,
        "warnings": list(clock.warnings),
        "mechanics_offset_s": clock.motion_offset and clock.motion_offset[0],
        "mechanics_offset_sigma_s": clock.motion_offset and clock.motion_offset[1],
        "force_delay_s": clock.delay and clock.delay[0],
        "force_delay_sigma_s": clock.delay and clock.delay[1],
        "light_edges": clock.light and clock.light.switches,
        "frame_period_s": clock.lost.period,
        "slips": [{"time_s": loss.time, "frames": loss.frames} for loss in clock.lost.losses],
        "frames_lost": sum(loss.frames for loss in clock.lost.losses),
        "frames": len(angles.time),
        "frames_used": int(angles.complete.sum()),
        "frames_dropped": int(dropped.sum()),
        "log_rows": len(log),
        "log_rows_missing": clock.repaired.missing_rows,
        "log_rows_held": clock.repaired.repeated_rows,
        "log_gaps": [list(gap) for gap in clock.repaired.gaps],
    }
