"""The forces that hold the described arm still: potential energy from the bars' places, and tensions to match."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from samples.generator.linkage import solve
from samples.generator.routes import piece
from samples.generator.taut_string import Array


def potential_energy(neck: dict[str, Any], alpha: Array) -> Array:
    """Gravity and springs of the arm as neck.yaml describes it, shape (...), J; alpha of shape (..., N), rad."""
    m = neck["mechanisms"]
    b = np.array([x["b"] for x in m])
    bars = solve(alpha, np.array([x["L"] for x in m]), b)
    along = np.exp(1j * bars.orientation)
    toward = complex(*neck["gravity"])
    energy = np.zeros(np.shape(alpha)[:-1])
    for i, x in enumerate(m):
        below, above = b[i] / 2 * along[..., i], b[i] / 2 * along[..., i + 1]
        low, high = bars.middle[..., i], bars.middle[..., i + 1]
        places = [(x["top"]["mass"], high + complex(*x["top"]["com"]) * along[..., i + 1])]
        places += [(x["diagonal"]["mass"], (low - below + high + above) / 2)]
        places += [(x["diagonal"]["mass"], (low + below + high - above) / 2)]
        for mass, place in places:
            energy = energy - mass * (place * np.conj(toward)).real
    return energy + spring_energy(neck, alpha)


def spring_energy(neck: dict[str, Any], alpha: Array) -> Array:
    """Of the springs on both sides of all mechanisms, shape (...), J; alpha of shape (..., N), rad."""
    m = neck["mechanisms"]
    b = np.array([x["b"] for x in m])
    bars = solve(alpha, np.array([x["L"] for x in m]), b)
    half = np.exp(1j * bars.orientation)
    energy = np.zeros(np.shape(alpha)[:-1])
    for i, x in enumerate(m):
        for side in (-b[i] / 2, b[i] / 2):
            ends = [bars.middle[..., k] + side * half[..., k] for k in (i, i + 1)]
            stretch = np.abs(ends[1] - ends[0]) - x["springs"]["free_length"]
            if x["springs"].get("slack", False):
                stretch = np.maximum(stretch, 0.0)
            energy = energy + x["springs"]["stiffness"] * stretch**2 / 2
    return energy


def holding_torque(neck: dict[str, Any], alpha: Array, step: float = 1e-4) -> Array:
    """dV/dalpha, shape (..., N), N m: the joint torques that hold the arm at alpha (central differences)."""
    n = alpha.shape[-1]
    moved = alpha[..., None, None, :] + step * np.array([1.0, -1.0])[:, None, None] * np.eye(n)
    energy = potential_energy(neck, moved)
    return (energy[..., 0, :] - energy[..., 1, :]) / (2 * step)


def pull_matrix(neck: dict[str, Any], alpha: Array) -> Array:
    """Joint torque per cable tension, -dl_j/dalpha_i, shape (..., N, M), m."""
    m = neck["mechanisms"]
    out = np.zeros((*alpha.shape, len(neck["cables"])))
    for j, cable in enumerate(neck["cables"]):
        for i, word in enumerate(cable["route"]):
            out[..., i, j] = -piece(word, alpha[..., i], m[i]["L"], m[i]["b"], m[i]["r"]).slope
    return out


@dataclass(frozen=True)
class Holding:
    """Tensions that hold the arm, shape (..., M), N, and the joint torques they make, shape (..., N), N m."""

    tension: Array
    torque: Array


def hold(neck: dict[str, Any], alpha: Array, level: Array) -> Holding:
    """Tensions nearest to `level`, shape (..., M), N, that hold the described arm at alpha, shape (..., N), rad."""
    Z = pull_matrix(neck, alpha)
    torque = holding_torque(neck, alpha)
    missing = torque - np.einsum("...nm,...m->...n", Z, level)
    return Holding(level + np.einsum("...mn,...n->...m", np.linalg.pinv(Z), missing), torque)
