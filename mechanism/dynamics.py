"""M(alpha), c(alpha, alpha') and g(alpha) of M alpha'' + c + g = Z t (1), (44), for the arm without its motors.

Bodies are the bars 1..N and 2N diagonals. M sums m |dv|^2 + I domega^2 over them; c is the force that their acceleration at
alpha'' = 0 takes, which equals the Christoffel terms of M; g is the gradient of gravity and spring energy.
"""

from dataclasses import dataclass
from typing import Any

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
    kinds = ((top, np.ones_like(s.d), np.zeros_like(s.d)), (A, 0.5 + lean1, lean2), (B, 0.5 - lean1, -lean2))

    # axes from here on: kind of body (top bar, A, B), mechanism i, and for Jacobians the turning joint k
    z, z1, z2 = (np.stack([kind[0][order] for kind in kinds], axis=-2) for order in range(3))
    w1, w2 = (np.stack([kind[order] for kind in kinds], axis=-2) for order in (1, 2))
    foot, on, a, w = p.bar_middle[..., None, :-1], below[..., None, :], alpha_d, rate[..., :-1]
    centre = foot + on * z
    # joint k < i carries everything above: its bar moves by z', and what lies further turns about that bar's middle
    carried = 1j * (centre[..., None] - p.bar_middle[..., None, None, 1:]) + (below * middle[1])[..., None, None, :]
    above, own = np.tri(n, k=-1), np.eye(n)
    velocity_by = above * carried + own * (on * z1)[..., None]
    turning_by = above + own * w1[..., None]

    def felt(z: Complex, z1: Complex, z2: Complex, on: Complex, a: Array, w: Array) -> Complex:
        """Acceleration at alpha'' = 0 of a point z(alpha_i) of a bar that turns at w, against that bar's middle."""
        return on * (z2 * a**2 + 2j * w * z1 * a - w**2 * z)

    of_middles = np.cumsum(felt(*middle, below, a, w), axis=-1)
    below_them = np.concatenate([np.zeros_like(of_middles[..., :1]), of_middles[..., :-1]], axis=-1)
    a, w = a[..., None, :], w[..., None, :]
    acceleration = below_them[..., None, :] + felt(z, z1, z2, on, a, w)
    lead = np.broadcast_shapes(s.d.shape[:-1], alpha_d.shape[:-1])

    def flat(values: Any, axes: int) -> Any:
        """Kind and mechanism as one axis of bodies."""
        tail = values.shape[values.ndim - axes + 2 :]
        return np.broadcast_to(values, (*lead, 3, n, *tail)).reshape(*lead, 3 * n, *tail)

    return _Bodies(
        np.concatenate([arm.top_mass, arm.diagonal_mass, arm.diagonal_mass], axis=-1),
        np.concatenate([arm.top_inertia, arm.diagonal_inertia, arm.diagonal_inertia], axis=-1),
        flat(centre, 2),
        flat(velocity_by, 3),
        flat(turning_by, 3),
        flat(acceleration, 2),
        flat(w2 * a**2, 2),
    )


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
