"""The whole in motion: arm, elastic cables and motors under given motor forces.

    arm     M(alpha) alpha'' + c + g + joint friction = Z t      (44)
    motors  Ia theta'' = (rd/R) (f - friction - t)               (43)
    cables  t by their laws, a cable cannot push                 (53), (57)

The classical Runge-Kutta method with a fixed step, forces held between samples as a controller holds them. Every state
has leading axes for a batch, so that many parameter sets, or many windows of one recording, run at once.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mechanism.arm import Array
from mechanism.cable_lengths import Z, lengths, wraps
from mechanism.dynamics import terms
from mechanism.elasticity import elongation_rate
from mechanism.laws import Stretching, Turning
from mechanism.machine import Machine
from xneck.errors import Refused

TYPICAL_STRETCH, TYPICAL_TENSION, SMALL = 0.01, 100.0, 1e-6
"""m, N: where the fastest rate is judged; and the step of differences"""


@dataclass(frozen=True)
class State:
    """alpha, alpha_d of shape (..., N), rad and rad/s; theta, theta_d of shape (..., M), rad and rad/s."""

    alpha: Array
    alpha_d: Array
    theta: Array
    theta_d: Array
    memory: Array | None = None
    """what cables remember, (..., M, states); None: nothing yet"""


@dataclass(frozen=True)
class Motion:
    """States and cable tensions over time, axis -2 is time; time of shape (T,), s; tension in N."""

    time: Array
    alpha: Array
    alpha_d: Array
    theta: Array
    theta_d: Array
    tension: Array


def simulate(
    machine: Machine,
    start: State,
    time: Array,
    f: Array,
    max_step: float | None = None,
    progress: Callable[[int], object] = lambda samples: None,
) -> Motion:
    """The motion from `start` under motor forces f.

    time: shape (T,), s, increasing. f: shape (..., T, M), N, f[k] held from time[k] to time[k + 1]. Batch axes of the
    machine's arm and values, of start and f broadcast. Steps are shorter than `max_step` (default: the fastest time
    constant, error about 1e-8 rad). `progress` is told of every sample done. Raises Refused where the motion leaves the
    mechanism's range.
    """
    time = np.asarray(time, dtype=float)
    arm = machine.arm
    n, m, states = arm.N, arm.M, machine.states
    l0 = lengths(arm, np.zeros(n))
    of_values = [np.shape(v)[:-1] for v in machine.values.values()]
    shape = np.broadcast_shapes(start.alpha.shape[:-1], arm.L.shape[:-1], f.shape[:-2], *of_values)
    memory = np.zeros((*shape, m, states)) if start.memory is None else start.memory
    parts = (start.alpha, start.alpha_d, start.theta, start.theta_d, memory.reshape(*memory.shape[:-2], m * states))
    y = np.concatenate([np.broadcast_to(part, (*shape, part.shape[-1])) for part in parts], axis=-1)
    cuts = (n, 2 * n, 2 * n + m, 2 * (n + m))

    def stretched(alpha: Array, alpha_d: Array, theta: Array, theta_d: Array) -> tuple[Stretching, Array]:
        jacobian, length = Z(arm, alpha), lengths(arm, alpha)
        x = length - l0 + arm.drum * theta + arm.x0
        rate = elongation_rate(arm, jacobian, alpha_d, theta_d)
        return Stretching(x, rate, length, arm, arm.drum * theta_d), jacobian

    def rate(y: Array, force: Array) -> Array:
        alpha, alpha_d, theta, theta_d, memory = np.split(y, cuts, axis=-1)
        z = memory.reshape(*shape, m, states)
        at, jacobian = stretched(alpha, alpha_d, theta, theta_d)
        t = machine.tension(at, z)
        k = terms(arm, alpha, alpha_d)
        torque = np.einsum("...ij,...j->...i", jacobian, t) - k.c - k.g - machine.resistance(alpha_d)
        alpha_dd = np.linalg.solve(k.M, torque[..., None])[..., 0]
        net = force - machine.friction(Turning(theta_d, t, wraps(arm, alpha))) - t
        theta_dd = arm.drum * net / arm.motor_inertia
        remembered = machine.drift(at, z).reshape(*shape, m * states)
        return np.concatenate([alpha_d, alpha_dd, theta_d, theta_dd, remembered], axis=-1)

    def pulls(y: Array) -> Array:
        *place, memory = np.split(y, cuts, axis=-1)
        return machine.tension(stretched(*place)[0], memory.reshape(*shape, m, states))

    step = max_step or 1.0 / fastest_rate(machine, State(*np.split(y, cuts, axis=-1)[:4]))
    out = np.empty((*shape, len(time), y.shape[-1]))
    out[..., 0, :] = y
    tensions = np.empty((*shape, len(time), m))
    tensions[..., 0, :] = pulls(y)
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
            tensions[..., i + 1, :] = pulls(y)
            progress(1)
    return Motion(time, *np.split(out, cuts, axis=-1)[:4], tension=tensions)


def fastest_rate(machine: Machine, state: State) -> float:
    """An upper bound of the system's rates at `state`, rad/s: elastic modes, cable damping, dry friction's slope."""
    arm = machine.arm
    M = terms(arm, state.alpha, np.zeros_like(state.alpha)).M
    jacobian, length = Z(arm, state.alpha), lengths(arm, state.alpha)
    compliance = np.swapaxes(jacobian, -1, -2) @ np.linalg.solve(M, jacobian)  # inverse mass seen along the cables
    inverse_mass = np.linalg.eigvalsh(compliance)[..., -1:] + 1 / arm.motor_mass
    rest = np.zeros(np.broadcast_shapes(state.theta.shape, length.shape))
    stretch = TYPICAL_STRETCH + rest
    z = np.zeros((*rest.shape, machine.states))

    def pull(x: Array, x_d: Array) -> Array:
        return machine.pull(Stretching(x, x_d, length, arm, x_d), z)

    def rubbing(theta_d: Array) -> Array:
        return machine.friction(Turning(theta_d, TYPICAL_TENSION + rest, wraps(arm, state.alpha) + rest))

    stiffness = (pull(stretch + SMALL, rest) - pull(stretch, rest)) / SMALL
    damping = (pull(stretch, rest + SMALL) - pull(stretch, rest)) / SMALL
    dry = np.max((rubbing(rest + SMALL) - rubbing(rest)) / SMALL * arm.drum / arm.motor_inertia)
    return float(max(np.sqrt(np.max(stiffness * inverse_mass)), np.max(np.abs(damping) * inverse_mass), dry))
