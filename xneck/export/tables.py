"""Series of results for other libraries: plain arrays, pandas, xarray."""

import importlib
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset import DataSet
from identification.dataset.series import Series
from identification.simulation.simulated_motion import SimulatedMotion
from identification.simulation.simulated_recording import SimulatedRecording
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]
Tabular = DataSet | SimulatedRecording | SimulatedMotion | Series

_NUMBERED = re.compile(r"([a-z_]+?)(\d+)((?:_[a-z]+)*)")
"""alpha2_d: stem, number of the joint or cable, suffix"""
_OF_JOINTS = ("alpha", "sigma_alpha", "bridged", "vision")
"""stems of which there is one a joint; of others there is one a cable"""


def to_arrays(result: Tabular) -> dict[str, Array]:
    """`time` and every column of a data set's state, or of a simulation, by the columns' names; SI units and radians.

    >>> import xneck
    >>> arrays = xneck.to_arrays(xneck.read_dataset("tuesday.mcap"))
    >>> arrays["alpha1"].shape == arrays["time"].shape
    True
    """
    series = _series(result)
    return {"time": series.time, **series.columns}


def to_pandas(result: Tabular) -> Any:
    """A result's series as a table of pandas, whose index is the time, s. Raises Refused where pandas is not installed.

    >>> import xneck
    >>> try:
    ...     table = xneck.to_pandas(xneck.read_dataset("tuesday.mcap"))
    ...     print(table.index.name)
    ... except xneck.Refused as refused:
    ...     print("time" if "pip install" in str(refused) else refused)
    time
    """
    series = _series(result)
    index = _library("pandas").Index(series.time, name="time")
    return _library("pandas").DataFrame(dict(series.columns), index=index)


def to_xarray(result: Tabular) -> Any:
    """A result's series as a data set of xarray, with dimensions time, joint and cable, both counted from 1.

    Columns alpha1, alpha2, ... are one variable alpha of time and joint. Raises Refused where xarray is not installed.

    >>> import xneck
    >>> try:
    ...     data = xneck.to_xarray(xneck.read_dataset("tuesday.mcap"))
    ...     print(*data["alpha"].dims)
    ... except xneck.Refused as refused:
    ...     print("time joint" if "pip install" in str(refused) else refused)
    time joint
    """
    series, variables = _series(result), {}
    for stem, suffix in dict.fromkeys((m[1], m[3]) for name in series.columns if (m := _NUMBERED.fullmatch(name))):
        part = "joint" if stem in _OF_JOINTS else "cable"
        variables[f"{stem}{suffix}"] = (("time", part), series.matrix(stem, suffix))
    variables |= {name: ("time", column) for name, column in series.columns.items() if not _NUMBERED.fullmatch(name)}
    counts = {dims[1]: values.shape[1] for dims, values in variables.values() if isinstance(dims, tuple)}
    coordinates: dict[str, Any] = {part: np.arange(1, count + 1) for part, count in counts.items()}
    return _library("xarray").Dataset(variables, coords=coordinates | {"time": series.time})


def _series(result: Tabular) -> Series:
    match result:
        case DataSet():
            return result.state
        case SimulatedRecording() | SimulatedMotion():
            return result.series
        case Series():
            return result
    raise Refused("table", f"{type(result).__name__} has no series", "give a data set or a simulation")


def _library(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise Refused(
            f"to_{name}", f"{name} is not installed", f"pip install {name}, or take xneck.to_arrays"
        ) from error
