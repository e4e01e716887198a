"""The clock between camera and log beside cross-correlation of cable speeds, over noise seeds."""

import json
from pathlib import Path

import numpy as np
from scipy.signal import correlate

from benchmarks.table import Table
from identification.series import Series
from mechanism.arm import Arm, arm_of
from mechanism.cable_lengths import lengths
from mechanism.description import read_neck
from vision.angles import Angles
from vision.clock import fit_clock
from vision.encoder_log import read_log, uniform

SAMPLES = Path(__file__).parents[1] / "samples"
SEEDS = 20
NOISE = np.radians(0.1)
RATE = 500.0


def measure() -> Table:
    """RMS error of the offset in ms over seeds of 0.1 deg noise on the sample's true angles."""
    neck = read_neck(SAMPLES / "recording/neck.yaml")
    arm, log = arm_of(neck), uniform(read_log(SAMPLES / "recording/log.mcap", neck))
    t = json.loads((SAMPLES / "truth.json").read_text())["recording"]
    stored = np.load(SAMPLES / "truth.npz")
    times, alpha = stored["recording_frame_times"], stored["recording_frame_alpha"]
    ours, z, peer = [], [], []
    for seed in range(SEEDS):
        noisy = alpha + np.random.default_rng(seed).normal(0, NOISE, alpha.shape)
        angles = Angles(times, noisy, np.full(alpha.shape, NOISE))
        clock = fit_clock(arm, angles, log)
        truth = t["offset_s"] + t["skew"] * (clock.middle - t["middle_s"])
        ours.append(clock.offset - truth)
        z.append(ours[-1] / clock.offset_sigma)
        peer.append(_cross_correlation(arm, angles, log) - t["offset_s"])
    rms = [float(1e3 * np.sqrt(np.mean(np.square(e)))) for e in (ours, peer)]
    spread = float(np.sqrt(np.mean(np.square(z))))
    rows = (
        ("xneck", (rms[0], 1.0, spread)),
        ("cross-correlation of cable speeds", (rms[1], rms[1] / rms[0], None)),
    )
    return Table(f"Clock, {SEEDS} seeds of 0.1 deg", ("offset rms ms", "over xneck", "error/sigma"), rows)


def _cross_correlation(arm: Arm, angles: Angles, log: Series) -> float:
    """The usual way: both speeds at the log's rate, the peak of their correlation, and a parabola through it."""
    grid = np.arange(angles.time[0], angles.time[-1], 1 / RATE)
    winding = -lengths(arm, angles.alpha)
    seen = np.stack([np.gradient(np.interp(grid, angles.time, c)) for c in winding.T], axis=-1)
    even = np.arange(log.time[0], log.time[-1], 1 / RATE)
    moved = np.stack([np.gradient(np.interp(even, log.time, c)) for c in (arm.drum * log.matrix("theta")).T], axis=-1)
    both = np.sum([correlate(moved[:, j], seen[:, j]) for j in range(arm.M)], axis=0)
    best = int(np.argmax(both))
    left, middle, right = both[best - 1 : best + 2]
    part = 0.5 * (left - right) / (left - 2 * middle + right)
    return even[0] - grid[0] + (best - (len(seen) - 1) + part) / RATE
