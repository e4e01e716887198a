"""The equations of motion are those of rigid bodies: MuJoCo, which knows bars, hinges and springs only, moves alike.

MuJoCo closes the loops by stiff constraints and integrates by semi-implicit Euler, so its motion differs by c1 h + c2 h^2
with the step h. Extrapolating to h = 0 leaves O(h^2); a wrong term in the equations would stay whatever the step.
"""

import json
from collections.abc import Iterable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mechanism.arm import Arm, arm_of
from mechanism.cable_lengths import Z
from mechanism.description import Neck
from mechanism.dynamics import coriolis, gravity_and_springs, mass_matrix
from mechanism.friction import CM
from mechanism.machine import Machine
from mechanism.simulation import State
from mechanism.simulation import simulate as simulate_equations
from samples.generator.motors import dry_and_viscous, linear_cable, motors_of
from samples.generator.mujoco_arm import Load, MujocoArm
from samples.generator.routes import cable_table
from samples.generator.simulation import Run, simulate

DURATION = 0.3
START = np.array([0.25, -0.2, 0.3])
FS, FV = (14.0, 17.0, 18.0, 16.0), (0.02, 0.01, 0.03, 0.0)
K, CA = (10000.0, 9000.0, 8000.0, 5500.0), (60.0, 50.0, 40.0, 30.0)
PULL = np.array([25.0, 20.0, 22.0, 24.0])


def unlike_neck() -> dict[str, Any]:
    """Three mechanisms that differ in everything, centres of mass off the bars' middles, gravity at a slant."""

    def mechanism(sizes: str, rod: str, top: str, com: list[float], springs: str, slack: bool) -> dict[str, Any]:
        L, b, r = map(float, sizes.split())
        (rod_m, rod_i), (top_m, top_i), (k, free) = (map(float, text.split()) for text in (rod, top, springs))
        return {
            "L": L,
            "b": b,
            "r": r,
            "diagonal": {"mass": rod_m, "inertia": rod_i},
            "top": {"mass": top_m, "inertia": top_i, "com": com},
            "springs": {"stiffness": k, "free_length": free, "slack": slack},
        }

    routes = [["right"], ["strut", "right"], ["strut", "strut", "right"], ["left_through", "left_through", "left"]]
    return {
        "xneck": 1,
        "gravity": [1.5, -9.6],
        "mechanisms": [
            mechanism("0.10 0.05 0.005", "0.03 2.5e-5", "0.05 1e-5", [0.004, 0.006], "400 0.05", False),
            mechanism("0.12 0.06 0.006", "0.04 5.0e-5", "0.06 2e-5", [-0.006, 0.003], "300 0.09", True),
            mechanism("0.09 0.04 0.004", "0.02 1.5e-5", "0.08 4e-5", [0.003, -0.008], "500 0.04", False),
        ],
        "cables": [{"route": route, "length": 1.0, "section": 1e-6, "x0": 0.004} for route in routes],
        "motors": [{"R": 25, "rd": 0.01, "Ia": 5e-6, "counts": 2048}] * 4,
    }


def arm_from(neck: dict[str, Any]) -> Arm:
    return arm_of(Neck.model_validate_json(json.dumps(neck)))


def by_equations(arm: Arm, times: np.ndarray) -> np.ndarray:
    """alpha, shape (T, N), of the free motion under constant tensions by the minimal equations (44)."""

    def rate(_: float, y: np.ndarray) -> np.ndarray:
        alpha, alpha_d = np.split(y, 2)
        torque = Z(arm, alpha) @ PULL - coriolis(arm, alpha, alpha_d) - gravity_and_springs(arm, alpha)
        return np.concatenate([alpha_d, np.linalg.solve(mass_matrix(arm, alpha), torque)])

    start = np.concatenate([START, np.zeros(3)])
    return solve_ivp(rate, (0, times[-1]), start, "DOP853", times, rtol=1e-10, atol=1e-12).y[:3].T


