"""M(alpha), c(alpha, alpha') and g(alpha) of M alpha'' + c + g = Z t (1), (44), for the arm without its motors.

Bodies are the bars 1..N and 2N diagonals. M sums m |dv|^2 + I domega^2 over them; c is the force that their acceleration at
alpha'' = 0 takes, which equals the Christoffel terms of M; g is the gradient of gravity and spring energy.
"""

from dataclasses import dataclass

import numpy as np

from mechanism.arm import Arm, Array
from mechanism.geometry import Complex, poses, sides


@dataclass(frozen=True)
class _Bodies:
    """All moving bodies, axis K = 3N: mass, inertia (..., K); Jacobians (..., K, N); accelerations at alpha'' = 0."""

    mass: Array
    inertia: Array
    centre: Complex
    velocity_by: Complex
    turning_by: Array
    acceleration: Complex
    turning_acceleration: Array


def _bodies(arm: Arm, alpha: Array, alpha_d: Array) -> _Bodies:
    s = sides(arm, alpha)
    p = poses(arm, alpha)
    n = arm.N
    rate = np.concatenate([np.zeros((*alpha_d.shape[:-1], 1)), np.cumsum(alpha_d, axis=-1)], axis=-1)  # gamma'
    below = np.exp(1j * p.bar_angle[..., :-1])
    turn = 1j * np.exp(1j * alpha / 2)  # direction of the middle line, against the bottom bar
    com = arm.top_com[..., 0] + 1j * arm.top_com[..., 1]

    def local(f: Array, f1: Array, f2: Array) -> tuple[Complex, Complex, Complex]:
        """z = f(alpha) j exp(j alpha/2) in the bottom bar's frame and its derivatives by alpha."""
        return turn * f, turn * (f1 + 0.5j * f), turn * (f2 + 1j * f1 - 0.25 * f)

    middle = local(s.d, s.d1, s.d2)
    on_top = np.exp(1j * alpha)
    top = (middle[0] + com * on_top, middle[1] + 1j * com * on_top, middle[2] - com * on_top)
    A = local(s.right / 2, s.right1 / 2, s.right2 / 2)
    B = local(s.left / 2, s.left1 / 2, s.left2 / 2)
    # orientation against the bottom bar: alpha; alpha/2 +- atan2(d, b cos(alpha/2)), whose slope is b sin(alpha/2) / 2d
    lean1 = arm.b * np.sin(alpha / 2) / (2 * s.d)
    lean2 = arm.b * np.cos(alpha / 2) / (4 * s.d) - lean1 * s.d1 / s.d
    one, zero = np.ones_like(s.d), np.zeros_like(s.d)
    kinds = ((top, one, zero), (A, 0.5 + lean1, lean2), (B, 0.5 - lean1, -lean2))

    # acceleration and Jacobian of the bar middles, accumulated upwards
    bar_acceleration = [np.zeros(np.broadcast_shapes(s.d.shape[:-1], alpha_d.shape[:-1]), dtype=complex)]
    for i in range(n):
        bar_acceleration.append(bar_acceleration[-1] + _carried(middle, i, below, alpha_d, rate))
    centre, velocity_by, turning_by, acceleration, turning_acceleration = [], [], [], [], []
    for z, w1, w2 in kinds:
        for i in range(n):
            at = p.bar_middle[..., i] + below[..., i] * z[0][..., i]
            centre.append(at)
            # turning mechanism k < i carries everything above it: (middle of bar k-1 as origin) rigidly by dgamma, and by z' itself
            columns = [1j * (at - p.bar_middle[..., k + 1]) + below[..., k] * middle[1][..., k] for k in range(i)]
            columns.append(below[..., i] * z[1][..., i])
            columns += [np.zeros_like(at)] * (n - 1 - i)
            velocity_by.append(np.stack(columns, axis=-1))
            turning = [one[..., i]] * i + [w1[..., i]] + [zero[..., i]] * (n - 1 - i)
            turning_by.append(np.stack(turning, axis=-1))
            acceleration.append(bar_acceleration[i] + _carried(z, i, below, alpha_d, rate))
            turning_acceleration.append(w2[..., i] * alpha_d[..., i] ** 2)
    mass = np.concatenate([arm.top_mass, arm.diagonal_mass, arm.diagonal_mass], axis=-1)
    inertia = np.concatenate([arm.top_inertia, arm.diagonal_inertia, arm.diagonal_inertia], axis=-1)
    return _Bodies(
        mass,
        inertia,
        np.stack(centre, axis=-1),
        np.stack(velocity_by, axis=-2),
        np.stack(turning_by, axis=-2),
        np.stack(acceleration, axis=-1),
        np.stack(turning_acceleration, axis=-1),
    )


