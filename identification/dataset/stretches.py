"""Long data sets in parts: consecutive ones that together are all of it, or a few stretches spread over it.

Memory holds one part, or all stretches, but never a whole recording of hours. An error that all rows of a recording share, of its
clock or of its camera's pose, is no smaller because the recording was cut: see `with_shared_errors`.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from identification.dataset.dataset import DataSet
from identification.dataset.dataset_file import EDGE_S, read_dataset
from identification.dataset.frames import white_sigma
from identification.dataset.series import numbered_columns
from identification.files import joint_state
from identification.files.joint_state_channel import JointStateChannel
from identification.files.mcap_index import logged_span
from xneck_foundation.errors import Refused
from xneck_foundation.recovery import collected_recoveries

PART_S = 120.0
"""s of a part of a recording that is worked through from begin to end (docs/thresholds.md)"""
MIN_STRETCH_S = 20.0
"""s of a stretch at least (docs/thresholds.md)"""
_BETWEEN_ROWS_S = 2e-4
"""s by which an edge between windows is put before the row that begins the next one"""
MAX_BYTES_WITHOUT_INDEX = 200_000_000
"""bytes of a file whose index is lost, beyond which it is not read whole (docs/thresholds.md)"""


@dataclass(frozen=True)
class Stretches:
    """What a recording is judged by where all of it would be too much."""

    spans: tuple[tuple[float, float], ...]
    """first and last time of each, s, log clock"""
    seconds: float
    """of the whole recording"""

    @property
    def whole(self) -> bool:
        """Whether they are all of the recording."""
        return len(self.spans) == 1 and self.spans[0][1] - self.spans[0][0] >= self.seconds

    @property
    def record(self) -> dict[str, Any]:
        """For a result: which rows were judged, and of how many seconds."""
        if not np.isfinite(self.seconds):
            return {"seconds": None, "whole": True, "stretches_s": []}
        return {"seconds": self.seconds, "whole": self.whole, "stretches_s": [list(span) for span in self.spans]}

    @property
    def text(self) -> str:
        """Which rows were judged, in words."""
        of = sum(last - first for first, last in self.spans)
        return (
            f"judged by {len(self.spans)} stretches of {of / len(self.spans):.0f} s, spread over the {self.seconds:.0f} s of the "
            f"recording: what happens only between them is not seen, and sigmas are those of {of:.0f} s"
        )


def state_span(path: str | Path) -> tuple[float, float] | None:
    """First and last time of a data set's state, s, log clock, by the ends of the file; None where its index is lost.

    Raises Refused where the file is no data set, or has lost its index and is too large to be read whole.
    """
    path = Path(path)
    logged = logged_span(path)
    if logged is None:
        if path.stat().st_size > MAX_BYTES_WITHOUT_INDEX:
            raise Refused(path, "has lost the index at its end, and is too large to be read whole", "copy it again")
        return None
    with collected_recoveries():  # what is lost is said once, when the rows are read
        begin, end = (_logs_at(path, ns / 1e9) for ns in logged)
    if "state" not in begin or "state" not in end:
        return None
    return float(begin["state"].time[0]), float(end["state"].time[-1])


def _logs_at(path: Path, time: float) -> Mapping[str, JointStateChannel]:
    """Rows of the chunks that hold a log time, s; none where these are damaged."""
    try:
        return joint_state.read(path, (time, time)).logs
    except Refused:
        return {}


def is_long(path: str | Path) -> bool:
    """Whether a data set has more than one of `parts_of`."""
    span = state_span(path)
    return span is not None and len(consecutive_spans(*span)) > 1


def consecutive_spans(first: float, last: float, seconds: float = PART_S) -> list[tuple[float, float]]:
    """Spans of equal length, about `seconds` s each and no more than half as long again, that cover first to last."""
    edges = np.linspace(first, last, max(1, round((last - first) / seconds)) + 1)
    return list(zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True))


def parts_of(path: str | Path, overlap: float = 0.0, window: float = 0.0) -> Iterator[DataSet]:
    """The consecutive parts of a data set, each read when it is asked for; one, the whole, where it is not longer.

    overlap: s by which each reaches into its neighbours. Without it every row is in one part alone. window: s, of which all parts
    but the last are whole multiples, where it is given.
    """
    span = state_span(path)
    spans = [] if span is None else consecutive_spans(*span)
    if window and len(spans) > 1:
        first = spans[0][0]
        # between two rows, whatever the rounding of their times
        inner = [first + window * round((begin - first) / window) - _BETWEEN_ROWS_S for begin, _ in spans[1:]]
        spans = list(pairwise((first, *inner, spans[-1][1])))
    if len(spans) < 2:
        yield read_dataset(path)
        return
    for first, last in spans:
        end = last if last == spans[-1][1] else np.nextafter(last, first)
        yield read_dataset(path, (first - overlap, end + overlap))


def chosen_stretches(paths: Sequence[str | Path], seconds: float, count: int, held_s: float) -> list[Stretches]:
    """For each recording all of it, or at most `count` stretches evenly spread that are `seconds` s together.

    held_s: of all recordings together; each has less where they would be more. Raises Refused where they are too many for that.
    """
    each = held_s / len(paths)
    if each < MIN_STRETCH_S:
        raise Refused(
            "data sets",
            f"{len(paths)} recordings are more than are held at once ({int(held_s / MIN_STRETCH_S)})",
            "give fewer of them",
        )
    chosen = []
    for path in paths:
        span = state_span(path)
        if span is None:
            chosen.append(Stretches(((-np.inf, np.inf),), np.inf))
            continue
        first, last = span
        held = min(seconds, each)
        if last - first <= held:
            chosen.append(Stretches((span,), last - first))
            continue
        number = max(1, min(count, int(held / MIN_STRETCH_S)))
        one = held / number
        begins = np.linspace(first + EDGE_S, last - EDGE_S - one, number) if number > 1 else [(first + last - one) / 2]
        chosen.append(Stretches(tuple((float(b), float(b + one)) for b in begins), last - first))
    return chosen


def read_stretches(path: str | Path, stretches: Stretches) -> list[DataSet]:
    """The stretches of a recording as data sets."""
    if stretches.whole:
        return [read_dataset(path)]
    return [with_shared_errors(read_dataset(path, span), len(stretches.spans)) for span in stretches.spans]


def with_shared_errors(data: DataSet, count: int) -> DataSet:
    """One of `count` stretches of a recording, with the errors that they share as large as if each stretch had its own.

    Whoever takes several data sets takes their clocks and cameras for independent. An error of variance s^2 that all stretches
    share enters a weighted sum with s^2 (sum w)^2, which is at most s^2 count (sum w^2): what independent errors of variance
    count s^2 would give. The clock's error away from the recording's middle has that of the skew in it.
    """
    clock = dict(data.clock)
    middle = (data.state.time[0] + data.state.time[-1]) / 2
    away = middle - clock.get("camera_middle_s", middle) - clock.get("offset_s", 0.0)
    offset, skew = (float(clock.get(name) or 0.0) for name in ("offset_sigma_s", "skew_sigma_ppm"))
    clock["offset_sigma_s"] = float(np.sqrt(count) * np.hypot(offset, 1e-6 * skew * away))
    clock["skew_sigma_ppm"] = float(np.sqrt(count) * skew)
    angles = data.angles
    sigma, common = angles.matrix("sigma"), angles.matrix("common")
    if common.shape == sigma.shape and common.size:
        white, wider = white_sigma(sigma, common), np.sqrt(count) * common
        columns = numbered_columns("sigma", np.hypot(white, wider)) | numbered_columns("common", wider)
        angles = replace(angles, columns={**angles.columns, **columns})
    return replace(data, clock=clock, angles=angles)