def by_bodies(neck: dict[str, Any], times: np.ndarray, step: float) -> tuple[np.ndarray, float]:
    """The same by MuJoCo, and the widest gap of a loop, m."""
    table, bodies = cable_table(neck), MujocoArm(neck, step)
    bodies.place(START)
    kept, gap = [START], 0.0
    every = round((times[1] - times[0]) / step)
    for i in range(every * (len(times) - 1)):
        bodies.step(-table(bodies.alpha)[1] @ PULL)
        gap = max(gap, bodies.gap)
        if (i + 1) % every == 0:
            kept.append(bodies.alpha)
    return np.array(kept), gap


def test_free_motion_converges_to_the_equations() -> None:
    """Off equilibrium and let go for 0.3 s: the difference halves with the step; extrapolated, it all but vanishes.

    Seen: rms 0.012, 0.0057, 0.0027, 0.0013 rad; extrapolated once 1.2e-3, 3.9e-4, 1.1e-4, twice 2.0e-4, 3.0e-5 rad, for
    a swing of 0.4 to 1 rad. The ratios of first order tend to 2 from above, those of the loops' gap to 4.
    """
    neck = unlike_neck()
    times = np.linspace(0, DURATION, 31)
    reference = by_equations(arm_from(neck), times)
    assert np.ptp(reference, axis=0).min() > 0.3, "the arm swings wide enough to feel every term"
    steps = (5e-4, 2.5e-4, 1.25e-4, 6.25e-5)
    runs, gaps = zip(*(by_bodies(neck, times, h) for h in steps), strict=True)
    once = [2 * fine - coarse for coarse, fine in pairwise(runs)]
    twice = [(4 * fine - coarse) / 3 for coarse, fine in pairwise(once)]

    def rms(motions: Iterable[np.ndarray]) -> np.ndarray:
        return np.array([np.sqrt(np.mean((motion - reference) ** 2)) for motion in motions])

    ratios = rms(runs)[:-1] / rms(runs)[1:]
    assert np.all((ratios > 1.8) & (ratios < 2.4)), f"first order in the step, found ratios {ratios}"
    assert np.all(np.diff(rms(once)) < 0)
    assert rms(twice)[-1] < 1e-4, f"what the step does not explain: {rms(twice)} rad"
    assert np.all(np.array(gaps[:-1]) > 3.5 * np.array(gaps[1:])), "the loops close with the square of the step"


def driven(neck: dict[str, Any], step: float, load: Load | None = None) -> Run:
    """1 s of motors, elastic cables and arm under forces that go up and down, from rest near the straight pose."""
    motors = motors_of(neck, dry_and_viscous(np.array(FS), np.array(FV)), linear_cable(np.array(K), np.array(CA)))

    class Waves:
        def command(self, sample: int, theta: np.ndarray) -> np.ndarray:
            return 40 + 35 * np.sin(2 * np.pi * sample / 500 * np.array([1.1, 1.7, 1.4, 0.9]))

    return simulate(neck, MujocoArm(neck, step, load), motors, Waves(), np.zeros(4), ticks=500, settle_ticks=0)


def arm_residual(neck: dict[str, Any], run: Run) -> np.ndarray:
    """M alpha'' + c + g - Z t at the states that MuJoCo went through, shape (T, N), N m."""
    arm = arm_from(neck)
    inertia = np.einsum("tij,tj->ti", mass_matrix(arm, run.alpha), run.alpha_dd)
    pull = np.einsum("tij,tj->ti", Z(arm, run.alpha), run.tension)
    return inertia + coriolis(arm, run.alpha, run.alpha_d) + gravity_and_springs(arm, run.alpha) - pull


