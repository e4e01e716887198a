"""The data set's file: one MCAP that plotting tools open as named curves, and exports of the same series."""

import csv
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import savemat

from identification import joint_state
from identification.dataset import DataSet
from identification.series import Series
from mechanism.description import Neck
from xneck import strict_yaml
from xneck.errors import Refused
from xneck.whole_file import whole_file

_TOPICS = ("state", "seed", "angles", "log")
FORMATS = ("csv", "npz", "mat")


def write_dataset(data: DataSet, path: str | Path) -> None:
    """`data` as MCAP: channels as its series, metadata clock, check and provenance, neck.yaml attached."""
    joint_state.write(
        path,
        {topic: getattr(data, topic) for topic in _TOPICS}
        | ({"covariance": data.covariance} if data.covariance else {}),
        {"clock": dict(data.clock), "check": dict(data.check), "provenance": dict(data.provenance)},
        {"neck.yaml": data.neck_yaml.encode()},
    )


def read_dataset(path: str | Path) -> DataSet:
    """A data set from its MCAP. Raises Refused where it is damaged or something else."""
    logs, metadata, attached = joint_state.read(path)
    missing = [topic for topic in _TOPICS if topic not in logs] + [n for n in ("neck.yaml",) if n not in attached]
    if missing:
        raise Refused(path, f"is not a data set: lacks {', '.join(missing)}", "make one with `xneck sync`")
    text = attached["neck.yaml"].decode()
    neck = strict_yaml.validate(strict_yaml.parse(text, f"{path}:neck.yaml"), Neck, f"{path}:neck.yaml")
    parts: dict[str, Series] = {topic: joint_state.as_series(logs[topic]) for topic in _TOPICS}
    records: dict[str, Any] = {name: metadata.get(name, {}) for name in ("clock", "check", "provenance")}
    covariance = joint_state.as_series(logs["covariance"]) if "covariance" in logs else None
    return DataSet(neck, text, **parts, **records, covariance=covariance)


def export(series: Series, path: str | Path) -> None:
    """A series as .csv, .npz or .mat (columns as variables, `time` first), by the path's suffix."""
    path = Path(path)
    columns = {"time": series.time} | dict(series.columns)
    if path.suffix == ".csv":
        with whole_file(path) as part, part.open("w", newline="", encoding="utf-8") as stream:
            rows = csv.writer(stream)
            rows.writerow(columns)
            table = np.stack(list(columns.values()), axis=1)
            rows.writerows([["" if value != value else repr(value) for value in row] for row in table.tolist()])
    elif path.suffix == ".npz":
        with whole_file(path) as part, part.open("wb") as stream:
            np.savez_compressed(stream, **columns)  # type: ignore[arg-type]
    elif path.suffix == ".mat":
        with whole_file(path) as part, part.open("wb") as stream:
            savemat(stream, columns, oned_as="column", long_field_names=True)
    else:
        raise Refused(
            path, f"cannot export to {path.suffix or 'a file without suffix'}", f"valid: {', '.join(FORMATS)}"
        )
