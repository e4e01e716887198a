"""Measured quantities of a recording, each compared with the simulated one, part by part."""

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
    """A quantity that was measured in a recording."""

    @property
    def unit(self) -> str:
        """SI unit of the quantity."""
        ...

    def compared(self, windows: Windows, simulated: Array) -> ChannelSamples:
        """The measured values with the simulated ones, (1 + K, W, samples, columns), of these windows."""
        ...


@dataclass(frozen=True)
class FrameMeasurement:
    """Angles of the joints in the camera's frames."""

    time: Array
    """(F,), s, on the log's clock"""
    alpha: Array
    """(F, N), NaN where not seen"""
    variance: Array
    """of the angles, (F, N), rad^2"""
    unit: str = "rad"

    def compared(self, windows: Windows, simulated: Array) -> ChannelSamples:
        """Simulated angles interpolated to the frames that lie between two rows of one window."""
        time, values = windows.state.time, as_rows(simulated)
        inside = np.flatnonzero((self.time >= time[0]) & (self.time < time[-1]))
        row = np.searchsorted(time, self.time[inside], side="right") - 1
        within = row % windows.samples < windows.samples - 1
        row, frame = row[within], inside[within]
        share = ((self.time[frame] - time[row]) / (time[row + 1] - time[row]))[:, None]
        at_frames = (1 - share) * values[:, row] + share * values[:, row + 1]
        return ChannelSamples(at_frames, self.alpha[frame], self.variance[frame], windows.number_of_rows()[row])


@dataclass(frozen=True)
class RowMeasurement:
    """A quantity that is known in every row of the state."""

    values: Array
    """(T, M), in `unit`"""
    variance: Array
    """of each column, (M,), in `unit`^2"""
    unit: str

    def compared(self, windows: Windows, simulated: Array) -> ChannelSamples:
        """Simulated and measured values in the windows' rows."""
        return ChannelSamples(as_rows(simulated), self.values[windows.rows], self.variance, windows.number_of_rows())


def measured_angles(data: DataSet) -> FrameMeasurement:
    """Angles of the joints as the camera saw them."""
    frames = frame_angles(data)
    return FrameMeasurement(frames.time, frames.alpha, frames.sigma**2)


def measured_motor_angles(data: DataSet) -> RowMeasurement:
    """Angles of the motors as their encoders counted them."""
    log = data.log if data.log.matrix("theta").size else data.state  # a damaged file may have lost the log
    counted = [np.interp(data.state.time, log.time, column) for column in log.matrix("theta").T]
    return RowMeasurement(np.stack(counted, axis=-1), data.count_angles**2 / 12, "rad")


def measured_forces(parameters: RecordingParameters) -> RowMeasurement:
    """Forces of the motors; the command is exact, so that its variance is zero."""
    return RowMeasurement(parameters.f, np.zeros(parameters.f.shape[1]), "N")


def as_rows(values: Array) -> Array:
    """(..., W, samples, columns) -> (..., rows, columns)"""
    return values.reshape(*values.shape[:-3], -1, values.shape[-1])
