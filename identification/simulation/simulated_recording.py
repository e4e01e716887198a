"""The recorded forces, or the recorded motor angles, through the model, beside what was measured."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from identification.cable_memory import memory_states
from identification.dataset.dataset import DataSet
from identification.dataset.series import Series, concatenated, numbered_columns
from identification.model_file import Model, machine_of
from identification.simulation.channels import Channel, ChannelSums
from identification.simulation.recording_parameters import RecordingParameters, fit_recording_parameters
from identification.simulation.measured import MeasuredQuantity, measured_angles, measured_motor_angles, measured_forces, as_rows
from identification.simulation.perturbations import PerturbedRuns, perturbed_runs
from identification.simulation.windows import Windows, windows_of
from mechanism.cable_lengths import Z, lengths
from mechanism.elasticity import elongation, elongation_rate
from mechanism.laws import Stretching
from mechanism.machine import Machine
from mechanism.simulation import Motion, State, simulate_given_angles, simulate
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]
Source = Literal["f", "theta"]
Progress = Callable[[int], object]

WINDOW_S = 0.5
"""s: until then what a payload does grows faster than what state and parameters leave unknown, by the square of the time"""
MAX_WINDOWS_AT_ONCE = 8
"""windows, that memory does not grow with the recording"""
COMMAND_HISTORY_S = 4.0
"""s of what was written before a window, of which motors that lag by .2 s have forgotten all"""


@dataclass(frozen=True)
class SimulatedRecording:
    """Simulated and measured series on the same times, and the error of each channel."""

    series: Series
    """columns alphaI, thetaJ, tensionJ as simulated, alphaI_measured, thetaJ_measured; from motor angles also fJ, fJ_measured"""
    channels: tuple[Channel, ...]
    """alphaI in the camera's frames; from forces thetaJ, from motor angles fJ, in the rows of the log"""
    window_s: float
    source: Source

    @property
    def rms(self) -> dict[str, float]:
        """By channel; rad, N"""
        return {channel.name: channel.rms for channel in self.channels}


def simulate_recording(
    data: DataSet,
    model: Model,
    window_s: float | None = WINDOW_S,
    source: Source = "f",
    progress: Progress = lambda samples: None,
) -> SimulatedRecording:
    """Restarted from the measured state every `window_s` seconds, or with None free-running from the first sample.

    source: what is given to the motors, the recorded forces or the recorded motor angles. Where the motors started and how
    late they act is fitted to the recording anew, with the laws held. Windows run in batches, each once more for everything that
    may be off; `progress` is told of every row of them. Raises Refused where the recording is shorter than a window or holds no
    forces.

    >>> import xneck
    >>> found = xneck.simulate(xneck.read_dataset("monday.mcap"), xneck.read_model("model.yaml"))
    >>> worst = max(found.channels, key=lambda channel: channel.ratio)
    >>> worst.ratio > 10  # times what noise alone would leave: this model lacks something
    True
    """
    if not len(data.state.matrix("f").T):
        raise Refused("simulate", "the data set holds no forces f", "log the force command of every motor")
    windows = windows_of(data, window_s)
    machine = replace(machine_of(model, data.arm), arm=data.arm)
    own = fit_recording_parameters(data, machine.names, machine.values)
    measured: dict[str, MeasuredQuantity] = {"alpha": measured_angles(data)}
    measured |= {"theta": measured_motor_angles(data)} if source == "f" else {"f": measured_forces(own)}
    memory = _memory(windows, machine, own)
    tallies: dict[str, ChannelSums] = {}
    series: list[Series] = []
    for part in windows.parts(MAX_WINDOWS_AT_ONCE):
        cases = perturbed_runs(part, model, machine, own)
        begun = None if memory is None else memory[part.first : part.first + part.count]
        motion = _run(part, cases, begun, source, lambda samples, count=part.count: progress(samples * count))
        for stem, of in measured.items():
            tally = tallies.setdefault(stem, ChannelSums(stem, of.unit, cases.shared))
            tally.add(of.beside(part, getattr(motion, stem)))
        series.append(_series(part, motion, source))
    channels = [channel for tally in tallies.values() for channel in tally.channels()]
    return SimulatedRecording(concatenated(series), tuple(channels), windows.seconds, source)


