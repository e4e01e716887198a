"""The clock between camera and log beside cross-correlation of cable speeds, over arms and motions drawn at random.

Fasquelle takes both clocks for one; cross-correlation is what is usual. The bound is that of the angles' noise alone, if all else
but the skew were known.
"""

import time
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import correlate

from benchmarks.table import Claim, Table
from benchmarks.tuned_seeds import FIRST_COUNTED_WORLD
from identification.dataset.series import Series, interpolated
from mechanism.arm import Arm
from mechanism.cable_lengths import lengths
from samples.worlds.clock_worlds import KINDS, ClockRecording, arm, clock_recording, switched_light
from synchronisation.angles import Angles
from synchronisation.clocks.clock import fit_clock
from synchronisation.clocks.light import edges_of, fit_light
from synchronisation.encoder_log import uniformly_sampled

Array = NDArray[np.float64]

SEEDS = 20
RATE_HZ = 500.0


def measure(seeds: int = SEEDS, first: int = FIRST_COUNTED_WORLD) -> Table:
    """RMS errors of offset (ms) and skew (ppm), and of error over sigma, over recordings of 60 s at 0.1 deg."""
    rows: list[tuple[str, tuple[float | None, ...]]] = []
    for kind in KINDS:
        made = [clock_recording(kind, first + seed) for seed in range(seeds)]
        errors = [_cross_correlation(arm(), r.angles, r.log) - r.clocks.offset_s for r in made]
        others = (1e3 * _rms(errors), 1e3 * _rms([r.offset_bound for r in made]))
        rows.append((kind, (*_ours(made), *others)))
        if kind == "everything":
            rows.append((f"{kind}, fv given", (*_ours(made, fv=True), *others)))
        rows.append((f"{kind}, no forces", (*_ours(made, forces=False), *others)))
        if kind == KINDS[0]:
            rows.append(("a light, 100 changes", (*_by_light(made, first), None, None)))
    columns = (
        "offset ms",
        "over sigma",
        "skew ppm",
        "skew over sigma",
        "worst ms",
        "s each",
        "correlation ms",
        "bound ms",
    )
    table = Table(f"Clock, {seeds} recordings of 60 s, 0.1 deg, rms of errors", columns, tuple(rows))
    claims = []
    for kind in KINDS:
        ours, peer, limit = (table.at(kind, name) for name in (columns[0], *columns[-2:]))
        others = ("cross-correlation", peer), ("Cramér-Rao", limit)
        claims.append(Claim("error of the offset, rms, ms", f"{seeds} recordings, {kind}", ours, *others))
    return replace(table, claims=tuple(claims))


def _ours(made: list[ClockRecording], fv: bool = False, forces: bool = True) -> tuple[float, ...]:
    errors, z, skews, skew_z, spent = [], [], [], [], []
    for r in made:
        log = r.log if forces else Series(r.log.time, {n: c for n, c in r.log.columns.items() if n.startswith("theta")})
        begin = time.process_time()
        clock = fit_clock(arm(), r.angles, log, r.fv if fv else None)
        spent.append(time.process_time() - begin)
        truth = r.clocks.offset_s + r.clocks.skew * (clock.middle - r.clocks.middle_s)
        errors.append(clock.offset - truth)
        skews.append(clock.skew - r.clocks.skew)
        z.append(errors[-1] / clock.offset_sigma)
        skew_z.append(skews[-1] / clock.skew_sigma)
    return _figures(errors, z, skews, skew_z, spent)


def _by_light(made: list[ClockRecording], first: int) -> tuple[float, ...]:
    errors, z, skews, skew_z, spent = [], [], [], [], []
    for seed, r in enumerate(made, first):
        light = switched_light(r.clocks, r.angles.time, seed)
        begin = time.process_time()
        clock = fit_light(*edges_of(light.time, light.led), r.angles.time, light.brightness, 0.004)
        spent.append(time.process_time() - begin)
        errors.append(clock.offset - r.clocks.offset_s - r.clocks.skew * (clock.middle - r.clocks.middle_s))
        skews.append(clock.skew - r.clocks.skew)
        z.append(errors[-1] / clock.offset_sigma)
        skew_z.append(skews[-1] / clock.skew_sigma)
    return _figures(errors, z, skews, skew_z, spent)


def _figures(
    errors: list[float], z: list[float], skews: list[float], skew_z: list[float], spent: list[float]
) -> tuple[float, ...]:
    worst = float(1e3 * np.max(np.abs(errors)))
    return (1e3 * _rms(errors), _rms(z), 1e6 * _rms(skews), _rms(skew_z), worst, float(np.median(spent)))


def _rms(values: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _cross_correlation(described: Arm, angles: Angles, recorded_log: Series) -> float:
    """Offset, s, by the usual method: the peak of the correlation of both speeds at the log's rate, and a parabola through it."""
    log = uniformly_sampled(recorded_log)
    grid = np.arange(angles.time[0], angles.time[-1], 1 / RATE_HZ)
    winding = -lengths(described, angles.alpha)
    video_speed = np.gradient(interpolated(grid, angles.time, winding), axis=0)
    even = np.arange(log.time[0], log.time[-1], 1 / RATE_HZ)
    travel = described.drum * log.matrix("theta")
    log_speed = np.gradient(interpolated(even, log.time, travel), axis=0)
    correlation = np.sum([correlate(log_speed[:, j], video_speed[:, j]) for j in range(described.M)], axis=0)
    best = int(np.argmax(correlation))
    left, middle, right = correlation[best - 1 : best + 2]
    fraction = 0.5 * (left - right) / (left - 2 * middle + right)
    return even[0] - grid[0] + (best - (len(video_speed) - 1) + fraction) / RATE_HZ