def test_driven_motion_is_the_simulation_of_the_equations() -> None:
    """Motors, cables and arm together (43), (44), (53): half the step, half the difference; extrapolated, near none.

    Seen: 6.9e-4, 3.4e-4 and extrapolated 5e-6 rad in alpha; in theta, as cable travel, 2.8e-5, 1.4e-5 and 1e-8 m.
    """
    neck = unlike_neck()
    arm = arm_from(neck)
    coarse, fine = (driven(neck, step) for step in (2e-4, 1e-4))
    values = {"k": np.array(K), "ca": np.array(CA), "fs": np.array(FS), "fv": np.array(FV), "cm": np.array([CM])}
    machine = Machine(arm, ("dry_friction", "viscous_friction", "linear_cable"), values)
    start = State(np.zeros(3), np.zeros(3), np.zeros(4), np.zeros(4))
    motion = simulate_equations(machine, start, fine.time, fine.f, max_step=2.5e-4)
    assert np.ptp(motion.alpha, axis=0).min() > 0.3
    for found, unit, left in (("alpha", 1.0, 2e-5), ("theta", 4e-4, 1e-7), ("tension", 1e-2, 2e-4)):
        errors = [unit * np.abs(getattr(run, found) - getattr(motion, found)).max() for run in (coarse, fine)]
        limit = 2 * getattr(fine, found) - getattr(coarse, found) - getattr(motion, found)
        assert 1.9 < errors[0] / errors[1] < 2.1, f"{found}: {errors}"
        assert unit * np.abs(limit).max() < left, found


def test_arm_equation_holds_at_the_states_of_the_bodies() -> None:
    """M alpha'' + c + g = Z t (44) at MuJoCo's own states: no integration between, so no step to blame.

    After the jerk of the start (0.02 s) what is left belongs to the loops' gap: 6e-6 N m, 1/300 of the smallest term
    (c) and 1/40000 of the others.
    """
    neck = unlike_neck()
    arm, run = arm_from(neck), driven(neck, 1e-4)
    alpha, alpha_d, alpha_dd = (x[10:] for x in (run.alpha, run.alpha_d, run.alpha_dd))
    inertia = np.einsum("tij,tj->ti", mass_matrix(arm, alpha), alpha_dd)
    turning, weight = coriolis(arm, alpha, alpha_d), gravity_and_springs(arm, alpha)
    pull = np.einsum("tij,tj->ti", Z(arm, alpha), run.tension[10:])
    left = np.abs(inertia + turning + weight - pull).max(axis=0)
    for term in (inertia, turning, weight, pull):
        assert np.all(left < 0.01 * np.abs(term).max(axis=0))
    assert left.max() < 2e-5, f"{left} N m"


@pytest.mark.parametrize(
    ("load", "effect"),
    [
        (Load(payload_kg=0.1), "payload"),
        (Load(base_tilt_rad=0.05), "tilt"),
        (Load(spring_factor=1.1), "springs"),
    ],
)
def test_what_the_bodies_hide_is_what_the_equations_miss(load: Load, effect: str) -> None:
    """A payload, a tilted base, stiffer springs: the described arm's equation misses exactly their torque.

    The torque is that of an arm whose description has the same change, so the change means the same on both sides.
    """
    neck, told = unlike_neck(), unlike_neck()
    tip = told["mechanisms"][-1]["top"]
    if effect == "payload":
        share = tip["mass"] / (tip["mass"] + load.payload_kg)
        offset = np.array(tip["com"])
        tip["inertia"] += float(offset @ offset) * share * load.payload_kg
        tip["com"] = (share * offset).tolist()
        tip["mass"] += load.payload_kg
    elif effect == "tilt":  # the base turns counter-clockwise, so gravity turns clockwise as the base sees it
        c, s = np.cos(load.base_tilt_rad), np.sin(load.base_tilt_rad)
        x, y = told["gravity"]
        told["gravity"] = [float(c * x + s * y), float(c * y - s * x)]
    else:
        for m in told["mechanisms"]:
            m["springs"]["stiffness"] *= load.spring_factor
    run = driven(neck, 1e-4, load)
    missed = np.abs(arm_residual(neck, run)[10:]).max()
    left = np.abs(arm_residual(told, run)[10:]).max()
    assert missed > 0.02
    assert left < 2e-5, "as without any load"
