"""A recording simulated by a model, from its forces or its motor angles, and compared with what was measured."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from identification.cable_memory import memory_states
from identification.dataset.dataset import DataSet
from identification.dataset.series import Series, concatenated, numbered_columns
from identification.held_commands import mean_held_force
from identification.model_file import Model, machine_of
from identification.simulation.channels import Channel, ChannelSums
from identification.simulation.measured import (
    MeasuredQuantity,
    as_rows,
    measured_angles,
    measured_forces,
    measured_motor_angles,
)
from identification.simulation.perturbations import PerturbedRuns, perturbed_runs
from identification.simulation.recording_parameters import RecordingParameters, fit_recording_parameters
from identification.simulation.windows import Windows, windows_of
from mechanism.cable_lengths import Z, lengths
from mechanism.elasticity import elongation, elongation_rate
from mechanism.laws import CableMotion
from mechanism.machine import Machine
from mechanism.simulation import Motion, State, simulate, simulate_given_angles
from xneck_foundation.errors import Refused, one_of
from xneck_foundation.one_blas_thread import one_blas_thread

Array = NDArray[np.float64]
Source = Literal["f", "theta"]
Progress = Callable[[int], object]

WINDOW_S = 0.5
"""s: within it a payload's effect grows faster, with the square of time, than the uncertainty of state and parameters
(docs/thresholds.md)"""
MAX_WINDOWS_AT_ONCE = 16
"""windows that are simulated at once, so that memory does not grow with the recording"""
COMMAND_HISTORY_S = 4.0
"""s of commands before a window that its forces depend on: the longest lag of a motor is 0.2 s"""


@dataclass(frozen=True)
class SimulatedRecording:
    """Simulated and measured series on the same times, and the error of each channel."""

    series: Series
    """columns alphaI, thetaJ, tensionJ as simulated, alphaI_measured, thetaJ_measured; from motor angles also fJ, fJ_measured"""
    channels: tuple[Channel, ...]
    """alphaI in the camera's frames; from forces thetaJ, from motor angles fJ, in the rows of the log"""
    window_s: float
    source: Source
    parameters: RecordingParameters
    """as fitted to the recording"""

    @property
    def rms(self) -> dict[str, float]:
        """By channel; rad, N"""
        return {channel.name: channel.rms for channel in self.channels}


@one_blas_thread
def simulate_recording(
    data: DataSet,
    model: Model,
    window_s: float | None = WINDOW_S,
    source: Source = "f",
    progress: Progress = lambda samples: None,
    max_parts: int | None = None,
    noise_floor: bool = True,
) -> SimulatedRecording:
    """Simulation of a recording, restarted from the measured state every `window_s` seconds; with None it runs on to the end.

    source: what is given of the motors, their recorded forces or their recorded angles. Pre-elongation and delay are fitted to the
    recording, with the laws held. Windows run in batches, each once more for every error that adds to the noise floor; `progress`
    is called with the number of rows done since the last call. max_parts: batches of MAX_WINDOWS_AT_ONCE successive windows, evenly
    spread, where not all are asked for. noise_floor: whether errors are simulated too; without them only sensors add to the noise
    floor. Raises Refused where the recording is shorter than a window or holds no forces.

    >>> import xneck
    >>> found = xneck.simulate(xneck.read_dataset("monday.mcap"), xneck.read_model("model.yaml"))
    >>> worst = max(found.channels, key=lambda channel: channel.ratio)
    >>> worst.ratio > 10  # times what noise alone would leave: this model lacks something
    True
    """
    one_of("simulate", source, get_args(Source), "source")
    if not len(data.state.matrix("f").T):
        raise Refused("simulate", "the data set holds no forces f", "log the force command of every motor")
    windows = windows_of(data, window_s)
    machine = replace(machine_of(model, data.arm), arm=data.arm)
    recording = fit_recording_parameters(data, machine.names, machine.values)
    measured: dict[str, MeasuredQuantity] = {"alpha": measured_angles(data)}
    measured |= {"theta": measured_motor_angles(data)} if source == "f" else {"f": measured_forces(recording)}
    memory = _memory(windows, machine, recording)
    sums: dict[str, ChannelSums] = {}
    series: list[Series] = []
    for part in windows.parts(MAX_WINDOWS_AT_ONCE, max_parts):
        runs = perturbed_runs(part, model, machine, recording, of_acceleration=source == "theta")
        runs = runs if noise_floor else runs.unperturbed
        start_memory = None if memory is None else memory[part.first : part.first + part.count]
        motion = _run(part, runs, start_memory, source, lambda samples, count=part.count: progress(samples * count))
        for stem, quantity in measured.items():
            channel_sums = sums.setdefault(stem, ChannelSums(stem, quantity.unit, runs.shared))
            channel_sums.add(quantity.compared(part, getattr(motion, stem)))
        series.append(_series(part, motion, source))
    channels = [channel for channel_sums in sums.values() for channel in channel_sums.channels()]
    return SimulatedRecording(concatenated(series), tuple(channels), windows.seconds, source, recording)


