"""The state at the log's rate beside Fasquelle's own chain, on recordings whose motion is given.

The peer decimates, interpolates, filters and differentiates; of its cutoffs each recording takes the one that truth likes best, for
every derivative apart: more than anyone could know. The clock is the true one for both. NEES is e^T P^-1 e per dimension, 1 where
the covariance is what the errors are: of alpha, alpha', alpha'' each with its own block, and of all of it.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from benchmarks.nees import nees_per_dimension
from benchmarks.table import Claim, Table
from benchmarks.tuned_seeds import FIRST_COUNTED_WORLD
from identification.dataset.frames import FrameAngles
from identification.dataset.series import Series, numbered_columns
from identification.fasquelle.series import fasquelle_series
from mechanism.arm import Arm, arm_of
from mechanism.description import read_neck
from samples.generator.laws import cubic, damped, dry_and_viscous, linear, with_creep
from samples.generator.prescribed import Prescribed, World, prescribe
from state_estimation.motors import motors_of
from state_estimation.state import StateEstimate, estimate_state
from synchronisation.encoder_log import uniformly_sampled
from xneck_foundation.strict_yaml import parse_yaml

Array = NDArray[np.float64]

NECK = Path(__file__).parents[1] / "samples/recording/neck.yaml"
SEEDS = range(FIRST_COUNTED_WORLD, FIRST_COUNTED_WORLD + 6)
SECONDS = 60.0
NOISE_RAD = np.radians(0.1)
EDGE_S = 1.0
"""s left out at both ends, where Fasquelle's filters settle"""
GAPS_S = ((14.0, 15.0), (29.5, 30.5), (45.0, 46.0))
"""s after the first frame, from and to, in which no joint is seen; for the rows of the table that say so"""
CUTOFFS_HZ = (2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 14.0)
CONTENTS = {"2 Hz": ((0.1, 2.0), (25.0, 32.0)), "5 Hz": ((0.1, 5.0), (8.0, 9.6))}
"""bands in Hz, peaks in deg"""
_FS, _K = np.array([14.0, 17.0, 18.0, 16.0]), np.array([10e3, 9e3, 8e3, 5.5e3])
_CA = np.full(4, 60.0)


def _worlds() -> dict[str, World]:
    neck = parse_yaml(NECK.read_text(), str(NECK))
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


@dataclass(frozen=True)
class _Run:
    """One recording, one method."""

    ratio: Array
    """RMS errors over the peer's, (3,)"""
    nees: Array
    """of alpha, alpha', alpha'', and jointly, (4,), where vision sees"""
    nees_in_gaps: Array
    """the four within gaps, NaN without"""
    seconds: float
    """of computing per minute of recording"""


def measure(seeds: Iterable[int] = SEEDS) -> Table:
    """RMS error over the peer's, NEES per dimension over all seeds, its least and most joint one, and time."""
    arm = arm_of(read_neck(NECK))
    counts = read_neck(NECK).count_angles
    seeds, rows = tuple(seeds), []
    for content, (hertz, peak) in CONTENTS.items():
        for name, world in _worlds().items():
            kinds = [(True, False)] + ([(False, False), (True, True), (False, True)] if name == "damped" else [])
            runs: dict[tuple[bool, bool], list[_Run]] = {kind: [] for kind in kinds}
            for seed in seeds:
                made = prescribe(world, SECONDS, seed, hertz, peak)
                for (fuse, gaps), done in runs.items():
                    done.append(_run(arm, counts, made, seed, fuse, gaps))
            for (fuse, gaps), done in runs.items():
                label = f"{content}, fused, {name} cables" if fuse else f"{content}, vision alone"
                seconds = float(np.mean([run.seconds for run in done]))
                if not gaps:
                    ratio = np.mean([run.ratio for run in done], axis=0).tolist()
                    rows.append((label, (*ratio, *_nees_summary([run.nees for run in done]), seconds)))
                    continue
                for where, nees in (("in", [r.nees_in_gaps for r in done]), ("beside", [r.nees for r in done])):
                    rows.append((f"{label}, {where} gaps", (None, None, None, *_nees_summary(nees), seconds)))
    columns = ("alpha", "alpha'", "alpha''", "NEES", "NEES'", "NEES''", "joint", "least", "most", "s/min")
    table = Table(f"State over Fasquelle's chain, RMS, {len(seeds)} seeds of 0.1 deg", columns, tuple(rows))
    peer = ("Fasquelle's, at its best cutoff", 1.0)
    claims = [
        Claim(
            f"error of {column}, rms, in those of Fasquelle's chain",
            f"motion up to {content}, cables that stiffen and creep",
            ours,
            peer,
        )
        for content in CONTENTS
        for column in columns[:3]
        for ours in (table.at(f"{content}, fused, all cables", column),)
    ]
    return replace(table, claims=tuple(claims))


