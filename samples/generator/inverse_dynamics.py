"""The joint torques of a motion that is given: every body's place in time, differentiated, and the work of a small turn.

By d'Alembert: tau_i = sum over bodies of m (p'' - g) . dp/dalpha_i + I omega' domega/dalpha_i' + dV_springs/dalpha_i. Places
come from circles that intersect; no mass matrix and no Coriolis term is written down, so that those can be held against this.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from samples.generator.linkage import solve
from samples.generator.mujoco_arm import Load
from samples.generator.statics import spring_energy
from samples.generator.taut_string import Array, Complex

_TURN = 1e-4
"""rad, of the central differences"""


def joint_torque(neck: dict[str, Any], alpha: Array, step: float, load: Load) -> Array:
    """Torques, shape (T, N), N m, that move the arm along alpha, shape (T, N), rad, sampled every `step` s.

    The arm must be at rest for the first and the last three samples.
    """
    place, turn = _bodies(neck, alpha)
    mass, inertia = _inertias(neck)
    gravity = complex(*neck.get("gravity", [0.0, -9.81])) * np.exp(-1j * load.base_tilt_rad)
    force = mass * (_second(place, step) - gravity)
    couple = inertia * _second(turn, step)
    tip = solve(alpha, *_sizes(neck)).middle[:, -1]
    load_force = load.payload_kg * (_second(tip, step) - gravity)
    out = np.empty(alpha.shape)
    for i in range(alpha.shape[1]):
        up, down = (alpha + sign * _TURN * np.eye(alpha.shape[1])[i] for sign in (1, -1))
        (p1, a1), (p0, a0) = _bodies(neck, up), _bodies(neck, down)
        tips = [solve(a, *_sizes(neck)).middle[:, -1] for a in (up, down)]
        work = np.sum((force.conj() * (p1 - p0)).real + couple * (a1 - a0), axis=-1)
        work += (load_force.conj() * (tips[0] - tips[1])).real
        work += load.spring_factor * (spring_energy(neck, up) - spring_energy(neck, down))
        out[:, i] = work / (2 * _TURN)
    return out


def _sizes(neck: dict[str, Any]) -> tuple[Array, Array]:
    return np.array([m["L"] for m in neck["mechanisms"]]), np.array([m["b"] for m in neck["mechanisms"]])


def _inertias(neck: dict[str, Any]) -> tuple[Array, Array]:
    """Masses and inertias of the top bars, then of the diagonals A, then B."""
    tops, rods = ([m[part] for m in neck["mechanisms"]] for part in ("top", "diagonal"))
    return (
        np.array([part["mass"] for part in (*tops, *rods, *rods)]),
        np.array([part["inertia"] for part in (*tops, *rods, *rods)]),
    )


def _bodies(neck: dict[str, Any], alpha: Array) -> tuple[Complex, Array]:
    """Places (m) and directions (rad) of the bodies, shape (T, 3 N), in the order of `_inertias`."""
    bars = solve(alpha, *_sizes(neck))
    com = np.array([complex(*m["top"].get("com", [0.0, 0.0])) for m in neck["mechanisms"]])
    along = np.exp(1j * bars.orientation)
    half = _sizes(neck)[1] / 2
    below, above = half * along[:, :-1], half * along[:, 1:]
    low, high = bars.middle[:, :-1], bars.middle[:, 1:]
    a, b = (low - below, high + above), (low + below, high - above)
    places = [high + com * along[:, 1:], (a[0] + a[1]) / 2, (b[0] + b[1]) / 2]
    turns = [bars.orientation[:, 1:], np.angle(a[1] - a[0]), np.angle(b[1] - b[0])]
    return np.hstack(places), np.hstack(turns)


def _second(values: NDArray[Any], step: float) -> NDArray[Any]:
    """Second derivative in time along the first axis, sixth order; zero where the arm rests at both ends."""
    weights = np.array([2, -27, 270, -490, 270, -27, 2]) / 180 / step**2
    out = np.zeros_like(values)
    inner = slice(3, len(values) - 3)
    out[inner] = sum(w * values[k : len(values) - 6 + k] for k, w in enumerate(weights))
    return out