@one_blas_thread
def simulated_angles(
    data: DataSet,
    model: Model,
    recording: RecordingParameters,
    window_s: float | None = WINDOW_S,
    max_parts: int | None = None,
) -> Array:
    """Joint angles alone, simulated once from the forces, (rows, N), rad: of the windows that `simulate_recording` takes.

    recording: pre-elongation and delay, as they were fitted with another model, say.
    """
    machine = replace(machine_of(model, data.arm), arm=data.arm)
    windows = windows_of(data, window_s)
    memory = _memory(windows, machine, recording)
    angles = []
    for part in windows.parts(MAX_WINDOWS_AT_ONCE, max_parts):
        runs = perturbed_runs(part, model, machine, recording, of_acceleration=False).unperturbed
        start_memory = None if memory is None else memory[part.first : part.first + part.count]
        angles.append(as_rows(_run(part, runs, start_memory, "f", lambda samples: None).alpha[0]))
    return np.concatenate(angles)


def _run(windows: Windows, runs: PerturbedRuns, memory: Array | None, source: Source, progress: Progress) -> Motion:
    theta, theta_d, theta_dd = (
        windows.matrix("theta", suffix) + offset[..., None, :]
        for suffix, offset in zip(("", "_d", "_dd"), runs.theta, strict=True)
    )
    start = State(runs.alpha, runs.alpha_d, theta[..., 0, :], theta_d[..., 0, :], memory)
    if source == "theta":
        angles = (theta, theta_d, theta_dd)
        return simulate_given_angles(runs.machine, start, windows.time, angles, progress=progress, began=windows.began)
    machine = runs.machine.without_actuator_laws
    return simulate(machine, start, windows.time, _forces(windows, runs), progress=progress, began=windows.began)


def _forces(windows: Windows, runs: PerturbedRuns) -> Array:
    """Forces that act, (1 + K, W, samples, M), N: means over each row's interval of the held forces, shifted by each run's delay.

    Motors that lag need the commands before a window. Before the first row of the recording and after its last one the force of
    that row is taken.
    """
    step, rows = windows.step, windows.rows
    beyond = 1 + int(np.ceil(np.max(np.abs(runs.delay)) / step))
    before = max(beyond, round(COMMAND_HISTORY_S / step))
    near = windows.data.state.part(slice(max(0, rows.start - before), rows.stop + beyond))
    machine = replace(runs.machine, values={name: value[:, :1] for name, value in runs.machine.values.items()})
    f = near.matrix("f")
    acting = np.broadcast_to(machine.acting_force(f, step), (len(runs.delay), *f.shape))
    begin = min(before, rows.start)
    edges = np.arange(begin, begin + rows.stop - rows.start + 1)
    means = [mean_held_force(f, edges - delay / step) for f, delay in zip(acting, runs.delay, strict=True)]
    return np.stack([windows.cut(mean) for mean in means])


def _memory(windows: Windows, machine: Machine, recording: RecordingParameters) -> Array | None:
    """Memory variables of the cables at the windows' beginnings, along the measured motion, (W, M, states)."""
    if not machine.states:
        return None
    arm, s = windows.data.arm, windows.data.state
    of_recording = replace(
        machine,
        arm=replace(machine.arm, x0=machine.arm.x0 + recording.x0),
        values={**machine.values, **recording.memory_start},
    )
    alpha, theta = s.matrix("alpha"), s.matrix("theta")
    x_d = elongation_rate(arm, Z(arm, alpha), s.matrix("alpha", "_d"), s.matrix("theta", "_d"))
    at = CableMotion(
        elongation(of_recording.arm, alpha, theta),
        x_d,
        lengths(arm, alpha),
        of_recording.arm,
        arm.drum * s.matrix("theta", "_d"),
        theta / arm.gear,
    )
    return memory_states(of_recording, at, windows.step)[windows.rows][:: windows.samples]


def _series(windows: Windows, motion: Motion, source: Source) -> Series:
    columns: dict[str, Array] = {}
    stems = ("alpha", "theta", "f") if source == "theta" else ("alpha", "theta")
    for stem in stems:
        # a copy, so that the other runs are freed
        columns |= numbered_columns(stem, as_rows(getattr(motion, stem)[0]).copy())
        columns |= numbered_columns(stem, windows.state.matrix(stem), "_measured")
    columns |= numbered_columns("tension", as_rows(motion.tension[0]).copy())
    return Series(windows.state.time, columns)