def _nees_summary(nees: list[Array]) -> tuple[float, ...]:
    """Means of the four NEES, and the least and the most of the joint one."""
    joint = [float(each[3]) for each in nees]
    return (*np.mean(nees, axis=0).tolist(), min(joint), max(joint))


def _run(arm: Arm, counts: Array, made: Prescribed, seed: int, fuse: bool, gaps: bool) -> _Run:
    noise = np.random.default_rng([seed, 1]).normal(0, NOISE_RAD, made.frame_alpha.shape)
    frames, alpha = made.clocks.log_time(made.frame_times), made.frame_alpha + noise
    log = uniformly_sampled(
        Series(made.log_time, numbered_columns("theta", made.counted) | numbered_columns("f", made.f))
    )
    inside = (log.time > frames[0] + EDGE_S) & (log.time < frames[-1] - EDGE_S)
    vision = FrameAngles(frames, alpha, np.full(alpha.shape, NOISE_RAD), np.zeros(alpha.shape))
    if gaps:
        vision = replace(vision, alpha=np.where(_in_gaps(frames, frames[0])[:, None], np.nan, alpha))
    begin = perf_counter()
    state = estimate_state(arm, vision, motors_of(log, counts), log.time[inside], fuse=fuse)
    elapsed = perf_counter() - begin
    truth = [_truth_at(made, values) for values in (made.alpha, made.alpha_d, made.alpha_dd)]
    ours = [_rms(v - t(state.time)) for v, t in zip(_parts(state), truth, strict=True)]
    peer = np.full(3, np.nan if gaps else np.inf)
    for cutoff in () if gaps else CUTOFFS_HZ:
        series = fasquelle_series(arm, log, frames, alpha, cutoff)
        kept = (series.time > state.time[0]) & (series.time < state.time[-1])
        for d, suffix in enumerate(("", "_d", "_dd")):
            peer[d] = min(peer[d], _rms((series.matrix("alpha", suffix) - truth[d](series.time))[kept]))
    at = state.covariance_time
    rows = np.searchsorted(state.time, at - 1e-9)
    e = np.concatenate([v[rows] - t(at) for v, t in zip(_parts(state), truth, strict=True)], axis=1)
    in_gaps = _in_gaps(at, frames[0]) & gaps
    nees = [nees_per_dimension(e[part], state.covariance[part]) for part in (~in_gaps, in_gaps)]
    return _Run(ratio=np.array(ours) / peer, nees=nees[0], nees_in_gaps=nees[1], seconds=elapsed * 60 / SECONDS)


def _in_gaps(time: Array, first: float) -> NDArray[np.bool_]:
    return np.any([(time > first + begin) & (time < first + end) for begin, end in GAPS_S], axis=0)


def _parts(state: StateEstimate) -> tuple[Array, Array, Array]:
    return state.alpha, state.alpha_d, state.alpha_dd


def _truth_at(made: Prescribed, values: Array) -> Callable[[Array], Array]:
    """The true values (T, ...) as a function of times of the log's rows."""
    return lambda time: values[np.searchsorted(made.log_time, time - 1e-6)]


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
