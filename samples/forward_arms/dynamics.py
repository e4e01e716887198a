"""Mass matrix, and the torque that keeps alpha'' = 0, from points and unit vectors of the bars (natural coordinates).

Bars' middles p_k and unit vectors u_k make the kinetic energy a sum of squares with constant weights: of the bars' centres
p_k + com u_k, of the diagonals' common centre (p_(k-1) + p_k)/2 and their distance from it b (u_k - u_(k-1))/4, and of half the
sum and half the difference of both diagonals, p_k - p_(k-1) and b (u_k + u_(k-1))/2, whose rates are those of their turning.
With constant weights there are no Christoffel symbols: torque is J^T times weight times acceleration.
"""

from dataclasses import dataclass

import numpy as np

from samples.forward_arms.joints import Fold, Place
from samples.forward_arms.plant import Array, Complex, Plant


@dataclass(frozen=True)
class Equations:
    """mass alpha'' + rest = what cables and laws do to the joints."""

    mass: Array
    """(N, N, B), kg m^2"""
    rest: Array
    """(N, B), N m: inertia at alpha'' = 0, gravity, springs"""


def equations(plant: Plant, fold: Fold, place: Place, alpha_d: Array) -> Equations:
    """Of the pose `fold`, `place` at alpha_d (N, B), rad/s."""
    n, count = alpha_d.shape
    rows = _jacobians(plant, fold, place)
    rows *= plant.weights_of_those_above
    flat = rows.reshape(n, 5 * n, count)
    J = np.concatenate([flat.real, flat.imag], axis=1)
    mass = np.einsum("irb,jrb->ijb", J, J)
    mass += plant.turning
    pushed = _accelerations(plant, fold, place, alpha_d)
    pushed *= plant.root_weights
    thrust = pushed.reshape(5 * n, count)
    rest = np.einsum("irb,rb->ib", J, np.concatenate([thrust.real, thrust.imag]))
    rest += plant.spring_left * (fold.left - plant.free_left) * fold.left1
    rest += plant.spring_right * (fold.right - plant.free_right) * fold.right1
    return Equations(mass, rest)


def _jacobians(plant: Plant, fold: Fold, place: Place) -> Complex:
    """(N, 5, N, B): of joint, row and mechanism; of a mechanism below the joint what stands there means nothing."""
    n, count = fold.mean.shape
    p, u = place.middle, place.along
    own = place.up * (fold.mean1 + 0.5j * fold.mean)  # of p_j by alpha_j
    centre = (p[1:] + p[:-1]) / 2
    bar = p[1:] + plant.bar_com * u[1:]
    step = 1j * fold.mean * place.up
    fourth, half = 0.25j * plant.b, 0.5j * plant.b
    apart, together = fourth * (u[1:] - u[:-1]), half * (u[1:] + u[:-1])
    rows = np.empty((n, 5, n, count), dtype=complex)
    all_above = (own - 1j * p[1:])[:, None]  # a point q above goes by this + iq
    np.add(all_above, 1j * bar, out=rows[:, 0])
    np.add(all_above, 1j * centre, out=rows[:, 1])
    rows[:, 2], rows[:, 3], rows[:, 4] = apart, step, together
    of_own = np.einsum("jrjb->rjb", rows)  # a view
    of_own[1], of_own[3] = own / 2, own
    of_own[2], of_own[4] = fourth * u[1:], half * u[1:]
    return rows


def _accelerations(plant: Plant, fold: Fold, place: Place, alpha_d: Array) -> Complex:
    """(5, N, B): of the rows at alpha'' = 0, less gravity where there is weight."""
    n, count = alpha_d.shape
    turn = np.zeros((n + 1, count))
    for k in range(n):
        np.add(turn[k], alpha_d[k], out=turn[k + 1])
    side_turn = turn[:-1] + alpha_d / 2
    # (mean^2)'' = b^2 cos(alpha) / 2, from Ptolemy
    cosine = fold.half.real**2 - fold.half.imag**2
    mean2 = (plant.b**2 * cosine / 4 - fold.mean1**2) / fold.mean
    inward = mean2 * alpha_d**2 - fold.mean * side_turn**2
    step = place.up * (inward + 2j * fold.mean1 * alpha_d * side_turn)
    p = np.empty((n + 1, count), dtype=complex)
    p[0] = -plant.gravity[0]
    for k in range(n):
        np.add(p[k], step[k], out=p[k + 1])
    u = -(turn**2) * place.along
    out = np.empty((5, n, count), dtype=complex)
    out[0] = p[1:] + plant.bar_com * u[1:]
    out[1] = (p[1:] + p[:-1]) / 2
    out[2] = plant.b / 4 * (u[1:] - u[:-1])
    out[3] = step
    out[4] = plant.b / 2 * (u[1:] + u[:-1])
    return out
