"""The recorded forces, or the recorded motor angles, through the model, beside what was measured."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from identification.dataset import DataSet
from identification.frames import seen_in
from identification.memory import remembered
from identification.model import Model, machine_of
from identification.series import Series, numbered
from identification.simulation.channels import Channel, channels_of
from identification.simulation.doubts import Cases, cases_of
from identification.simulation.own import Own, own_of
from identification.simulation.windows import Windows, windows_of
from mechanism.cable_lengths import Z, lengths
from mechanism.elasticity import elongation, elongation_rate
from mechanism.laws import Stretching
from mechanism.machine import Machine
from mechanism.simulation import Motion, State, follow, simulate
from xneck.errors import Refused

Array = NDArray[np.float64]
Source = Literal["f", "theta"]
Progress = Callable[[int], object]

WINDOW_S = 0.5
"""s: until then what a payload does grows faster than what state and parameters leave unknown, by the square of the time"""


@dataclass(frozen=True)
class Simulated:
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
) -> Simulated:
    """Restarted from the measured state every `window_s` seconds, or with None free-running from the first sample.

    source: what is given to the motors, the recorded forces or the recorded motor angles. Where the motors started and how
    late they act is fitted to the recording anew, with the laws held. All windows, each once more for everything that may be
    off, run as one batch; `progress` is told of every sample of it. Raises Refused where the recording is shorter than a
    window or holds no forces.

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
    own = own_of(data, machine.names, machine.values)
    cases = cases_of(windows, model, machine, own)
    motion = _run(windows, cases, source, progress)
    channels = _of_arm(windows, motion, cases.shared) + (
        _of_motors(windows, motion, cases.shared) if source == "f" else _of_forces(windows, motion, cases.shared, own)
    )
    return Simulated(_series(windows, motion, source), tuple(channels), windows.seconds, source)


def _run(windows: Windows, cases: Cases, source: Source, progress: Progress) -> Motion:
    place, speed, gain = (
        windows.state("theta", suffix) + offset[..., None, :]
        for suffix, offset in zip(("", "_d", "_dd"), cases.theta, strict=True)
    )
    start = State(cases.alpha, cases.alpha_d, place[..., 0, :], speed[..., 0, :], _memory(windows, cases.machine))
    if source == "theta":
        return follow(cases.machine, start, windows.time, (place, speed, gain), progress=progress)
    forces = _late(windows, _acting(windows, cases), cases.delay)
    return simulate(cases.machine.given_forces, start, windows.time, forces, progress=progress)


def _acting(windows: Windows, cases: Cases) -> Array:
    """Forces that act for what is written, along the whole recording: motors that lag remember what was before a window.

    (cases, T, M)
    """
    f = windows.data.state.matrix("f")
    whole = replace(cases.machine, values={name: value[:, :1] for name, value in cases.machine.values.items()})
    return np.broadcast_to(whole.command(f, windows.step), (len(cases.delay), *f.shape))


def _late(windows: Windows, acting: Array, delay: Array) -> Array:
    """Forces (cases, W, samples, M): of each row the mean of what is held while it lasts, `delay` (cases,) earlier.

    Before the first row and after the last the force is taken to be theirs.
    """
    time, step = windows.data.state.time, windows.step
    edges = np.append(time, time[-1] + step)
    beyond = 1 + int(np.ceil(np.max(np.abs(delay)) / step))
    far = step * np.arange(1, beyond + 1)
    held = np.concatenate([edges[0] - far[::-1], edges, edges[-1] + far])
    out = []
    for one, late in zip(acting, delay, strict=True):
        f = np.pad(one, ((beyond, beyond), (0, 0)), mode="edge")
        summed = np.vstack([np.zeros(f.shape[1]), np.cumsum(f * np.diff(held)[:, None], axis=0)])
        through = np.stack([np.interp(edges - late, held, column) for column in summed.T], axis=-1)
        out.append(windows.cut(np.diff(through, axis=0) / np.diff(edges)[:, None]))
    return np.stack(out)


def _memory(windows: Windows, machine: Machine) -> Array | None:
    """What cables remember at the windows' beginnings, along the measured motion, (W, M, states)."""
    if not machine.states:
        return None
    arm, s = windows.data.arm, windows.data.state
    first = replace(
        machine,
        arm=replace(arm, x0=machine.arm.x0[0, 0]),
        values={name: value[0, 0] for name, value in machine.values.items()},
    )
    alpha, theta = s.matrix("alpha"), s.matrix("theta")
    x_d = elongation_rate(arm, Z(arm, alpha), s.matrix("alpha", "_d"), s.matrix("theta", "_d"))
    at = Stretching(
        elongation(first.arm, alpha, theta), x_d, lengths(arm, alpha), first.arm, arm.drum * s.matrix("theta", "_d")
    )
    return remembered(first, at, windows.step)[: windows.kept : windows.samples]


def _series(windows: Windows, motion: Motion, source: Source) -> Series:
    columns: dict[str, Array] = {}
    stems = ("alpha", "theta", "f") if source == "theta" else ("alpha", "theta")
    for stem in stems:
        measured = windows.state(stem).reshape(windows.kept, -1)
        columns |= numbered(stem, getattr(motion, stem)[0].reshape(windows.kept, -1))
        columns |= numbered(stem, measured, "_measured")
    columns |= numbered("tension", motion.tension[0].reshape(windows.kept, -1))
    return Series(windows.data.state.time[: windows.kept], columns)


def _of_arm(windows: Windows, motion: Motion, shared: int) -> list[Channel]:
    """Angles in the camera's frames."""
    time, seen = windows.data.state.time[: windows.kept], seen_in(windows.data)
    inside = (seen.time >= time[0]) & (seen.time < time[-1])
    row = np.searchsorted(time, seen.time[inside], side="right") - 1
    within = row % windows.samples < windows.samples - 1  # between rows of one window
    row, frame = row[within], np.flatnonzero(inside)[within]
    share = ((seen.time[frame] - time[row]) / (time[row + 1] - time[row]))[:, None]
    alpha = _in_rows(windows, motion.alpha)
    found = (1 - share) * alpha[:, row] + share * alpha[:, row + 1]
    return channels_of("alpha", "rad", found, shared, seen.alpha[frame], seen.sigma[frame] ** 2, _counted(windows)[row])


def _of_motors(windows: Windows, motion: Motion, shared: int) -> list[Channel]:
    """Motor angles in the rows of the log, as counted."""
    data, time = windows.data, windows.data.state.time[: windows.kept]
    log = data.log if data.log.matrix("theta").size else data.state  # a damaged file may have lost the log
    counted = np.stack([np.interp(time, log.time, column) for column in log.matrix("theta").T], axis=-1)
    variance = np.array([2 * np.pi / motor.counts for motor in data.neck.motors]) ** 2 / 12
    return channels_of("theta", "rad", _in_rows(windows, motion.theta), shared, counted, variance, _counted(windows))


def _of_forces(windows: Windows, motion: Motion, shared: int, own: Own) -> list[Channel]:
    """What motors give for the motion that they made; the command itself is exact."""
    measured = own.f[: windows.kept]
    return channels_of("f", "N", _in_rows(windows, motion.f), shared, measured, np.zeros(()), _counted(windows))


def _in_rows(windows: Windows, values: Array) -> Array:
    """(cases, W, samples, columns) -> (cases, rows, columns)"""
    return values.reshape(len(values), windows.kept, -1)


def _counted(windows: Windows) -> NDArray[np.intp]:
    """Window of each row, -1 where it has a gap."""
    return np.repeat(np.where(windows.whole(), np.arange(windows.count), -1), windows.samples)