def _run(windows: Windows, cases: PerturbedRuns, memory: Array | None, source: Source, progress: Progress) -> Motion:
    place, speed, gain = (
        windows.matrix("theta", suffix) + offset[..., None, :]
        for suffix, offset in zip(("", "_d", "_dd"), cases.theta, strict=True)
    )
    start = State(cases.alpha, cases.alpha_d, place[..., 0, :], speed[..., 0, :], memory)
    if source == "theta":
        return simulate_given_angles(cases.machine, start, windows.time, (place, speed, gain), progress=progress)
    return simulate(cases.machine.given_forces, start, windows.time, _forces(windows, cases), progress=progress)


def _forces(windows: Windows, cases: PerturbedRuns) -> Array:
    """Forces that act, (cases, W, samples, M): of each row the mean of what is held while it lasts, later by the case's delay.

    Motors that lag remember what was written before a window. Before the first row of the recording and after its last the force
    is taken to be theirs.
    """
    step, rows = windows.step, windows.rows
    beyond = 1 + int(np.ceil(np.max(np.abs(cases.delay)) / step))
    before = max(beyond, round(COMMAND_HISTORY_S / step))
    near = windows.data.state.part(slice(max(0, rows.start - before), rows.stop + beyond))
    machine = replace(cases.machine, values={name: value[:, :1] for name, value in cases.machine.values.items()})
    f = near.matrix("f")
    acting = np.broadcast_to(machine.command(f, step), (len(cases.delay), *f.shape))
    edges = np.append(near.time, near.time[-1] + step)
    far = step * np.arange(1, beyond + 1)
    held = np.concatenate([edges[0] - far[::-1], edges, edges[-1] + far])
    asked = edges[min(before, rows.start) :][: rows.stop - rows.start + 1]
    out = []
    for one, late in zip(acting, cases.delay, strict=True):
        padded = np.pad(one, ((beyond, beyond), (0, 0)), mode="edge")
        summed = np.vstack([np.zeros(one.shape[1]), np.cumsum(padded * np.diff(held)[:, None], axis=0)])
        through = np.stack([np.interp(asked - late, held, column) for column in summed.T], axis=-1)
        out.append(windows.cut(np.diff(through, axis=0) / np.diff(asked)[:, None]))
    return np.stack(out)


def _memory(windows: Windows, machine: Machine, own: RecordingParameters) -> Array | None:
    """What cables remember at the windows' beginnings, along the measured motion, (W, M, states)."""
    if not machine.states:
        return None
    arm, s = windows.data.arm, windows.data.state
    mine = replace(machine, arm=replace(machine.arm, x0=machine.arm.x0 + own.x0))
    alpha, theta = s.matrix("alpha"), s.matrix("theta")
    x_d = elongation_rate(arm, Z(arm, alpha), s.matrix("alpha", "_d"), s.matrix("theta", "_d"))
    at = Stretching(
        elongation(mine.arm, alpha, theta), x_d, lengths(arm, alpha), mine.arm, arm.drum * s.matrix("theta", "_d")
    )
    return memory_states(mine, at, windows.step)[windows.rows][:: windows.samples]


def _series(windows: Windows, motion: Motion, source: Source) -> Series:
    columns: dict[str, Array] = {}
    stems = ("alpha", "theta", "f") if source == "theta" else ("alpha", "theta")
    for stem in stems:
        # a copy, that all other cases need not stay
        columns |= numbered_columns(stem, as_rows(getattr(motion, stem)[0]).copy())
        columns |= numbered_columns(stem, windows.state.matrix(stem), "_measured")
    columns |= numbered_columns("tension", as_rows(motion.tension[0]).copy())
    return Series(windows.state.time, columns)
