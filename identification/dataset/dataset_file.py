"""The data set's file: one MCAP that plotting tools open as named curves, and exports of the same series."""

import csv
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from identification.dataset.clock_record import log_time, validate_clock_record
from identification.dataset.dataset import DataSet
from identification.dataset.dataset_validation import validate_dataset
from identification.dataset.series import Series, check_time
from identification.files import joint_state
from identification.files.mat_file import write_mat_file
from identification.files.mcap_losses import rows_after_gaps
from mechanism.description import Neck
from xneck_foundation import strict_yaml
from xneck_foundation.errors import Refused
from xneck_foundation.whole_file import whole_file

_TOPICS = ("state", "fasquelle", "angles", "log")
_NEEDED = ("state", "fasquelle")
EXPORT_FORMATS = ("csv", "npz", "mat")
_ROWS_AT_ONCE = 20_000
"""rows of a CSV that are made at once"""
EDGE_S = 1.0
"""s of frames and log beyond the rows of a part of a data set: splines through its frames reach over its rows"""


def write_dataset(data: DataSet, path: str | Path) -> None:
    """`data` as MCAP: a channel for each series, clock, check and provenance as metadata, neck.yaml attached.

    Frames keep the camera's stamps; their messages are logged at their time on the log's clock, as those of the other channels.

    >>> import xneck
    >>> xneck.write_dataset(xneck.read_dataset("monday.mcap"), "copy.mcap")
    """
    joint_state.write(
        path,
        dataset_series(data),
        {"clock": dict(data.clock), "check": dict(data.check), "provenance": dict(data.provenance)},
        {"neck.yaml": data.neck_yaml.encode()},
        {"angles": log_time(data.clock, data.angles.time)} if "offset_s" in data.clock else {},
    )


def dataset_series(data: DataSet) -> dict[str, Series]:
    """The series of a data set by their topic in its file."""
    return {topic: getattr(data, topic) for topic in _TOPICS} | (
        {"covariance": data.covariance} if data.covariance else {}
    )


def read_dataset(path: str | Path, within: tuple[float, float] | None = None) -> DataSet:
    """A data set from its MCAP; of a damaged file what can be read, with a warning `Recovered`.

    within: first and last time on the log's clock, s, of the rows that are wanted, where not all are. Only their part of the file
    is read, and frames, log and covariance up to EDGE_S beyond them.

    Of state and fasquelle the longest stretch without a gap is taken, as they need even time steps. Raises Refused where the file
    is something else, or lacks state, fasquelle, clock or neck.yaml.

    >>> import xneck
    >>> state = xneck.read_dataset("monday.mcap").state  # on the log's clock, at its rate
    >>> state.matrix("alpha").shape == (len(state.time), 3)  # rad
    True
    >>> [name for name in state.columns if name.startswith("theta1")]  # rad, rad/s, rad/s^2
    ['theta1', 'theta1_d', 'theta1_dd']
    """
    beyond = None if within is None else (within[0] - EDGE_S, within[1] + EDGE_S)
    file = joint_state.read(path, beyond)
    file.refuse_faulty(path, *_TOPICS)
    needed = _NEEDED if file.lost else _TOPICS
    missing = [topic for topic in needed if topic not in file.logs]
    missing += [name for name, part in (("clock", file.metadata), ("neck.yaml", file.attached)) if name not in part]
    if missing and file.lost:
        lacks = ", ".join(missing)
        raise Refused(path, f"lacks {lacks} ({file.lost})", "copy it again, or make it anew with `xneck sync`")
    if missing:
        raise Refused(path, f"is not a data set: lacks {', '.join(missing)}", "make one with `xneck sync`")
    try:
        text = file.attached["neck.yaml"].decode()
    except UnicodeDecodeError as error:
        raise Refused(f"{path}:neck.yaml", "is not UTF-8 text") from error
    neck = strict_yaml.validate_document(strict_yaml.parse_yaml(text, f"{path}:neck.yaml"), Neck, f"{path}:neck.yaml")
    series = {topic: joint_state.as_series(log) for topic, log in file.logs.items()}
    if within is not None and beyond is not None:
        clock = file.metadata["clock"] if isinstance(file.metadata["clock"], dict) else {}
        validate_clock_record(clock, f"{path}: clock")
        for topic, one in series.items():
            time = log_time(clock, one.time) if topic == "angles" and "offset_s" in clock else one.time
            first, last = within if topic in _NEEDED else beyond
            series[topic] = one.part((time >= first) & (time <= last))
    for topic in _NEEDED:
        check_time(series[topic].time, f"{path}:/{topic}")
        series[topic] = _longest_without_gap(series[topic]) if file.lost else series[topic]
    parts = {topic: series.get(topic, Series(np.empty(0), {})) for topic in _TOPICS}
    records: dict[str, Any] = {name: file.metadata.get(name, {}) for name in ("clock", "check", "provenance")}
    for name, record in records.items():
        if not isinstance(record, dict):
            raise Refused(path, f"its {name} is no record", "make the data set anew with `xneck sync`")
    data = DataSet(neck, text, **parts, **records, covariance=series.get("covariance"))
    validate_dataset(data, path)
    return data


def _longest_without_gap(series: Series) -> Series:
    """The longest stretch of rows between two gaps."""
    begin, end = max(
        pairwise((0, *rows_after_gaps(series.time), len(series))), key=lambda stretch: stretch[1] - stretch[0]
    )
    return series.part(slice(begin, end))


def export_series(series: Series, path: str | Path) -> None:
    """A series as .csv, .npz or .mat (columns as variables, `time` first), by the path's suffix."""
    path = Path(path)
    columns = {"time": series.time} | dict(series.columns)
    if path.suffix.lower() == ".csv":
        with whole_file(path) as file, file.open("w", newline="", encoding="utf-8") as stream:
            rows = csv.writer(stream)
            rows.writerow(columns)
            for begin in range(0, len(series), _ROWS_AT_ONCE):
                part = slice(begin, begin + _ROWS_AT_ONCE)
                table = np.stack([column[part] for column in columns.values()], axis=1)
                rows.writerows([["" if value != value else repr(value) for value in row] for row in table.tolist()])
    elif path.suffix.lower() == ".npz":
        with whole_file(path) as part, part.open("wb") as stream:
            np.savez_compressed(stream, **columns)  # type: ignore[arg-type]
    elif path.suffix.lower() == ".mat":
        write_mat_file(columns, path)
    else:
        raise Refused(
            path, f"cannot export to {path.suffix or 'a file without suffix'}", f"valid: {', '.join(EXPORT_FORMATS)}"
        )
