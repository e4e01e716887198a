"""Errors of simulated recordings that the model was not fitted to, against the noise floor of state, sensors and parameters.

Arms drawn as in `identification`; one recording of 60 s is identified, another of 60 s with the same arm, and one with 0.1 kg
on its tip that the description does not know, are simulated in windows, from forces and from motor angles.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.table import Claim, Table
from benchmarks.tuned_seeds import FIRST_COUNTED_WORLD
from identification.dataset.dataset import DataSet
from identification.dataset.series import Series, numbered_columns
from identification.estimates import estimate
from identification.model_file import model_of
from identification.simulation.channels import Channel
from identification.simulation.simulated_recording import Source, simulate_recording
from mechanism.description import read_neck
from samples.generator.laws import dry_and_viscous, linear
from samples.generator.mujoco_arm import Load
from samples.generator.prescribed import World, prescribe
from samples.worlds.clock_worlds import NECK_FILE, NOISE_RAD
from synchronisation.angles import Angles
from synchronisation.synchronise import synchronise
from xneck_foundation.strict_yaml import parse_yaml

SEEDS = 5
SECONDS = 60.0
PAYLOAD_KG = 0.1
SOURCES: tuple[Source, ...] = ("f", "theta")
MAX_TRUE_RATIO = 1.3
"""ratio of error to noise floor that a true model should not exceed"""
_K = np.array([10e3, 9e3, 8e3, 5.5e3])


def recorded(seed: int, motion: int, load: Load | None = None, seconds: float = SECONDS) -> DataSet:
    """The arm of a seed in one of its motions."""
    rng = np.random.default_rng([seed, 1])
    k, fs, ca = _K * rng.uniform(0.7, 1.3, 4), rng.uniform(10, 20, 4), rng.uniform(20, 120, 4)
    real = parse_yaml(NECK_FILE.read_text(), str(NECK_FILE))
    world = World(real, linear(k, ca), dry_and_viscous(fs, np.zeros(4)), load=load or Load())
    p = prescribe(world, seconds, [seed, motion])
    noise = np.random.default_rng([seed, motion, 9]).normal(0, NOISE_RAD, p.frame_alpha.shape)
    angles = Angles(p.frame_times, p.frame_alpha + noise, np.full(p.frame_alpha.shape, NOISE_RAD))
    log = Series(p.log_time, numbered_columns("theta", p.counted) | numbered_columns("f", p.f))
    return synchronise(read_neck(NECK_FILE), "", angles, log, {})


def measure(first: int = FIRST_COUNTED_WORLD, seeds: int = SEEDS) -> Table:
    """Error over noise floor, of all channels of a kind: median, root mean square, largest, how many are within 1.3 of it, and
    how many within what chance gives a true model in 95 of 100 recordings."""
    found: dict[tuple[str, str], list[Channel]] = {}
    for seed in range(first, first + seeds):
        fit = estimate([recorded(seed, 0)])
        model = model_of(fit.parameters, fit.laws, {}, fit.covariance)
        for what, data in (
            ("held out", recorded(seed, 1)),
            ("with payload", recorded(seed, 2, Load(payload_kg=PAYLOAD_KG))),
        ):
            for source in SOURCES:
                for channel in simulate_recording(data, model, source=source).channels:
                    found.setdefault((what, f"from {source}, {channel.name.rstrip('1234')}"), []).append(channel)
    rows: list[tuple[str, tuple[float | None, ...]]] = []
    for (what, kind), channels in found.items():
        ratio: NDArray[np.float64] = np.array([c.ratio for c in channels])
        floor = float(np.median([c.noise_floor for c in channels]))
        within = 100 * float(np.mean(ratio < MAX_TRUE_RATIO))
        within_95 = 100 * float(np.mean(ratio < np.array([c.ratio_95 for c in channels])))
        figures = (floor, float(np.median(ratio)), float(np.sqrt(np.mean(ratio**2))), float(ratio.min()))
        rows.append((f"{what}, {kind}", (*figures, float(ratio.max()), within, within_95)))
    columns = ("floor, SI", "median", "rms", "least", "largest", "% < 1.3", "% < 95 %")
    title = f"Simulation error over its noise floor, {seeds} arms, windows of 0.5 s"
    table = Table(title, columns, tuple(rows))
    claims = []
    for source, kind in (("f", "alpha"), ("f", "theta"), ("theta", "alpha")):
        ours = table.at(f"held out, from {source}, {kind}", "median")
        what, on = f"error over noise floor, median, {kind} from {source}", f"{seeds} recordings that were not fitted"
        claims.append(Claim(what, on, ours, limit=("a true model", 1.0)))
    return replace(table, claims=tuple(claims))
