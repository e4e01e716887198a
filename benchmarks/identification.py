"""Errors of identified friction and elasticity: by Fasquelle's chain, by least squares at the log's rate, and by instruments.

Recordings of 60 s at 0.1 deg and 30 Hz, encoder counts, clocks fitted by `synchronise` as in use, cables and friction drawn
anew for each seed. In the second half the description has no pre-elongation while there are 2 to 26 N of it.
"""

from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from benchmarks.table import Claim, Table
from benchmarks.tuned_seeds import FIRST_COUNTED_WORLD
from identification.dataset.dataset import DataSet
from identification.dataset.series import Series, numbered_columns
from identification.estimates import Estimates, estimate
from identification.fasquelle.method import fasquelle_identification
from mechanism.description import Neck, read_neck
from samples.generator.laws import dry_and_viscous, linear
from samples.generator.prescribed import World, prescribe
from samples.worlds.clock_worlds import NECK_FILE, NOISE_RAD
from synchronisation.angles import Angles
from synchronisation.synchronise import synchronise
from xneck_foundation.strict_yaml import parse_yaml

Array = NDArray[np.float64]

SEEDS = 10
SECONDS = 60.0
TERMS = ("fs", "k", "ca")
INTERVAL = 1.96
"""sigmas of a 95 % interval"""
_K = np.array([10e3, 9e3, 8e3, 5.5e3])


@dataclass(frozen=True)
class GeneratedRecording:
    """A generated data set with the true values, by term, (M,)."""

    data: DataSet
    truth: dict[str, Array]


def generated(seed: int, neglected: bool = False, seconds: float = SECONDS) -> GeneratedRecording:
    """Cables of 0.7 to 1.3 times the usual stiffness with 20 to 120 N s/m, and 10 to 20 N of dry friction.

    neglected: 2 to 26 N of pretension in the straight pose, described as none.
    """
    rng = np.random.default_rng([seed, 1])
    truth = {"k": _K * rng.uniform(0.7, 1.3, 4), "fs": rng.uniform(10, 20, 4), "ca": rng.uniform(20, 120, 4)}
    real = parse_yaml(NECK_FILE.read_text(), str(NECK_FILE))
    described = read_neck(NECK_FILE)
    if neglected:
        for cable, force, k in zip(real["cables"], rng.uniform(2, 26, 4), truth["k"], strict=True):
            cable["x0"] = float(force / k)
        described = without_x0(described)
    world = World(real, linear(truth["k"], truth["ca"]), dry_and_viscous(truth["fs"], np.zeros(4)))
    p = prescribe(world, seconds, seed)
    noise = np.random.default_rng([seed, 9]).normal(0, NOISE_RAD, p.frame_alpha.shape)
    angles = Angles(p.frame_times, p.frame_alpha + noise, np.full(p.frame_alpha.shape, NOISE_RAD))
    log = Series(p.log_time, numbered_columns("theta", p.counted) | numbered_columns("f", p.f))
    return GeneratedRecording(synchronise(described, "", angles, log, {}), truth)


def without_x0(neck: Neck) -> Neck:
    """The same arm said to have no pre-elongation."""
    return neck.model_copy(update={"cables": tuple(c.model_copy(update={"x0": 0.0}) for c in neck.cables)})


def measure(first: int = FIRST_COUNTED_WORLD, seeds: int = SEEDS) -> Table:
    """Of each method and term: mean and rms error in %, what 95 % intervals cover, and how many are called identified."""
    rows: list[tuple[str, tuple[float | None, ...]]] = []
    for neglected in (False, True):
        prefix, spent = "x0 neglected, " if neglected else "", []
        found: dict[tuple[str, str], list[tuple[Array, Array, Array]]] = {}
        for seed in range(first, first + seeds):
            recording = generated(seed, neglected)
            fit = fasquelle_identification([recording.data]).elastic[1]
            begin = perf_counter()
            ours = estimate([recording.data])
            spent.append(perf_counter() - begin)
            for term in TERMS:
                true = recording.truth[term]
                theirs = [p for p in fit.parameters if p.name == term]
                found.setdefault(("Fasquelle's", term), []).append(
                    _compared(true, np.array([(p.value, p.sigma, p.identified) for p in theirs]))
                )
                for method in ("least squares", "instruments"):
                    found.setdefault((method, term), []).append(_compared(true, _ours(ours, term, method)))
        for (method, term), parts in found.items():
            error, z, called = (np.array(part) for part in zip(*parts, strict=True))
            figures = (
                100 * float(error.mean()),
                100 * float(np.sqrt(np.mean(error**2))),
                100 * float(np.mean(np.abs(z) < INTERVAL)),
                float(np.sqrt(np.mean(z**2))),
                100 * float(called.mean()),
                float(np.median(spent)) if method == "instruments" else None,
            )
            rows.append((f"{prefix}{method}, {term}", figures))
    columns = ("bias %", "rms %", "covered %", "over sigma", "identified %", "s each")
    table = Table(f"Identification, {seeds} recordings of 60 s, 0.1 deg, fitted clocks", columns, tuple(rows))
    claims = [
        Claim(f"error of {term}, rms, %", on, table.at(f"{said}instruments, {term}", "rms %"), ("Fasquelle's", theirs))
        for said, on in (
            ("", f"{seeds} recordings of 60 s"),
            ("x0 neglected, ", "the same, pre-elongation not described"),
        )
        for term in TERMS
        for theirs in (table.at(f"{said}Fasquelle's, {term}", "rms %"),)
    ]
    return replace(table, claims=tuple(claims))


def _compared(true: Array, estimates: Array) -> tuple[Array, Array, Array]:
    """Relative error, error over sigma, and what is called identified, each (M,); estimates (M, 3)."""
    value, sigma, called = estimates.T
    return value / true - 1, (value - true) / sigma, called


def _ours(found: Estimates, term: str, method: str) -> Array:
    """Value, sigma and whether identified, (M, 3); least squares does not judge itself."""
    slot = found.unknowns.slots[term, None]
    s = found.solution
    plain = method == "least squares"
    value = (s.least_squares if plain else s.p)[slot]
    sigma = np.sqrt(np.diag(s.least_squares_covariance if plain else s.covariance))[slot]
    called = sigma <= 0.1 * np.abs(value) if plain else [v.identified for v in found.identifiability[slot]]
    return np.stack([value, sigma, called], axis=-1)
