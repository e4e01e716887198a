"""Simulations from the measured state, and from it with each independent error added by one sigma.

The errors: principal axes of the covariance of the arm's state at a window's beginning, rounding of each motor's angle and of its
derivatives, principal axes of the covariance of the laws' parameters on the arm as described, and of that of the recording's x0
and delay.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.model_file import Model, covariance_as_described_of
from identification.simulation.recording_parameters import RecordingParameters
from identification.simulation.windows import Windows
from mechanism.laws import law_named
from mechanism.machine import Machine

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PerturbedRuns:
    """Simulations to be run along axis 0, as measured and modelled first, then with each of K perturbations; W windows."""

    machine: Machine
    alpha: Array
    """at the windows' beginnings, (1 + K, W, N), rad, with its derivative"""
    alpha_d: Array
    theta: tuple[Array, Array, Array]
    """offsets of the motors' angles and two derivatives over whole windows, each (1 + K, 1 or W, M)"""
    delay: Array
    """of the forces, (1 + K,), s"""
    shared: int
    """place on axis 0 of the first perturbation that all windows share"""

    @property
    def unperturbed(self) -> "PerturbedRuns":
        """The first of these simulations alone."""
        machine, one = self.machine, slice(0, 1)
        return PerturbedRuns(
            machine=replace(
                machine,
                arm=replace(machine.arm, x0=machine.arm.x0[one]),
                values={name: value[one] for name, value in machine.values.items()},
            ),
            alpha=self.alpha[one],
            alpha_d=self.alpha_d[one],
            theta=(self.theta[0][one], self.theta[1][one], self.theta[2][one]),
            delay=self.delay[one],
            shared=1,
        )


def perturbed_runs(
    windows: Windows, model: Model, machine: Machine, recording: RecordingParameters, of_acceleration: bool
) -> PerturbedRuns:
    """The simulations of these windows. machine: the model's laws on the arm as described; the recording's x0 is added.

    of_acceleration: whether errors of the motors' accelerations count: from forces they are simulated, not given.
    """
    n, m = machine.arm.N, machine.arm.M
    state_axes = _principal_axes(windows.covariance())  # (W, 2 N, 2 N), axes in columns
    rounding = _rounding(windows, ("", "_d", "_dd") if of_acceleration else ("", "_d"))
    law_axes = _law_axes(model, machine)
    recording_axes = _principal_axes(recording.covariance).T
    count = 1 + 2 * n + len(rounding) + len(law_axes) + len(recording_axes)
    start = np.repeat(
        np.concatenate([windows.matrix("alpha")[:, 0], windows.matrix("alpha", "_d")[:, 0]], axis=1)[None],
        count,
        axis=0,
    )
    start[1 : 1 + 2 * n] += np.moveaxis(state_axes, -1, 0)
    motors = np.zeros((3, count, windows.count, m))
    for place, (order, motor, sigma) in enumerate(rounding, 1 + 2 * n):
        motors[order, place, :, motor] = sigma
    values = {name: np.repeat(np.broadcast_to(v, (1, len(v))), count, axis=0) for name, v in machine.values.items()}
    x0, delay = np.repeat(recording.x0[None], count, axis=0), np.full(count, recording.delay)
    shared = 1 + 2 * n + len(rounding)
    for place, change in enumerate(law_axes, shared):
        for (name, index), amount in change.items():
            values[name][place, 0 if index is None else index - 1] += amount
            change_of_recording = recording.by_law[name, index] * amount
            x0[place] += change_of_recording[:m]
            delay[place] += change_of_recording[m]
    for place, axis in enumerate(recording_axes, shared + len(law_axes)):
        x0[place] += axis[:m]
        delay[place] += axis[m]
    for term in (term for name in machine.names for term in law_named(name).terms):
        # an axis has no sign: where it leads out of a law's range, as to a damping that feeds energy in, it is taken inwards
        limit = min(term.low, 0.0)
        if np.isfinite(limit):
            values[term.name] = limit + np.abs(values[term.name] - limit)
    arm = replace(machine.arm, x0=machine.arm.x0 + x0[:, None])
    perturbed = replace(machine, arm=arm, values={name: v[:, None] for name, v in values.items()})
    return PerturbedRuns(
        machine=perturbed,
        alpha=start[..., :n],
        alpha_d=start[..., n:],
        theta=(motors[0], motors[1], motors[2]),
        delay=delay,
        shared=shared,
    )


def _rounding(windows: Windows, suffixes: Sequence[str]) -> list[tuple[int, int, Array]]:
    """Order of the derivative, motor, and its sigma at the windows' beginnings (W,); empty where the data set has no sigmas."""
    errors = []
    for order, suffix in enumerate(suffixes):
        sigma = windows.matrix("sigma_theta", suffix)[:, 0]
        errors += [(order, j, sigma[:, j]) for j in range(sigma.shape[1])]
    return errors


def _law_axes(model: Model, machine: Machine) -> list[Mapping[tuple[str, int | None], float]]:
    """Principal axes of the laws' covariance, each as changes by name and index; infinite variances are left out."""
    terms = {term.name for name in machine.names for term in law_named(name).terms}
    place = [i for i, p in enumerate(model.parameters) if p.name in terms]
    names = [(model.parameters[i].name, model.parameters[i].index) for i in place]
    covariance = covariance_as_described_of(model)[np.ix_(place, place)]
    unknown = ~np.isfinite(np.diag(covariance))
    covariance[unknown] = covariance[:, unknown] = 0.0
    return [
        {name: float(v) for name, v in zip(names, axis, strict=True) if v != 0}
        for axis in _principal_axes(covariance).T
        if axis.any()
    ]


def _principal_axes(covariance: Array) -> Array:
    """Columns A (..., P, P) with A A^T the covariance, by the eigenvectors of its correlations: its numbers differ in unit."""
    sigma = np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1))
    scale = np.where(sigma > 0, sigma, 1.0)
    size, vectors = np.linalg.eigh(covariance / scale[..., None] / scale[..., None, :])
    return scale[..., None] * vectors * np.sqrt(np.maximum(size, 0.0))[..., None, :]
