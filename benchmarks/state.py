"""The state at the log's rate beside the seed's own chain, on recordings whose motion is given.

The peer decimates, interpolates, filters and differentiates; of its cutoffs each recording takes the one that truth likes best, for
every derivative apart: more than anyone could know. The clock is the true one for both.
"""

from collections.abc import Callable
from pathlib import Path
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from benchmarks.table import Table
from identification.motors import motors_of
from identification.seed_series import seed_series
from identification.series import Series, numbered
from identification.state import Seen, State, estimate_state
from mechanism.arm import Arm, arm_of
from mechanism.description import read_neck
from samples.generator.laws import cubic, damped, dry_and_viscous, linear, with_creep
from samples.generator.prescribed import Prescribed, World, prescribe
from vision.encoder_log import uniform
from xneck.strict_yaml import parse

Array = NDArray[np.float64]

NECK = Path(__file__).parents[1] / "samples/recording/neck.yaml"
SEEDS = 4
SECONDS = 60.0
NOISE = np.radians(0.1)
EDGE = 1.0
"""s left out at both ends, where the seed's filters settle"""
CUTOFFS = (2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 14.0)
CONTENTS = {"2 Hz": ((0.1, 2.0), (25.0, 32.0)), "5 Hz": ((0.1, 5.0), (8.0, 9.6))}
"""bands in Hz, peaks in deg"""
_FS, _K = np.array([14.0, 17.0, 18.0, 16.0]), np.array([10e3, 9e3, 8e3, 5.5e3])
_CA = np.full(4, 60.0)


def _worlds() -> dict[str, World]:
    neck = parse(NECK.read_text(), str(NECK))
    stiffening = damped(cubic(0.7 * _K, 0.7 * _K * 2e4), 6 * _K, _CA)
    return {
        "linear": World(neck, stretch=linear(_K, np.zeros(4))),
        "damped": World(neck, stretch=linear(_K, _CA)),
        "all": World(
            neck,
            stretch=with_creep(stiffening, 0.1 / _K, 3.0),
            friction=dry_and_viscous(_FS, np.full(4, 0.02)),
            joint_friction=lambda v: 0.01 * np.tanh(v / 0.05) + 0.005 * v,
        ),
    }


def measure() -> Table:
    """RMS error over the peer's, of alpha, alpha', alpha'' in turn, NEES per dimension, and time."""
    arm = arm_of(read_neck(NECK))
    counts = np.array([2 * np.pi / motor.counts for motor in read_neck(NECK).motors])
    rows = []
    for content, (hertz, peak) in CONTENTS.items():
        for name, world in _worlds().items():
            figures: dict[str, list[Array]] = {"fused": [], "vision alone": []}
            for seed in range(SEEDS):
                made = prescribe(world, SECONDS, seed, hertz, peak)
                for method, found in figures.items():
                    found.append(_one(arm, counts, made, seed, method == "fused"))
            for method, found in figures.items():
                if method == "fused" or name == "linear":
                    mean, nees = np.mean(found, axis=0), [f[3] for f in found]
                    label = f"{content}, {method}" + (f", {name} cables" if method == "fused" else "")
                    rows.append((label, (*mean[:4].tolist(), min(nees), max(nees), float(mean[4]))))
    columns = ("alpha", "alpha'", "alpha''", "NEES", "least", "most", "s/min")
    return Table(f"State over the seed's chain, RMS, {SEEDS} seeds of 0.1 deg", columns, tuple(rows))


def _one(arm: Arm, counts: Array, made: Prescribed, seed: int, fuse: bool) -> Array:
    """Three RMS errors over the peer's, NEES, and s of computing per minute of recording."""
    noise = np.random.default_rng([seed, 1]).normal(0, NOISE, made.frame_alpha.shape)
    frames, alpha = made.clocks.log_time(made.frame_times), made.frame_alpha + noise
    log = uniform(Series(made.log_time, numbered("theta", made.counted) | numbered("f", made.f)))
    inside = (log.time > frames[0] + EDGE) & (log.time < frames[-1] - EDGE)
    begin = perf_counter()
    seen = Seen(frames, alpha, np.full(alpha.shape, NOISE), np.zeros(alpha.shape))
    state = estimate_state(arm, seen, motors_of(log, counts), log.time[inside], fuse=fuse)
    took = perf_counter() - begin
    truth = [_at(made, values) for values in (made.alpha, made.alpha_d, made.alpha_dd)]
    ours = [_rms(v - t(state.time)) for v, t in zip(_parts(state), truth, strict=True)]
    peer = np.full(3, np.inf)
    for cutoff in CUTOFFS:
        series = seed_series(arm, log, frames, alpha, cutoff)
        kept = (series.time > state.time[0]) & (series.time < state.time[-1])
        for d, suffix in enumerate(("", "_d", "_dd")):
            peer[d] = min(peer[d], _rms((series.matrix("alpha", suffix) - truth[d](series.time))[kept]))
    at = state.covariance_time
    rows = np.searchsorted(state.time, at - 1e-9)
    e = np.concatenate([v[rows] - t(at) for v, t in zip(_parts(state), truth, strict=True)], axis=1)
    nees = float(np.mean(e * np.linalg.solve(state.covariance, e[..., None])[..., 0]))
    return np.array([*(np.array(ours) / peer), nees, took * 60 / SECONDS])


def _parts(state: State) -> tuple[Array, Array, Array]:
    return state.alpha, state.alpha_d, state.alpha_dd


def _at(made: Prescribed, values: Array) -> Callable[[Array], Array]:
    """Truth at rows of the log, by their times."""
    return lambda time: values[np.searchsorted(made.log_time, time - 1e-6)]


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
