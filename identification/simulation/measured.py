"""What was measured of a recording, to be laid beside what is simulated of it, part by part."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset import DataSet
from identification.dataset.frames import frame_angles
from identification.simulation.channels import ChannelSamples
from identification.simulation.recording_parameters import RecordingParameters
from identification.simulation.windows import Windows

Array = NDArray[np.float64]


class MeasuredQuantity(Protocol):
    """A quantity of a recording."""

    @property
    def unit(self) -> str:
        """As channels state it."""
        ...

    def beside(self, windows: Windows, simulated: Array) -> ChannelSamples:
        """simulated (cases, W, samples, columns), in these windows."""
        ...


@dataclass(frozen=True)
class FrameMeasurement:
    """Angles in the camera's frames."""

    time: Array
    """(F,), s, on the log's clock"""
    alpha: Array
    """(F, N), NaN where not seen"""
    variance: Array
    """(F, N)"""
    unit: str = "rad"

    def beside(self, windows: Windows, simulated: Array) -> ChannelSamples:
        """In frames between two rows of one window."""
        time, values = windows.state.time, as_rows(simulated)
        inside = np.flatnonzero((self.time >= time[0]) & (self.time < time[-1]))
        row = np.searchsorted(time, self.time[inside], side="right") - 1
        within = row % windows.samples < windows.samples - 1
        row, frame = row[within], inside[within]
        share = ((self.time[frame] - time[row]) / (time[row + 1] - time[row]))[:, None]
        found = (1 - share) * values[:, row] + share * values[:, row + 1]
        return ChannelSamples(found, self.alpha[frame], self.variance[frame], windows.of_rows()[row])


@dataclass(frozen=True)
class RowMeasurement:
    """What is known in every row of the state."""

    values: Array
    """(T, M)"""
    variance: Array
    """(M,)"""
    unit: str

    def beside(self, windows: Windows, simulated: Array) -> ChannelSamples:
        """In the windows' rows."""
        return ChannelSamples(as_rows(simulated), self.values[windows.rows], self.variance, windows.of_rows())


def measured_angles(data: DataSet) -> FrameMeasurement:
    """The joints', as the camera saw them."""
    seen = frame_angles(data)
    return FrameMeasurement(seen.time, seen.alpha, seen.sigma**2)


def measured_motor_angles(data: DataSet) -> RowMeasurement:
    """The motors', as counted."""
    log = data.log if data.log.matrix("theta").size else data.state  # a damaged file may have lost the log
    counted = [np.interp(data.state.time, log.time, column) for column in log.matrix("theta").T]
    return RowMeasurement(
        np.stack(counted, axis=-1), np.array([2 * np.pi / motor.counts for motor in data.neck.motors]) ** 2 / 12, "rad"
    )


def measured_forces(own: RecordingParameters) -> RowMeasurement:
    """What motors gave; the command itself is exact."""
    return RowMeasurement(own.f, np.zeros(own.f.shape[1]), "N")


def as_rows(values: Array) -> Array:
    """(..., W, samples, columns) -> (..., rows, columns)"""
    return values.reshape(*values.shape[:-3], -1, values.shape[-1])
