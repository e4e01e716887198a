"""Frames lost without a trace: how many losses are found, how many frame times are right, how many losses are invented."""

import numpy as np

from benchmarks.table import Claim, Table
from benchmarks.tuned_seeds import FIRST_COUNTED_WORLD
from samples.worlds.clock_worlds import arm, clock_recording, with_lost_frames
from synchronisation.clocks.clock import fit_clock

SEEDS = 10
SHARES = (0.0, 0.005, 0.02)
MAX_DISTANCE = 2
"""frames: a loss counts as found if one is decoded within so many of it"""


def measure(seeds: int = SEEDS, first: int = FIRST_COUNTED_WORLD) -> Table:
    """Recordings of 60 s in which cables, motors and joints do everything, with a share of their frames lost."""
    rows = []
    made = [clock_recording("everything", first + seed) for seed in range(seeds)]
    for share in SHARES:
        lost, found, invented, right, offset_ms, z = 0, 0, 0, [], [], []
        for seed, r in enumerate(made, first):
            angles, true, gone = with_lost_frames(r, share, seed)
            clock = fit_clock(arm(), angles, r.log)
            error = clock.log_time(angles.time) - r.clocks.log_time(true)
            # a loss stands before the first frame that comes later than its stamp
            places = gone - np.arange(len(gone))
            losses = clock.lost.losses
            decoded = np.repeat(
                np.searchsorted(angles.time, [loss.time for loss in losses]), [loss.frames for loss in losses]
            )
            hits = [p for p in places if len(decoded) and np.min(np.abs(decoded - p)) <= MAX_DISTANCE]
            lost, found = lost + len(gone), found + len(hits)
            invented += sum(1 for s in decoded if not len(places) or np.min(np.abs(places - s)) > MAX_DISTANCE)
            right.append(np.mean(np.abs(error) < 1 / 60))
            offset_ms.append(1e3 * abs(float(np.median(error))))
            z.append(float(np.median(error)) / clock.offset_sigma)
        figures = (
            100 * found / lost if lost else None,
            float(100 * np.mean(right)),
            invented / seeds,
            float(np.sqrt(np.mean(np.square(offset_ms)))),
            float(np.sqrt(np.mean(np.square(z)))),
        )
        rows.append((f"{100 * share:g} % lost ({lost})", figures))
    columns = ("found %", "times right %", "invented each", "offset ms", "error/sigma")
    wrong = Claim(
        "frame times that are wrong, %", f"{100 * SHARES[-1]:g} % of frames lost without a trace", 100 - rows[-1][1][1]
    )
    return Table(f"Frames lost without a trace, {seeds} recordings of 60 s", columns, tuple(rows), (wrong,))
