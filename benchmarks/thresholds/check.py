"""Checks of generated recordings with known faults, once as they are and once with each threshold changed."""

import pickle
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.check import judge
from benchmarks.thresholds.outcome import Outcome
from benchmarks.thresholds.room import Room
from benchmarks.thresholds.threshold import Threshold, scaled
from identification.dataset.frames import FrameAngles
from identification.dataset.series import Series
from mechanism.arm import Arm
from samples.worlds.clock_worlds import KINDS, ClockRecording, arm, clock_recording
from samples.worlds.fault_worlds import CLOCK_S, FaultCase, fault_cases, inputs
from state_estimation.motors import motors_in
from synchronisation.check.check import Baseline, baseline_of, check_elongations
from synchronisation.check.faults import FAULTS
from synchronisation.check.residual_clock import find_clock_fault

SEEDS = range(7400, 7404)
CASES = (
    "healthy",
    "healthy, baseline",
    "joint angle off by 3 deg",
    "drum radius off by 2 %",
    "pulley radius off by 0.6 mm",
    "slip of 0.5 mm",
    "0.1 % of counts missed",
    "by 0.15 deg, baseline",
)


@dataclass(frozen=True)
class World:
    """One case of one seed, with what the check is given."""

    seed: int
    label: str
    folder: Path

    @property
    def name(self) -> str:
        return f"{self.seed} {self.label}"

    @cached_property
    def given(self) -> tuple[FaultCase, Any, Any, float, Any]:
        """Case, state, frames, the clock's sigma and the baseline; made once, kept in the folder."""
        file = self.folder / f"{self.seed}.pickle"
        if not file.exists():
            kind = KINDS[self.seed % len(KINDS)]
            made, before = clock_recording(kind, self.seed), clock_recording(kind, self.seed, motion=self.seed + 50_000)
            cases = {}
            for case in fault_cases(made, self.seed):
                known = _baseline(before, case, self.seed) if case.baseline else None
                cases[case.label] = (case, *inputs(made, case, self.seed), known)
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(pickle.dumps(cases))
        cases = pickle.loads(file.read_bytes())
        return cases.get(self.label, cases[CASES[0]])


EXCHANGED = {
    "theta2 turned": ("theta_sign", "cable 2"),
    "cables 1 and 3 exchanged": ("swapped_cables", "cables 1 and 3"),
    "angles 1 and 2 exchanged": ("swapped_markers", "mechanisms 1 and 2"),
    "a cable that wanders by 0.5 mm": ("unexplained_elongation", "cable 1"),
}
"""faults made of healthy recordings"""
SMALL = {
    "joint angle off by 2 deg": ("marker_offset", "mechanism 2"),
    "drum radius off by 1.5 %": ("drum_radius", "cable 3"),
    "pulley radius off by 0.45 mm": ("pulley_radius", "mechanism 1"),
    "slip of 0.3 mm": ("winch_slip", "cable 4"),
}
"""smaller than those of the benchmark, near what can be told"""
CLOCKS = {"clock as it is": 0.0, "clock off by 3 ms": 3e-3}
"""by how much frames are late, s; the clock's own check is asked"""


def _baseline(before: ClockRecording, case: FaultCase, seed: int) -> Baseline:
    """Of another recording of the same arm, without a fault."""
    healthy = replace(case, fault=None, angles=before.angles, log=before.log)
    return baseline_of(case.arm, *inputs(before, healthy, seed + 50_000))


def worlds(folder: Path) -> list[World]:
    """Each seed healthy, healthy with a baseline, and with three faults in turn; then faults made of healthy ones."""
    out = []
    for seed in SEEDS:
        faults = [CASES[2 + (3 * (seed - SEEDS.start) + k) % 6] for k in range(3)]
        out += [World(seed, label, folder) for label in (*CASES[:2], *faults)]
    out += [World(SEEDS.start + k % 2, label, folder) for k, label in enumerate(EXCHANGED)]
    out += [World(SEEDS.start + (k + m) % 4, label, folder) for k, label in enumerate(SMALL) for m in (2, 3)]
    return out + [World(seed, label, folder) for seed in list(SEEDS)[:2] for label in CLOCKS]


