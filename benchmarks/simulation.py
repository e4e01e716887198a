"""Speed and accuracy of the simulation of arm, cables and motors, and of MuJoCo on the same arm.

The sample's arm with elastic damped cables and dry friction under smooth forces, from rest. Errors are against our own steps of
a fortieth of a row, which tests hold against Runge and Kutta. MuJoCo knows no cables of this kind: it gets their torques from
the generator of the samples, in Python, and its time is that of its bodies alone, which is in its favour.
"""

# mujoco comes without complete type stubs
# pyright: reportAttributeAccessIssue=false

import math
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np

from benchmarks.table import Claim, Table
from mechanism.arm import Array, arm_of, batch
from mechanism.description import read_neck
from mechanism.machine import Machine
from mechanism.simulation import State, simulate
from samples.generator import simulation as generator
from samples.generator.motors import dry_and_viscous, linear_cable, motors_of
from samples.generator.mujoco_arm import MujocoArm
from xneck_foundation.strict_yaml import parse_yaml

NECK = Path(__file__).parents[1] / "samples/recording/neck.yaml"
ROWS = 151
STEP_S = 0.002
BATCHES = (1, 100, 1000)
TIMED_ROWS, REPEATS = 26, 5
"""few rows, and the fastest of several runs: other work on the machine only adds"""
MUJOCO_STEPS_S = (4e-4, 2e-4, 1e-4)
MUJOCO_TIMED = 2000
AS_EXACT = "MuJoCo as exact as steps of 2 ms, by its last row"
COLUMNS = ("error, rad", "x real time")
_K, _CA, _FS = np.array([10e3, 9e3, 8e3, 5.5e3]), np.full(4, 60.0), np.array([14.0, 17, 18, 16])


class _GivenForces:
    """A controller that gives forces (T, M) whatever the motors do."""

    def __init__(self, f: Array) -> None:
        self.f = f

    def command(self, sample: int, theta: Array) -> Array:
        return self.f[sample]


def measure() -> Table:
    """Error of alpha over 0.3 s and simulated seconds per second of computing on one core, for each parameter set."""
    arm = arm_of(read_neck(NECK))
    values = {"k": _K, "ca": _CA, "fs": _FS, "cm": np.array([0.5])}
    machine = Machine(arm, ("dry_friction", "linear_cable"), values)
    rest = State(np.zeros(3), np.zeros(3), np.zeros(4), np.zeros(4))
    ticks = STEP_S * np.arange(ROWS, dtype=float)
    f = 45 + 25 * (1 - np.cos(np.outer(ticks, [9.0, 12.0, 7.0, 10.0]))) / 2
    exact = simulate(machine, rest, ticks, f, max_step=STEP_S / 40).alpha
    rows: list[tuple[str, tuple[float | None, ...]]] = []
    ours = 0.0
    for step in (STEP_S, STEP_S / 2, STEP_S / 4):
        error = float(np.abs(simulate(machine, rest, ticks, f, max_step=step).alpha - exact).max())
        ours = ours or error
        for count in BATCHES if step == STEP_S else BATCHES[-1:]:
            arms = batch([replace(arm, top_mass=arm.top_mass * (1 + 0.001 * k / count)) for k in range(count)])
            sets = Machine(arms, machine.names, values | {"k": _K * (1 + 0.1 * np.arange(count)[:, None] / count)})
            short = ticks[:TIMED_ROWS]
            spent = _shortest(lambda sets=sets, short=short, step=step: simulate(sets, rest, short, f, max_step=step))
            rows.append((_label(step, count), (error, short[-1] * count / spent)))
    error, speed = np.inf, 0.0
    for step in MUJOCO_STEPS_S:
        found, speed = _mujoco(f, step)
        error = float(np.abs(found - exact).max())
        rows.append((f"MuJoCo, steps of {1e3 * step:g} ms", (error, speed)))
    # its error goes with the step (tests/mechanism/test_mujoco_peer.py)
    rows.append((AS_EXACT, (ours, speed * ours / error)))
    table = Table("Simulation of arm, cables and motors", COLUMNS, tuple(rows))
    peer = ("MuJoCo as exact", _per_second(table, AS_EXACT))
    claims = [
        Claim(
            "ms of computing a simulated second",
            f"{count} sets at once",
            _per_second(table, _label(STEP_S, count)),
            peer,
        )
        for count in (BATCHES[0], BATCHES[-1])
    ]
    return replace(table, claims=tuple(claims))


def _label(step: float, count: int) -> str:
    return f"steps of {1e3 * step:g} ms, {count} sets at once"


def _per_second(table: Table, row: str) -> float:
    """ms of computing for each second of a set."""
    return 1e3 / (table.at(row, COLUMNS[1]) or math.nan)


def _mujoco(f: Array, step: float) -> tuple[Array, float]:
    """alpha at the rows, and how many times faster than real time its bodies are."""
    neck = parse_yaml(NECK.read_text(), str(NECK))
    motors = motors_of(neck, dry_and_viscous(_FS, np.zeros(4)), linear_cable(_K, _CA))
    bodies = MujocoArm(neck, step)
    alpha = generator.simulate(neck, bodies, motors, _GivenForces(f), np.zeros(4), len(f), 0).alpha
    bodies.place(np.zeros(3))
    return alpha, MUJOCO_TIMED * step / _shortest(lambda: mujoco.mj_step(bodies.model, bodies.data, MUJOCO_TIMED))


def _shortest(work: Callable[[], object]) -> float:
    """s of computing, the least of several runs."""
    spent = []
    for _ in range(REPEATS):
        begin = time.process_time()
        work()
        spent.append(time.process_time() - begin)
    return min(spent)
