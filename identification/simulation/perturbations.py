"""What a simulation from a measured state starts from, and what of it may be off: each doubt by one sigma, one after another.

Doubts are independent: axes of the covariance of the arm's state at a window's beginning, rounding of each motor's angle and what
it does to its derivatives, axes of the covariance of the laws' numbers, and of the recording's own x0 and delay.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.model_file import Model, covariance_of
from identification.simulation.recording_parameters import RecordingParameters
from identification.simulation.windows import Windows
from mechanism.laws import LAWS
from mechanism.machine import Machine

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PerturbedRuns:
    """Simulations to be run, axis 0: as measured and modelled first, then with each doubt; W windows."""

    machine: Machine
    alpha: Array
    """(cases, W, N)"""
    alpha_d: Array
    theta: tuple[Array, Array, Array]
    """offsets of the motors' angles and derivatives for whole windows, each (cases, 1 or W, M)"""
    delay: Array
    """(cases,), s"""
    shared: int
    """first case with a doubt that is the same in all windows"""


def perturbed_runs(windows: Windows, model: Model, machine: Machine, own: RecordingParameters) -> PerturbedRuns:
    """machine: the model's laws on the arm as described, whose x0 `own` says how far to be off."""
    n, m = machine.arm.N, machine.arm.M
    starts = _axes(windows.covariance())  # (W, 2 N, 2 N), columns
    rounding = _rounding(windows)
    laws = _law_axes(model, machine)
    mine = _axes(own.covariance).T
    count = 1 + 2 * n + len(rounding) + len(laws) + len(mine)
    start = np.repeat(
        np.concatenate([windows.matrix("alpha")[:, 0], windows.matrix("alpha", "_d")[:, 0]], axis=1)[None],
        count,
        axis=0,
    )
    start[1 : 1 + 2 * n] += np.moveaxis(starts, -1, 0)
    motors = np.zeros((3, count, windows.count, m))
    for place, (order, motor, sigma) in enumerate(rounding, 1 + 2 * n):
        motors[order, place, :, motor] = sigma
    values = {name: np.repeat(np.broadcast_to(v, (1, len(v))), count, axis=0) for name, v in machine.values.items()}
    x0, delay = np.repeat(own.x0[None], count, axis=0), np.full(count, own.delay)
    first = 1 + 2 * n + len(rounding)
    for place, change in enumerate(laws, first):
        for (name, index), amount in change.items():
            values[name][place, 0 if index is None else index - 1] += amount
            moved = own.by_law[name, index] * amount
            x0[place] += moved[:m]
            delay[place] += moved[m]
    for place, axis in enumerate(mine, first + len(laws)):
        x0[place] += axis[:m]
        delay[place] += axis[m]
    arm = replace(machine.arm, x0=machine.arm.x0 + x0[:, None])
    of_cases = replace(machine, arm=arm, values={name: v[:, None] for name, v in values.items()})
    return PerturbedRuns(of_cases, start[..., :n], start[..., n:], (motors[0], motors[1], motors[2]), delay, first)


def _rounding(windows: Windows) -> list[tuple[int, int, Array]]:
    """Order of the derivative, motor, and sigma at the windows' beginnings (W,); none where the data set does not say."""
    found = []
    for order, suffix in enumerate(("", "_d", "_dd")):
        sigma = windows.matrix("sigma_theta", suffix)[:, 0]
        found += [(order, j, sigma[:, j]) for j in range(sigma.shape[1])]
    return found


def _law_axes(model: Model, machine: Machine) -> list[Mapping[tuple[str, int | None], float]]:
    """Axes of the laws' covariance as changes of their numbers; of what has none nothing is changed."""
    terms = {term.name for name in machine.names for term in LAWS[name].terms}
    place = [i for i, p in enumerate(model.parameters) if p.name in terms]
    names = [(model.parameters[i].name, model.parameters[i].index) for i in place]
    whole = covariance_of(model)[np.ix_(place, place)]
    unknown = ~np.isfinite(np.diag(whole))
    whole[unknown] = whole[:, unknown] = 0.0
    return [
        {name: float(v) for name, v in zip(names, axis, strict=True) if v != 0} for axis in _axes(whole).T if axis.any()
    ]


def _axes(covariance: Array) -> Array:
    """Columns (..., P, P) whose squares make up a covariance, by its correlations: its numbers have different units."""
    sigma = np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1))
    scale = np.where(sigma > 0, sigma, 1.0)
    size, vectors = np.linalg.eigh(covariance / scale[..., None] / scale[..., None, :])
    return scale[..., None] * vectors * np.sqrt(np.maximum(size, 0.0))[..., None, :]
