"""Slopes of a machine's laws by what they depend on, by differences: each law acts on its own cable, motor or joint."""

from dataclasses import dataclass

import numpy as np

from mechanism.arm import Array
from mechanism.laws import Stretching, Turning
from mechanism.machine import Machine

SMALL_M, SMALL_M_S, SMALL_RAD_S, SMALL_N, SMALL = 1e-7, 1e-6, 1e-5, 1e-4, 1e-6
"""differences: far below what laws change on, far above rounding"""


@dataclass(frozen=True)
class Slopes:
    """Each (M, lanes), `resist_by_speed` (N, lanes), those by or of memory (M, lanes, states); pull is the tension's."""

    pull_by_x: Array
    pull_by_x_d: Array
    pull_by_memory: Array
    rub_by_speed: Array
    rub_by_tension: Array
    resist_by_speed: Array
    drift_by_x: Array
    drift_by_x_d: Array
    drift_by_memory: Array


def slopes(machine: Machine, at: Stretching, z: Array, theta_d: Array, wrap: Array, alpha_d: Array) -> Slopes:
    """At a state in lanes. A slack cable has no slope; memories of one cable do not drive each other."""

    def pull(x: Array, x_d: Array, z: Array) -> Array:
        return machine.pull(Stretching(x, x_d, at.length, at.arm, at.travel_d), z)

    def drift(x: Array, x_d: Array, z: Array) -> Array:
        return machine.drift(Stretching(x, x_d, at.length, at.arm, at.travel_d), z)

    def rub(theta_d: Array, t: Array) -> Array:
        return machine.friction(Turning(theta_d, t, wrap))

    x, x_d = at.x, at.x_d
    now = pull(x, x_d, z)
    taut = now > 0
    t = now * taut
    rubbing = rub(theta_d, t)
    by_memory = by_itself = drift_by_x = drift_by_x_d = np.zeros(z.shape)
    if machine.states:
        each = [taut * (pull(x, x_d, z + SMALL * one) - now) / SMALL for one in np.eye(machine.states)]
        going = drift(x, x_d, z)
        by_memory, by_itself = np.stack(each, axis=-1), (drift(x, x_d, z + SMALL) - going) / SMALL
        drift_by_x = (drift(x + SMALL_M, x_d, z) - going) / SMALL_M
        drift_by_x_d = (drift(x, x_d + SMALL_M_S, z) - going) / SMALL_M_S
    return Slopes(
        pull_by_x=taut * (pull(x + SMALL_M, x_d, z) - now) / SMALL_M,
        pull_by_x_d=taut * (pull(x, x_d + SMALL_M_S, z) - now) / SMALL_M_S,
        pull_by_memory=by_memory,
        rub_by_speed=(rub(theta_d + SMALL_RAD_S, t) - rubbing) / SMALL_RAD_S,
        rub_by_tension=(rub(theta_d, t + SMALL_N) - rubbing) / SMALL_N,
        resist_by_speed=np.broadcast_to(
            (machine.resistance(alpha_d + SMALL) - machine.resistance(alpha_d)) / SMALL, alpha_d.shape
        ),
        drift_by_x=drift_by_x,
        drift_by_x_d=drift_by_x_d,
        drift_by_memory=by_itself,
    )
