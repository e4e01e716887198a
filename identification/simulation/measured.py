"""What was measured of a recording, to be laid beside what is simulated of it, part by part."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset import DataSet
from identification.dataset.frames import seen_in
from identification.simulation.channels import Compared
from identification.simulation.initial_state import Own
from identification.simulation.windows import Windows

Array = NDArray[np.float64]


class Measured(Protocol):
    """A quantity of a recording."""

    @property
    def unit(self) -> str:
        """As channels state it."""
        ...

    def beside(self, windows: Windows, simulated: Array) -> Compared:
        """simulated (cases, W, samples, columns), in these windows."""
        ...


@dataclass(frozen=True)
class InFrames:
    """Angles in the camera's frames."""

    time: Array
    """(F,), s, on the log's clock"""
    alpha: Array
    """(F, N), NaN where not seen"""
    variance: Array
    """(F, N)"""
    unit: str = "rad"

    def beside(self, windows: Windows, simulated: Array) -> Compared:
        """In frames between two rows of one window."""
        time, values = windows.state.time, in_rows(simulated)
        inside = np.flatnonzero((self.time >= time[0]) & (self.time < time[-1]))
        row = np.searchsorted(time, self.time[inside], side="right") - 1
        within = row % windows.samples < windows.samples - 1
        row, frame = row[within], inside[within]
        share = ((self.time[frame] - time[row]) / (time[row + 1] - time[row]))[:, None]
        found = (1 - share) * values[:, row] + share * values[:, row + 1]
        return Compared(found, self.alpha[frame], self.variance[frame], windows.of_rows()[row])


@dataclass(frozen=True)
class InRows:
    """What is known in every row of the state."""

    values: Array
    """(T, M)"""
    variance: Array
    """(M,)"""
    unit: str

    def beside(self, windows: Windows, simulated: Array) -> Compared:
        """In the windows' rows."""
        return Compared(in_rows(simulated), self.values[windows.rows], self.variance, windows.of_rows())


def angles_of(data: DataSet) -> InFrames:
    """The joints', as the camera saw them."""
    seen = seen_in(data)
    return InFrames(seen.time, seen.alpha, seen.sigma**2)


def counts_of(data: DataSet) -> InRows:
    """The motors', as counted."""
    log = data.log if data.log.matrix("theta").size else data.state  # a damaged file may have lost the log
    counted = [np.interp(data.state.time, log.time, column) for column in log.matrix("theta").T]
    return InRows(
        np.stack(counted, axis=-1), np.array([2 * np.pi / motor.counts for motor in data.neck.motors]) ** 2 / 12, "rad"
    )


def forces_of(own: Own) -> InRows:
    """What motors gave; the command itself is exact."""
    return InRows(own.f, np.zeros(own.f.shape[1]), "N")


def in_rows(values: Array) -> Array:
    """(..., W, samples, columns) -> (..., rows, columns)"""
    return values.reshape(*values.shape[:-3], -1, values.shape[-1])
