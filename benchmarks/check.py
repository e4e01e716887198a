"""The check of elongations: how often it names a fault that was hidden, and how often it blames a healthy arm.

Seeds take the worlds of the clocks' benchmark in turn. The check is given another neck.yaml than the recording was made with
(drum, pulley, pre-elongation), angles that are off, or counts that slipped or got lost.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.table import Claim, Table
from benchmarks.tuned_seeds import FIRST_COUNTED_WORLD
from identification.dataset.dataset import state_series
from identification.dataset.frames import FrameAngles
from identification.dataset.series import Series, numbered_columns
from mechanism.arm import Arm
from samples.worlds.clock_worlds import KINDS, ClockRecording, arm, clock_recording
from state_estimation.motors import motors_of
from synchronisation.angles import Angles
from synchronisation.check.check import Baseline, Check, baseline_of, check_elongations
from synchronisation.clocks.clock import fit_clock
from synchronisation.encoder_log import uniformly_sampled
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

SEEDS = 20
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
    pulley = replace(plain, r=plain.r + 3e-4 * sign * np.eye(3)[i])
    mechanism, cable = f"mechanism {i + 1}", f"cable {j + 1}"
    return [
        FaultCase(HEALTHY, None, a, log, plain),
        FaultCase(f"{HEALTHY}, baseline", None, a, log, plain, baseline=True),
        FaultCase("joint angle off by 1.6 deg", ("marker_offset", mechanism), off(1.6), log, plain),
        FaultCase("by 0.15 deg, baseline", ("marker_offset", mechanism), off(0.15), log, plain, baseline=True),
        FaultCase("drum radius off by 2 %", ("drum_radius", cable), a, log, drum),
        FaultCase("pulley radius off by 0.3 mm", ("pulley_radius", mechanism), a, log, pulley),
        FaultCase("slip of 0.5 mm", ("winch_slip", cable), a, slipped, plain),
        FaultCase("0.1 % of counts missed", ("missed_counts", cable), a, lost, plain),
    ]


def measure(seeds: int = SEEDS, first: int = FIRST_COUNTED_WORLD, fitted: bool = False) -> Table:
    """Shares of recordings of 60 s at 0.1 deg. With `fitted` the clock is what `sync` makes of the faulty recording."""
    outcomes: dict[str, list[tuple[float, ...]]] = {}
    for seed in range(first, first + seeds):
        kind = KINDS[seed % len(KINDS)]
        made = clock_recording(kind, seed)
        before = clock_recording(kind, seed, motion=seed + 50_000)
        for case in fault_cases(made, seed):
            baseline = _baseline(before, seed, case.arm) if case.baseline else None
            try:
                state, frames, sigma = inputs(made, case, seed, fitted)
            except Refused:
                outcomes.setdefault(case.label, []).append((0.0, 0.0, 0.0, np.nan))
                continue
            begin = time.process_time()
            result = check_elongations(case.arm, state, frames, sigma, baseline)
            outcomes.setdefault(case.label, []).append((*judge(result, case.fault), time.process_time() - begin))
    columns = ("right", "named best", "alone", "s each")
    rows = tuple((label, tuple(float(v) for v in np.nanmean(values, axis=0))) for label, values in outcomes.items())
    how = "fitted" if fitted else "drawn"
    right = {label: figures[0] for label, figures in rows}
    healthy = 1 - right.pop(HEALTHY)
    del right[f"{HEALTHY}, baseline"]
    on = f"{seeds} recordings of 60 s"
    claims = (
        Claim("healthy arms that are blamed, %", on, 100 * healthy),
        Claim(f"faults of {len(right)} kinds not named, %", on, 100 * (1 - float(np.mean(list(right.values()))))),
    )
    return Table(f"Check, {seeds} recordings of 60 s, 0.1 deg, clock {how}, shares", columns, rows, claims)


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
    alpha = np.stack([np.interp(log.time[inside], at, c) for c in case.angles.alpha.T], axis=-1)
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


def judge(result: Check, fault: tuple[str, str] | None) -> tuple[float, float, float]:
    """Whether the verdict is right (the fault at its place is named or within the class), named best, and alone."""
    if fault is None:
        healthy = float(not result.faults)
        return healthy, healthy, healthy
    if not result.faults:
        return 0.0, 0.0, 0.0
    first = result.faults[0]
    others = first.get("or", [])
    best = (first["fault"], first["where"]) == fault
    right = best or fault in [(o["fault"], o["where"]) for o in others]
    return float(right), float(best), float(best and not others and len(result.faults) == 1)


def _baseline(before: ClockRecording, seed: int, described: Arm) -> Baseline | None:
    case = FaultCase("", None, before.angles, before.log, described)
    try:
        return baseline_of(described, *inputs(before, case, seed + 50_000))
    except Refused:
        return None
