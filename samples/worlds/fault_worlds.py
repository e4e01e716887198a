"""Recordings with one fault at a known place, or none, as the check of elongations takes them.

The check is given another neck.yaml than the recording was made with (drum, pulley, pre-elongation), angles that are off, or
counts that slipped or got lost.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset import state_series
from identification.dataset.frames import FrameAngles
from identification.dataset.series import Series, interpolated, numbered_columns
from mechanism.arm import Arm
from samples.worlds.clock_worlds import ClockRecording, arm
from state_estimation.motors import motors_of
from synchronisation.angles import Angles
from synchronisation.clocks.clock import fit_clock
from synchronisation.encoder_log import uniformly_sampled

Array = NDArray[np.float64]

HEALTHY = "healthy"
CLOCK_S = 3e-4
"""s: standard deviation of the clock's error, where it is drawn instead of fitted"""
COUNT = 2 * np.pi / 2048
"""rad of the motor per encoder count"""
X0_M = 1e-3
"""m by which neck.yaml is wrong of every cable's pre-elongation"""


@dataclass(frozen=True)
class FaultCase:
    """One fault at its place, or none, in what the check is given: angles, log and arm."""

    label: str
    fault: tuple[str, str] | None
    angles: Angles
    log: Series
    arm: Arm
    baseline: bool = False


def fault_cases(made: ClockRecording, seed: int) -> list[FaultCase]:
    """Every case once; the seed gives its place and its sign."""
    i, j, sign = seed % 3, seed % 4, 1 if seed % 2 else -1
    a, log = made.angles, made.log
    plain = arm()
    plain = replace(plain, x0=plain.x0 + np.random.default_rng([seed, 21]).normal(0, X0_M, plain.M))

    def off(degrees: float) -> Angles:
        return Angles(a.time, a.alpha + np.radians(degrees) * sign * np.eye(3)[i], a.sigma)

    def counted(change: Callable[[Array, Array], Array]) -> Series:
        theta = log.matrix("theta")
        theta = theta + change(log.time - log.time[0], theta) * np.eye(4)[j]
        return Series(log.time, {**log.columns, **numbered_columns("theta", np.round(theta / COUNT) * COUNT)})

    slip = 5e-4 * sign / plain.drum[j]
    slipped = counted(lambda t, _: np.where(t > 10 + seed % 40, slip, 0.0)[:, None])
    lost = counted(lambda _, th: -1e-3 * np.cumsum(np.maximum(np.diff(th, axis=0, prepend=th[:1]), 0), axis=0))
    drum = replace(plain, drum=plain.drum * (1 + 0.02 * sign * np.eye(4)[j]))
    pulley = replace(plain, r=plain.r + 6e-4 * sign * np.eye(3)[i])
    mechanism, cable = f"mechanism {i + 1}", f"cable {j + 1}"
    return [
        FaultCase(HEALTHY, None, a, log, plain),
        FaultCase(f"{HEALTHY}, baseline", None, a, log, plain, baseline=True),
        FaultCase("joint angle off by 3 deg", ("marker_offset", mechanism), off(3.0), log, plain),
        FaultCase("by 0.15 deg, baseline", ("marker_offset", mechanism), off(0.15), log, plain, baseline=True),
        FaultCase("drum radius off by 2 %", ("drum_radius", cable), a, log, drum),
        FaultCase("pulley radius off by 0.6 mm", ("pulley_radius", mechanism), a, log, pulley),
        FaultCase("slip of 0.5 mm", ("winch_slip", cable), a, slipped, plain),
        FaultCase("0.1 % of counts missed", ("missed_counts", cable), a, lost, plain),
    ]


def inputs(made: ClockRecording, case: FaultCase, seed: int, fitted: bool = False) -> tuple[Series, FrameAngles, float]:
    """What the check takes: the state's series with angles by vision alone, the frames on the log's clock, the clock's sigma, s."""
    log = uniformly_sampled(case.log)
    motors = motors_of(log, np.full(case.arm.M, COUNT))
    if fitted:
        clock = fit_clock(case.arm, case.angles, case.log)
        at, sigma = clock.log_time(case.angles.time), clock.offset_sigma
    else:
        clock_error = CLOCK_S * np.random.default_rng([seed, 5]).normal()
        at, sigma = made.clocks.log_time(case.angles.time) + clock_error, CLOCK_S
    inside = (log.time >= at[0]) & (log.time <= at[-1])
    alpha = interpolated(log.time[inside], at, case.angles.alpha)
    zero = np.zeros_like(alpha)
    state = state_series(
        case.arm,
        log.time[inside],
        (alpha, zero, zero),
        (motors.theta[inside], motors.theta_d[inside], motors.theta_dd[inside]),
        motors.f[inside],
        (zero + case.angles.sigma[0], zero, zero),
    )
    return state, FrameAngles(at, case.angles.alpha, case.angles.white_sigma, case.angles.shared), sigma
