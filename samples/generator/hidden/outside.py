"""What no catalogue of causes holds: a diagnosis is to say that it does not know."""

from dataclasses import replace
from typing import Any

import numpy as np

from samples.generator.hidden.kind import Draw, Hidden, Kind, numbered, rubbing
from samples.generator.laws import Running
from samples.generator.linkage import solve
from samples.generator.prescribed import World
from samples.generator.taut_string import Array

_TURN = 1e-4
"""rad, of the central differences"""


def warming_friction(world: World, d: Draw) -> tuple[World, Hidden]:
    """Dry friction of all motors falls or rises as they warm up; each recording starts cold."""
    change, tau = d.sign() * float(d.sized(0.15, 0.25)), d.rng.uniform(0.3, 0.6) * d.longest
    cold = world.friction

    def warmed(at: Running) -> Array:
        return change * (-np.expm1(-at.time / tau))[:, None] * cold(at)

    return rubbing(world, warmed), Hidden("warming_friction", "all", {"change": change, "tau": float(tau)})


def cogging(world: World, d: Draw) -> tuple[World, Hidden]:
    """Teeth: a force that goes round with each drum, a whole number of times a turn.

    A motor turns 100 rad/s at usual speeds: once in a turn of the motor is 16 Hz, once in one of the drum 0.6 Hz.
    """
    force, phase = d.sized(1.5, 3, 4), d.rng.uniform(0, 2 * np.pi, 4)
    teeth = d.rng.integers(3, 10, 4).astype(float)
    per_rad = teeth / np.array([motor["R"] for motor in world.neck["motors"]])
    return rubbing(world, lambda at: force * np.sin(per_rad * at.theta + phase)), Hidden(
        "cogging", "all", numbered(force=force, teeth=teeth, phase=phase)
    )


def outside_force(world: World, d: Draw) -> tuple[World, Hidden]:
    """Somebody pushes the tip bar sideways now and then."""
    count = int(d.own.integers(6, 13)) if d.seconds > 30 else 3
    # one push in each of equal parts of the recording, none at rest
    part = (d.seconds - 2) / count
    long = np.minimum(d.own.uniform(0.5, 1.5, count), part)
    start = 1.5 + part * np.arange(count) + d.own.uniform(0, part - long)
    force = d.size * d.own.choice([-1.0, 1.0], count) * d.own.uniform(0.5, 2.0, count)
    neck = world.neck

    def push(time: Array, alpha: Array) -> Array:
        u = np.clip((time[:, None] - start) / long, 0, 1)
        pushing = np.sin(np.pi * u) ** 2 @ force
        return pushing[:, None] * _tip_moved(neck, alpha)

    return replace(world, push=push), Hidden("outside_force", f"bar {len(neck['mechanisms'])}", {"most": 2.0 * d.size})


def _tip_moved(neck: dict[str, Any], alpha: Array) -> Array:
    """How far to the right the tip bar's middle goes per turn of each joint, (T, N), m/rad."""
    mechanisms = neck["mechanisms"]
    L, b = (np.array([m[key] for m in mechanisms]) for key in ("L", "b"))
    moved = [
        [solve(alpha + sign * _TURN * turn, L, b).middle[:, -1].real for sign in (1, -1)]
        for turn in np.eye(alpha.shape[1])
    ]
    return np.stack([(up - down) / (2 * _TURN) for up, down in moved], axis=-1)


OUTSIDE: dict[str, Kind] = {kind.__name__: kind for kind in (warming_friction, cogging, outside_force)}
