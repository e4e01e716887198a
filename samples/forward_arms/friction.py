"""Dry friction of the motors: bristles that bend over a small angle, or a curve over speed."""

from dataclasses import dataclass

import numpy as np

from samples.forward_arms.plant import Array, Plant

ARCTANGENT = 0.5
"""s/rad, the seed's"""
TAIL = 2 / (np.pi * ARCTANGENT)
"""rad/s: speed / (|speed| + TAIL) comes up to 1 as the arctangent does, and turns over more sharply"""
MICRO = 5e-4
"""s, what damps the bristles, over what bends them"""


def turning(speed: Array) -> Array:
    """The arctangent's share of the whole friction, -1..1, at motor speed (rad/s)."""
    return 2 / np.pi * np.arctan(ARCTANGENT * speed)


@dataclass(frozen=True)
class Friction:
    """Force and bend's rate, each (M, B), with their slopes."""

    force: Array
    force_by_speed: Array
    force_by_bend: Array
    bend_d: Array
    bend_d_by_speed: Array
    bend_d_by_bend: Array


def friction(plant: Plant, speed: Array, bend: Array) -> Friction:
    """At motor speed (rad/s) and bend (of its greatest, -1..1); with viscous friction."""
    share, sliding, grip = plant.hyperbola, plant.slides, plant.grip
    turn = ARCTANGENT * speed
    fast = np.abs(speed)
    over_speed = (1 - share) * turning(speed) + share * speed / (fast + TAIL)
    steep = (1 - share) * 2 / np.pi * ARCTANGENT / (1 + turn**2) + share * TAIL / (fast + TAIL) ** 2
    if plant.slides_everywhere:
        still = np.zeros_like(speed)
        return Friction(
            force=plant.dry * over_speed + plant.viscous * speed,
            force_by_speed=plant.dry * steep + plant.viscous,
            force_by_bend=still,
            bend_d=still,
            bend_d_by_speed=still,
            bend_d_by_bend=still,
        )
    bend_d = grip * (speed - fast * bend)
    by_speed = grip * (1 - np.sign(speed) * bend)
    curve = np.where(sliding, over_speed, bend + MICRO * bend_d)
    slope = np.where(sliding, steep, MICRO * by_speed)
    return Friction(
        force=plant.dry * curve + plant.viscous * speed,
        force_by_speed=plant.dry * slope + plant.viscous,
        force_by_bend=np.where(sliding, 0.0, plant.dry * (1 - MICRO * grip * fast)),
        bend_d=bend_d,
        bend_d_by_speed=by_speed,
        bend_d_by_bend=-grip * fast,
    )
