"""M(alpha), c(alpha, alpha') and g(alpha) of M alpha'' + c + g = Z t (1), (44), for the arm without its motors.

Joint i turns all that stands on bar i as one, and folds its own two diagonals. M sums m |dv|^2 + I domega^2 over the bodies,
composite by composite (Walker and Orin 1982); c is the force that their acceleration at alpha'' = 0 takes, which equals the
Christoffel terms of M; g is the gradient of gravity and spring energy.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from mechanism.arm import Arm, Array
from mechanism.batch_layout import arm_batch_last, batch_shape, from_batch_last, to_batch_last
from mechanism.geometry import Complex, poses, sides
from mechanism.running_sums import running_sums

MAX_BATCH_OF_TERMS = 1 << 12
"""states that are computed at once: what they need stays in a cache, and memory does not grow with their number"""


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
    shape = np.broadcast_shapes(np.shape(alpha)[:-1], np.shape(alpha_d)[:-1], batch_shape(arm, {}))
    count, n = int(np.prod(shape)), arm.N
    M, c, g = np.empty((n, n, count)), np.empty((n, count)), np.empty((n, count))
    for begin in range(0, count, MAX_BATCH_OF_TERMS):
        part = slice(begin, min(begin + MAX_BATCH_OF_TERMS, count))
        k = terms_batch_last(
            arm_batch_last(arm, shape, part), to_batch_last(alpha, shape, part), to_batch_last(alpha_d, shape, part)
        )
        M[..., part], c[..., part], g[..., part] = k.M, k.c, k.g
    return Terms(from_batch_last(M, shape), from_batch_last(c, shape), from_batch_last(g, shape))


def terms_batch_last(arm: Arm, alpha: Array, alpha_d: Array) -> Terms:
    """M (N, N, B), c and g (N, B) of an arm in batch layout; alpha, alpha_d (N, B), rad and rad/s."""
    n, s, v, m, top = arm.N, sides(arm, alpha), alpha_d, arm.diagonal_mass, arm.top_mass
    d, h, h1 = s.d, s.right - s.d, s.right1 - s.d1
    gamma, rate = running_sums(alpha), running_sums(v)
    # everything as complex numbers of the base frame; axis 0: mechanism i with bar i on its top
    line = 1j * _unit(gamma - alpha / 2)
    step = line * d
    middle = running_sums(step)
    foot = middle - step
    u = line * (s.d1 + 0.5j * d)  # velocity of bar i's middle by alpha_i'
    q = u - 1j * middle  # a point p of what stands on bar i goes by q + jp
    com = (arm.top_com[..., 0] + 1j * arm.top_com[..., 1]) * _unit(gamma)
    at = middle + com
    folded = m * (d**2 + h**2) / 2  # second moment of both diagonals' masses about the bottom bar's middle
    lean1 = arm.b * np.sin(alpha / 2) / (2 * d)  # diagonals turn by 1/2 +- lean1
    lean2 = arm.b * np.cos(alpha / 2) / (4 * d) - lean1 * s.d1 / d

    def carried(of_top: Any, of_pair: Any) -> Any:
        """Sum over all that bar i carries: the tops from bar i up, the pairs of diagonals above it."""
        return running_sums((of_top + of_pair)[::-1])[::-1] - of_pair

    mass = carried(top + 0 * d, 2 * m + 0 * d)
    first = carried(top * at, m * (foot + middle))
    second = carried(
        top * _square(at) + arm.top_inertia,
        m * (_square(foot) + _square(middle) - _square(step)) + folded + 2 * arm.diagonal_inertia,
    )
    momentum = 1j * first + mass * q + m * u
    across = _cross(first, q)
    spin = across + second + _cross(foot, m * u) + folded / 2 + arm.diagonal_inertia
    fold = m * (s.d1**2 + h1**2 + (d**2 + h**2) / 4) / 2 + arm.diagonal_inertia * (0.5 + 2 * lean1**2)
    M = np.empty_like(d, shape=(n, n, *np.broadcast_shapes(d.shape, mass.shape)[1:]))
    for i in range(n):
        M[:i, i] = M[i, :i] = spin[i] + _dot(q[:i], momentum[i])
        M[i, i] = (mass * _square(q) + 2 * across + second + fold)[i]

    w = rate - v / 2  # how fast the middle line turns
    relative = line * (s.d2 * v**2 - d * w**2 + 2j * s.d1 * v * w)
    of_middle = running_sums(relative)
    of_foot = of_middle - relative
    force, pair = top * (of_middle - rate**2 * com), m * (of_foot + of_middle)
    folding = v * w * (d * s.d1 + h * h1)
    moment = carried(_cross(at, force), _cross(foot, pair) + m * (_cross(step, of_foot) + folding))
    unfolding = s.d1 * (s.d2 * v**2 - d * w**2) + h1 * ((s.right2 - s.d2) * v**2 - h * w**2) + folding
    c = _dot(q, carried(force, pair)) + moment + m * (_dot(u, of_foot) + unfolding / 2)
    c = c + 2 * arm.diagonal_inertia * lean1 * lean2 * v**2

    g = -_dot(arm.gravity[..., 0] + 1j * arm.gravity[..., 1], momentum)
    for side, (length, slope) in enumerate(((s.left, s.left1), (s.right, s.right1))):
        g = g + spring_force(arm, side, length) * slope
    return Terms(M, c, g)


def _unit(angle: Array) -> Complex:
    out = np.empty_like(angle, dtype=complex)
    out.real, out.imag = np.cos(angle), np.sin(angle)
    return out


def _square(a: Complex) -> Array:
    return a.real**2 + a.imag**2


def _dot(a: Complex, b: Complex) -> Array:
    return a.real * b.real + a.imag * b.imag


def _cross(a: Complex, b: Complex) -> Array:
    return a.real * b.imag - a.imag * b.real


def spring_force(arm: Arm, side: int, length: Array) -> Array:
    """Pull of the springs on a side (0: left, 1: right) of length `length`, (N, B), N; those that may go slack do not push.

    The arm is in batch layout.
    """
    pull = arm.spring_stiffness[side] * (length - arm.spring_free_length[side])
    if not any(arm.spring_slack):
        return pull
    return np.where(np.array(arm.spring_slack)[:, None], np.maximum(pull, 0.0), pull)


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
    p, s = poses(arm, alpha), sides(arm, alpha)
    com = arm.top_com[..., 0] + 1j * arm.top_com[..., 1]
    tops = p.bar_middle[..., 1:] + com * np.exp(1j * p.bar_angle[..., 1:])
    moment = arm.top_mass * tops + arm.diagonal_mass * p.diagonal_middle.sum(axis=-1)
    height = -(arm.gravity[..., :1] * moment.real + arm.gravity[..., 1:] * moment.imag)
    stretch = np.stack([s.left, s.right], axis=-2) - arm.spring_free_length
    stretch = np.where(np.array(arm.spring_slack), np.maximum(stretch, 0.0), stretch)
    return np.sum(height, axis=-1) + np.sum(arm.spring_stiffness * stretch**2 / 2, axis=(-2, -1))
