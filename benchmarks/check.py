"""The check of elongations: how often it names a fault that was hidden, and how often it blames a healthy arm.

Seeds take the worlds of the clocks' benchmark in turn; the faults are those of samples/worlds/fault_worlds.py.
"""

import time

import numpy as np
from numpy.typing import NDArray

from benchmarks.table import Claim, Table
from benchmarks.tuned_seeds import FIRST_COUNTED_WORLD
from mechanism.arm import Arm
from samples.worlds.clock_worlds import KINDS, ClockRecording, clock_recording
from samples.worlds.fault_worlds import HEALTHY, FaultCase, fault_cases, inputs
from synchronisation.check.check import Baseline, Check, baseline_of, check_elongations
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

SEEDS = 20


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
