"""Simulation of the whole: one parameter set at a time, and many at once."""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.table import Table
from mechanism.arm import arm_of, batch
from mechanism.description import read_neck
from mechanism.machine import Machine
from mechanism.simulation import State, simulate

SAMPLES = Path(__file__).parents[1] / "samples"
SECONDS = 0.2
BATCHES = (1, 30, 300)


def measure() -> Table:
    """Simulated seconds per second of computing and parameter set: the whole model, in batches."""
    arm = arm_of(read_neck(SAMPLES / "recording/neck.yaml"))
    laws = ("dry_friction", "linear_cable")
    values = {"k": np.array([10e3, 9e3, 8e3, 5.5e3]), "ca": np.full(4, 60.0), "fs": np.array([14.0, 17, 18, 16])}
    values["cm"] = np.array([0.5])
    rest = State(np.zeros(3), np.zeros(3), np.zeros(4), np.zeros(4))
    ticks = np.arange(0, SECONDS, 0.002)
    f = 40 + 15 * np.sin(np.outer(ticks, [9.0, 12.0, 7.0, 10.0]))
    rows: list[tuple[str, tuple[float | None, ...]]] = []
    first = None
    for count in BATCHES:
        arms = batch([replace(arm, top_mass=arm.top_mass * (1 + 0.001 * k)) for k in range(count)])
        spent = _seconds(lambda arms=arms: simulate(Machine(arms, laws, values), rest, ticks, f))
        speed = SECONDS * count / spent
        first = first or speed
        rows.append((f"{count} parameter sets at once", (speed, speed / first)))
    return Table("Simulation of arm, cables and motors", ("x real time", "over one alone"), tuple(rows))


def _seconds(work: Callable[[], object]) -> float:
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin
