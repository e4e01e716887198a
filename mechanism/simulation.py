"""The whole in motion: arm, elastic cables and motors under given motor forces.

    arm     M(alpha) alpha'' + c + g = Z t                       (44)
    motors  Ia theta'' = (rd/R) (f - friction - t)               (43)
    cables  t = max(0, k x + ca x'), a cable cannot push         (53), (57)

The classical Runge-Kutta method with a fixed step, forces held between samples as a controller holds them. Every state
has leading axes for a batch, so that many parameter sets, or many windows of one recording, run at once.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mechanism.arm import Arm, Array
from mechanism.cable_lengths import Z, lengths
from mechanism.dynamics import terms
from mechanism.elasticity import Model, elongation_rate, strain_scale
from mechanism.friction import CM, friction
from xneck.errors import Refused


@dataclass(frozen=True)
class Drive:
    """Cables and motor friction, each shape (..., M): stiffness in N/m and damping in N s/m (models 2, 3: Pa and Pa s),
    dry friction fs in N, viscous friction fv in N s/rad on the motor side."""

    stiffness: Array
    damping: Array
    fs: Array
    fv: Array
    model: Model = 1
    cm: float = CM


@dataclass(frozen=True)
class State:
    """alpha, alpha_d of shape (..., N), rad and rad/s; theta, theta_d of shape (..., M), rad and rad/s."""

    alpha: Array
    alpha_d: Array
    theta: Array
    theta_d: Array


@dataclass(frozen=True)
class Motion:
    """States and cable tensions over time, axis -2 is time; time of shape (T,), s; tension in N."""

    time: Array
    alpha: Array
    alpha_d: Array
    theta: Array
    theta_d: Array
    tension: Array


def tension(arm: Arm, drive: Drive, alpha: Array, x: Array, x_d: Array) -> Array:
    """t = max(0, stiffness x + damping x'), scaled as the elastic model says; shape (..., M), N."""
    pull = strain_scale(arm, alpha, drive.model) * (drive.stiffness * x + drive.damping * x_d)
    return np.maximum(pull, 0.0)


def simulate(
    arm: Arm,
    drive: Drive,
    start: State,
    time: Array,
    f: Array,
    max_step: float | None = None,
    progress: Callable[[int], object] = lambda samples: None,
) -> Motion:
    """The motion from `start` under motor forces f.

    time: shape (T,), s, increasing. f: shape (..., T, M), N, f[k] held from time[k] to time[k + 1]. Batch axes of arm, drive,
    start and f broadcast. Steps are shorter than `max_step` (default: the fastest time constant, error about 1e-8 rad).
    `progress` is told of every sample done. Raises Refused where the motion leaves the mechanism's range.
    """
    time = np.asarray(time, dtype=float)
    l0 = lengths(arm, np.zeros(arm.N))
    shape = np.broadcast_shapes(start.alpha.shape[:-1], arm.L.shape[:-1], drive.fs.shape[:-1], f.shape[:-2])
    y = np.concatenate(
        [
            np.broadcast_to(part, (*shape, part.shape[-1]))
            for part in (start.alpha, start.alpha_d, start.theta, start.theta_d)
        ],
        axis=-1,
    )
    n, m = arm.N, arm.M
    cuts = (n, 2 * n, 2 * n + m)

    def pulls(alpha: Array, alpha_d: Array, theta: Array, theta_d: Array) -> tuple[Array, Array]:
        jacobian = Z(arm, alpha)
        x = lengths(arm, alpha) - l0 + arm.drum * theta + arm.x0
        x_d = elongation_rate(arm, jacobian, alpha_d, theta_d)
        return tension(arm, drive, alpha, x, x_d), jacobian

    def rate(y: Array, force: Array) -> Array:
        alpha, alpha_d, theta, theta_d = np.split(y, cuts, axis=-1)
        t, jacobian = pulls(alpha, alpha_d, theta, theta_d)
        k = terms(arm, alpha, alpha_d)
        torque = np.einsum("...ij,...j->...i", jacobian, t) - k.c - k.g
        alpha_dd = np.linalg.solve(k.M, torque[..., None])[..., 0]
        net = force - friction(theta_d, drive.fs, drive.fv, drive.cm) - t
        return np.concatenate([alpha_d, alpha_dd, theta_d, arm.drum * net / arm.motor_inertia], axis=-1)

    step = max_step or 1.0 / fastest_rate(arm, drive, State(*np.split(y, cuts, axis=-1)))
    out = np.empty((*shape, len(time), y.shape[-1]))
    out[..., 0, :] = y
    tensions = np.empty((*shape, len(time), m))
    tensions[..., 0, :] = pulls(*np.split(y, cuts, axis=-1))[0]
    with np.errstate(invalid="ignore", over="ignore"):
        for i, interval in enumerate(np.diff(time)):
            substeps = max(1, int(np.ceil(interval / step - 1e-9)))
            h = interval / substeps
            force = f[..., i, :]
            for _ in range(substeps):
                k1 = rate(y, force)
                k2 = rate(y + h / 2 * k1, force)
                k3 = rate(y + h / 2 * k2, force)
                k4 = rate(y + h * k3, force)
                y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            if not np.all(np.abs(y[..., :n]) < np.pi):
                raise Refused(
                    "simulation",
                    f"the arm leaves the range of its mechanisms at {time[i + 1]:.3f} s",
                    "check forces, start and parameters, or simulate in shorter windows",
                )
            out[..., i + 1, :] = y
            tensions[..., i + 1, :] = pulls(*np.split(y, cuts, axis=-1))[0]
            progress(1)
    return Motion(time, *np.split(out, cuts, axis=-1), tension=tensions)


def fastest_rate(arm: Arm, drive: Drive, state: State) -> float:
    """An upper bound of the system's rates at `state`, rad/s: elastic modes, cable damping, dry friction's slope."""
    M = terms(arm, state.alpha, np.zeros_like(state.alpha)).M
    jacobian = Z(arm, state.alpha)
    scale = strain_scale(arm, state.alpha, drive.model)
    compliance = np.swapaxes(jacobian, -1, -2) @ np.linalg.solve(M, jacobian)  # inverse mass seen along the cables
    inverse_mass = np.linalg.eigvalsh(compliance)[..., -1:] + 1 / arm.motor_mass
    elastic = np.sqrt(np.max(scale * drive.stiffness * inverse_mass))
    damped = np.max(scale * np.abs(drive.damping) * inverse_mass)
    dry = np.max(drive.fs * 2 / np.pi * drive.cm * arm.drum / arm.motor_inertia)
    return float(max(elastic, damped, dry))