def _carried(z: tuple[Complex, Complex, Complex], i: int, below: Complex, alpha_d: Array, rate: Array) -> Complex:
    """Acceleration of a point z(alpha_i) of a bar's frame that turns at gamma'_(i-1), at alpha'' = 0, against the bar's middle."""
    a, w = alpha_d[..., i], rate[..., i]
    return below[..., i] * (z[2][..., i] * a**2 + 2j * w * z[1][..., i] * a - w**2 * z[0][..., i])


@dataclass(frozen=True)
class Terms:
    """The three terms of the equation of motion at one state or at many."""

    M: Array
    """shape (..., N, N), kg m^2"""
    c: Array
    """shape (..., N), N m"""
    g: Array
    """shape (..., N), N m"""


def terms(arm: Arm, alpha: Array, alpha_d: Array) -> Terms:
    """M, c and g together; alpha, alpha_d of shape (..., N), rad and rad/s."""
    k = _bodies(arm, alpha, alpha_d)
    J, W, m, I = k.velocity_by, k.turning_by, k.mass, k.inertia  # noqa: E741
    mJ = m[..., None] * J
    M = (np.swapaxes(J.conj(), -1, -2) @ mJ).real + np.swapaxes(W, -1, -2) @ (I[..., None] * W)
    c = np.sum((mJ.conj() * k.acceleration[..., None]).real + (I * k.turning_acceleration)[..., None] * W, axis=-2)
    weight = k.mass * (arm.gravity[..., :1] - 1j * arm.gravity[..., 1:])  # conj of the force m g on each body
    g = -np.sum((weight[..., None] * J).real, axis=-2)
    s = sides(arm, alpha)
    for length, slope in ((s.left, s.left1), (s.right, s.right1)):
        g = g + spring_force(arm, length) * slope
    return Terms(M, c, g)


def spring_force(arm: Arm, length: Array) -> Array:
    """Pull of a spring of side length `length`, shape (..., N), N; springs that may go slack do not push."""
    pull = arm.spring_stiffness * (length - arm.spring_free_length)
    return np.where(np.array(arm.spring_slack), np.maximum(pull, 0.0), pull)


def mass_matrix(arm: Arm, alpha: Array) -> Array:
    """M(alpha), shape (..., N, N), kg m^2."""
    return terms(arm, alpha, np.zeros_like(alpha)).M


def coriolis(arm: Arm, alpha: Array, alpha_d: Array) -> Array:
    """c(alpha, alpha'), shape (..., N), N m."""
    return terms(arm, alpha, alpha_d).c


def gravity_and_springs(arm: Arm, alpha: Array) -> Array:
    """g(alpha), shape (..., N), N m."""
    return terms(arm, alpha, np.zeros_like(alpha)).g


def potential_energy(arm: Arm, alpha: Array) -> Array:
    """Gravity and spring energy, shape (...), J, zero of gravity at the base bar."""
    k = _bodies(arm, alpha, np.zeros_like(alpha))
    height = -(arm.gravity[..., :1] * k.centre.real + arm.gravity[..., 1:] * k.centre.imag)
    s = sides(arm, alpha)
    stretch = np.stack([s.left, s.right]) - arm.spring_free_length
    stretch = np.where(np.array(arm.spring_slack), np.maximum(stretch, 0.0), stretch)
    return np.sum(k.mass * height, axis=-1) + np.sum(arm.spring_stiffness * stretch**2 / 2, axis=(0, -1))