def judged_world(world: World) -> Outcome:
    """The check as it is now against the truth."""
    if world.label in CLOCKS:
        return _judged_clock(world)
    case, state, seen, sigma, known = world.given
    fault = case.fault
    if world.label in EXCHANGED:
        fault = EXCHANGED[world.label]
        state, seen = _exchanged(world.label, state, seen)
    described = case.arm
    if world.label in SMALL:
        fault = SMALL[world.label]
        described, state, seen = _small(world.label, described, state, seen)
    found = check_elongations(described, state, seen, sigma, known)
    said = "; ".join(f"{f['fault']} {f['where']}" for f in found.faults) or "consistent"
    right = bool(judge(found, fault)[0])
    return Outcome(right, bool(found.faults) and not right, said)


def _judged_clock(world: World) -> Outcome:
    case, state, seen, *_ = world.given
    late = CLOCKS[world.label]
    drawn = CLOCK_S * np.random.default_rng([world.seed, 5]).normal()  # the error that `inputs` gave the clock
    shifted = replace(seen, time=seen.time + late - drawn)
    found = find_clock_fault(case.arm, shifted, motors_in(state), np.full(case.arm.M, np.nan))
    if found is None:
        return Outcome(not late, False, "none")
    right = bool(late) and abs(found["size"] - late) < 1e-3
    return Outcome(right, not right, f"{1e3 * found['size']:.2f} ms")


def _small(label: str, described: Arm, state: Series, seen: FrameAngles) -> tuple[Arm, Series, FrameAngles]:
    if label.startswith("joint"):
        return described, state, replace(seen, alpha=seen.alpha + np.radians(2.0) * np.eye(3)[1])
    if label.startswith("drum"):
        return replace(described, drum=described.drum * (1 + 0.015 * np.eye(4)[2])), state, seen
    if label.startswith("pulley"):
        return replace(described, r=described.r + 4.5e-4 * np.eye(3)[0]), state, seen
    slip = np.where(state.time > state.time.mean(), 3e-4 / described.drum[3], 0.0)
    return described, Series(state.time, {**state.columns, "theta4": state.columns["theta4"] + slip}), seen


def _exchanged(label: str, state: Series, seen: FrameAngles) -> tuple[Series, FrameAngles]:
    columns = dict(state.columns)
    if label == "theta2 turned":
        for suffix in ("", "_d", "_dd"):
            columns[f"theta2{suffix}"] = -columns[f"theta2{suffix}"]
    elif label == "cables 1 and 3 exchanged":
        for name in ("theta{}", "theta{}_d", "theta{}_dd", "f{}"):
            one, other = name.format(1), name.format(3)
            columns[one], columns[other] = columns[other], columns[one]
    elif label == "angles 1 and 2 exchanged":
        order = [1, 0, 2]
        return state, replace(
            seen, alpha=seen.alpha[:, order], sigma=seen.sigma[:, order], common=seen.common[:, order]
        )
    else:
        t = state.time - state.time[0]
        columns["theta1"] = columns["theta1"] + 5e-4 * np.sqrt(2) / arm().drum[0] * np.sin(2 * np.pi * t / 1.7)
    return Series(state.time, columns), seen


def _thresholds() -> list[Threshold]:
    def of(module: str, *names: str) -> list[Threshold]:
        return scaled(f"synchronisation.check.{module}", *names)

    tolerances = [
        {
            name: replace(
                fault,
                tolerance=factor * fault.tolerance,
                tolerance_with_baseline=factor * fault.tolerance_with_baseline,
            )
            for name, fault in FAULTS.items()
        }
        for factor in (0.5, 2.0)
    ]
    return [
        Threshold("synchronisation.check.faults", "FAULTS", *tolerances),
        *of("scoring", "FALSE_ALARM_RATE", "BLOCK_S", "DRIFT_SIGMA_M", "DRIFT_TERMS", "MIN_ERROR_M"),
        *of("fault_search", "RIVAL_GAIN_SHARE", "MIN_GAIN_SHARE", "RIVAL_SIGMA", "MAX_FAULTS", "MIN_SEPARATION_S"),
        *of("absolute_law", "BETA_SIGMA"),
        *of("exchanges", "MIN_RESIDUAL_M", "MAX_REMAINING_SHARE"),
        *of("check", "MAX_UNEXPLAINED_M"),
        *of("residual_clock", "MIN_OFFSET_S", "MIN_SIGNIFICANCE"),
        *of("momentary_faults", "SLIP_INTERVAL_S", "MAX_SLACK_SHARE", "SLACK_S"),
    ]


ROOM = Room("check", worlds, judged_world, _thresholds)
