"""Angles and log to one checked data set on the log's clock."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset import DataSet, state_series
from identification.dataset.frames import FrameAngles, between_frames
from identification.dataset.series import Series, numbered
from identification.fasquelle.series import CUTOFF, fasquelle_series
from mechanism.arm import arm_of
from mechanism.description import Neck
from state_estimation.motors import motors_of
from state_estimation.state import estimate_state
from synchronisation.angles import Angles
from synchronisation.check.check import check_elongations
from synchronisation.clocks.clock import Clock, fit_clock
from synchronisation.encoder_log import uniform

Array = NDArray[np.float64]

COVARIANCE_HZ = 10.0
"""of the full covariance in the data set; its diagonal stands beside the state at the log's rate"""

UNCHECKED = {"verdict": "cannot tell", "why": "the log holds no forces f", "faults": [], "cables": []}
"""the check's record where nothing says how far cables stretch"""


def synchronise(
    neck: Neck,
    neck_yaml: str,
    angles: Angles,
    log: Series,
    provenance: dict[str, Any],
    cutoff: float = CUTOFF,
) -> DataSet:
    """One clock, the state at the log's rate and as Fasquelle makes it, and the check of the elongations.

    Raises Refused with the reason where clocks cannot be aligned.
    """
    arm = arm_of(neck)
    viscosity = np.array([np.nan if motor.fv is None else motor.fv for motor in neck.motors])
    clock = fit_clock(arm, angles, log, viscosity)
    even = uniform(clock.log.log)
    good = angles.complete
    frame_time = clock.log_time(angles.time)
    known = frame_time[good]
    inside = (even.time >= known[0]) & (even.time <= known[-1])
    time = even.time[inside]
    motors = motors_of(even, np.array([2 * np.pi / motor.counts for motor in neck.motors]))
    seen = FrameAngles(frame_time, angles.alpha, angles.white, angles.shared)
    forces = "f1" in log.columns
    found = estimate_state(arm, seen, motors, time, (clock.offset_sigma, clock.skew_sigma), fuse=forces)
    state = state_series(
        arm,
        time,
        (found.alpha, found.alpha_d, found.alpha_dd),
        (motors.theta[inside], motors.theta_d[inside], motors.theta_dd[inside]),
        motors.f[inside],
        found.sigma,
    )
    alone = between_frames(frame_time, angles.alpha, time)
    seen_alone = numbered("vision", alone[0]) | numbered("vision", alone[1], "_d")
    rounded: dict[str, Array] = {}
    for suffix, sigma in zip(("", "_d", "_dd"), motors.sigma or (), strict=False):
        rounded |= numbered("sigma_theta", sigma[inside], suffix)
    bridged = numbered("bridged", found.bridged.astype(float))
    state = Series(time, {**state.columns, **rounded, **bridged, **seen_alone})
    fasquelle = fasquelle_series(arm, even, frame_time[good], angles.alpha[good], cutoff)
    check = check_elongations(arm, state, seen, clock.offset_sigma).as_json() if forces else dict(UNCHECKED)
    return DataSet(
        neck,
        neck_yaml,
        state,
        fasquelle,
        angles.series,
        log,
        clock_json(clock, angles, log)
        | {"state": found.notes | {"rows_bridged": int(found.bridged.any(axis=1).sum())}},
        check,
        {**provenance, "angles": angles.notes},
        found.covariance_series(COVARIANCE_HZ),
    )


def clock_json(clock: Clock, angles: Angles, log: Series) -> dict[str, Any]:
    """The contract's record of a synchronisation."""
    steps = np.diff(angles.time)
    nominal = float(np.median(steps))
    # frames missing between two stamps, as the stamps themselves tell
    dropped = np.maximum(np.rint(steps / nominal) - 1, 0)
    return {
        "offset_s": clock.offset,
        "offset_sigma_s": clock.offset_sigma,
        "skew_ppm": clock.skew * 1e6,
        "skew_sigma_ppm": clock.skew_sigma * 1e6,
        "camera_middle_s": clock.middle,
        "likeness": clock.likeness,
        "second_best": clock.second,
        "residual_m": clock.residual.tolist(),
        "source": clock.source,
        "warnings": list(clock.warnings),
        "mechanics_offset_s": clock.mechanics and clock.mechanics[0],
        "mechanics_offset_sigma_s": clock.mechanics and clock.mechanics[1],
        "force_delay_s": clock.delay and clock.delay[0],
        "force_delay_sigma_s": clock.delay and clock.delay[1],
        "light_edges": clock.anchor and clock.anchor.edges,
        "frame_period_s": clock.slips.period,
        "slips": [{"time_s": slip.time, "frames": slip.frames} for slip in clock.slips.slips],
        "frames_lost": sum(slip.frames for slip in clock.slips.slips),
        "frames": len(angles.time),
        "frames_used": int(angles.complete.sum()),
        "frames_dropped": int(dropped.sum()),
        "log_rows": len(log),
        "log_rows_missing": clock.log.missing,
        "log_rows_held": clock.log.held,
        "log_gaps": [list(gap) for gap in clock.log.gaps],
    }
