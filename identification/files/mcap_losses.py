"""What a damaged MCAP file lost, in words, and the gaps of its series."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from identification.files.mcap_records import Records, Topic

Array = NDArray[np.float64]

GAP_STEP_RATIO = 1.5
"""steps larger than this many median steps are gaps: where a row is missing there are two (docs/thresholds.md)"""
MAX_NAMED_LOSSES = 3
"""places of damage, and widest gaps of a channel, that are listed"""


def rows_after_gaps(time: Array) -> list[int]:
    """Rows before which rows are missing; times (T,), s."""
    step = np.diff(time)
    return (np.flatnonzero(step > GAP_STEP_RATIO * np.median(step)) + 1).tolist() if len(step) > 1 else []


def loss_description(records: Records, times: Mapping[str, Array]) -> str:
    """All losses in one line, empty where there are none; times (T,), s, of the rows that were read, by topic."""
    short = [n for n, topic in records.topics.items() if topic.written is not None and len(times[n]) < topic.written]
    unknown = [n for n, topic in records.topics.items() if topic.written is None]
    if not records.damage and not short and not (records.cut and (unknown or not records.topics)):
        return ""
    parts = ["is cut off"] if records.cut else []
    parts += records.damage[:MAX_NAMED_LOSSES]
    parts += (
        [f"{len(records.damage) - MAX_NAMED_LOSSES} more places are damaged"]
        if len(records.damage) > MAX_NAMED_LOSSES
        else []
    )
    parts += [
        _rows(n, records.topics[n], times[n], bool(records.damage))
        for n in records.topics
        if n in short or n in unknown
    ]
    return "; ".join(parts if short or unknown or not records.topics else [*parts, "no row is lost"])


def _rows(name: str, topic: Topic, time: Array, damaged: bool) -> str:
    if not len(time):
        return f"/{name} is missing"
    of = f" of {topic.written}" if topic.written is not None else ""
    inside = rows_after_gaps(time) if damaged else []  # a file that is only cut off lost nothing before its end
    without = sorted(sorted(inside, key=lambda k: time[k - 1] - time[k])[:MAX_NAMED_LOSSES])
    gaps = [f"{time[k - 1]:.2f} to {time[k]:.2f} s" for k in without]
    left_out = f", without {' and '.join(gaps)}" if gaps else ""
    return f"/{name} has {len(time)}{of} rows, {time[0]:.2f} to {time[-1]:.2f} s{left_out}"
