"""The effects that a diagnosis is to name: what each changes in the world, at a place and of a size drawn at random."""

import copy
from dataclasses import replace
from typing import Any

import numpy as np

from samples.generator.hidden.kind import Draw, Hidden, Kind, numbered, rubbing, writing
from samples.generator.laws import capstan, cubic, damped, fading, toe, way, with_creep
from samples.generator.prescribed import World
from samples.generator.routes import wrap_table

_MOST_N = 160.0
"""tension up to which a hardening cable is solved"""


def cable_hardening(world: World, d: Draw) -> tuple[World, Hidden]:
    """All cables grow stiffer: with the cube of the elongation, or exponentially."""
    k = d.arm.k
    if d.rng.random() < 0.5:
        c = d.sized(1000, 3000, len(k))
        spring, parameters = cubic(k, k * c), numbered(k3=k * c)
    else:
        growth = d.sized(50, 120, len(k))
        spring, parameters = toe(k, growth), numbered(growth=growth)
    x = np.linspace(0, 1, 2000)[:, None] * _MOST_N / k
    pull = spring(x)
    steepest = np.max(np.diff(pull, axis=0) / np.diff(x, axis=0), axis=0, where=pull[1:] < _MOST_N, initial=0)
    return replace(world, stretch=damped(spring, 1.01 * steepest, d.arm.ca)), Hidden(
        "cable_hardening", "all", parameters
    )


def stribeck_friction(world: World, d: Draw) -> tuple[World, Hidden]:
    """More dry friction at low speed, which fades like a Lorentz curve."""
    fb, vs = d.sized(3, 6, 4), d.rng.uniform(5, 20)
    law = fading(fb, vs, d.arm.sharpness)
    return rubbing(world, law), Hidden("stribeck_friction", "all", numbered(fb=fb) | {"vs": float(vs)})


def viscous_friction(world: World, d: Draw) -> tuple[World, Hidden]:
    """In all motors."""
    fv = d.sized(0.02, 0.06, 4)
    return rubbing(world, lambda at: fv * at.theta_d), Hidden("viscous_friction", "all", numbered(fv=fv))


def pulley_friction(world: World, d: Draw) -> tuple[World, Hidden]:
    """All cables on their pulleys, after the capstan."""
    mu = d.sized(0.004, 0.012)
    law = capstan(float(mu), wrap_table(world.neck), d.arm.sharpness)
    return rubbing(world, law), Hidden("pulley_friction", "all", {"mu": float(mu)})


def base_tilt(world: World, d: Draw) -> tuple[World, Hidden]:
    """The base does not stand level."""
    tilt = d.sign() * float(np.radians(d.sized(2, 5)))
    return replace(world, load=replace(world.load, base_tilt_rad=tilt)), Hidden("base_tilt", "all", {"tilt": tilt})


def tip_payload(world: World, d: Draw) -> tuple[World, Hidden]:
    """A mass on the middle of the tip bar."""
    mass = float(d.sized(0.05, 0.15))
    where = f"bar {len(world.neck['mechanisms'])}"
    return replace(world, load=replace(world.load, payload_kg=mass)), Hidden("tip_payload", where, {"mass": mass})


def pulley_radius(world: World, d: Draw) -> tuple[World, Hidden]:
    """All pulleys of one mechanism are larger or smaller than described."""
    i, off = d.one(3), d.sign() * float(d.sized(0.5e-3, 1e-3))
    neck = copy.deepcopy(world.neck)
    neck["mechanisms"][i]["r"] += off
    return replace(world, neck=neck), Hidden("pulley_radius", f"mechanism {i + 1}", {"off": off})


def drum_radius(world: World, d: Draw) -> tuple[World, Hidden]:
    """One drum is larger or smaller than described; f stays the force on its cable."""
    return _other(world, d, "motors", "rd", "drum_radius", "motor", (0.03, 0.05))


def spring_stiffness(world: World, d: Draw) -> tuple[World, Hidden]:
    """Both springs of one mechanism."""
    return _other(world, d, "mechanisms", "stiffness", "spring_stiffness", "mechanism", (0.10, 0.25))


def _other(
    world: World, d: Draw, group: str, key: str, effect: str, place: str, share: tuple[float, float]
) -> tuple[World, Hidden]:
    """A dimension of one motor or mechanism that is off by a share of itself."""
    neck = copy.deepcopy(world.neck)
    i, factor = d.one(len(neck[group])), 1 + d.sign() * float(d.sized(*share))
    entry: dict[str, Any] = neck[group][i]
    (entry if key in entry else entry["springs"])[key] *= factor
    return replace(world, neck=neck), Hidden(effect, f"{place} {i + 1}", {"factor": factor})


def marker_offset(world: World, d: Draw) -> tuple[World, Hidden]:
    """The marker of one bar is turned: the joint below it shows too much, the one above too little."""
    i, off = d.one(3), d.sign() * float(np.radians(d.sized(2, 4)))
    shown = np.zeros(3)
    shown[i] += off
    shown[i + 1 : i + 2] -= off
    known = world.seen
    return replace(world, seen=lambda alpha: known(alpha) + shown), Hidden(
        "marker_offset", f"bar {i + 1}", {"offset": off}
    )


def joint_friction(world: World, d: Draw) -> tuple[World, Hidden]:
    """All joints rub, dry and viscous."""
    dry, viscous, sharpness = d.sized(0.01, 0.03), d.sized(0.005, 0.02), d.rng.uniform(10, 30)
    parameters = {"dry": float(dry), "viscous": float(viscous), "sharpness": float(sharpness)}
    return replace(world, joint_friction=lambda speed: dry * way(speed, sharpness) + viscous * speed), Hidden(
        "joint_friction", "all", parameters
    )


def actuator_gain(world: World, d: Draw) -> tuple[World, Hidden]:
    """One motor gives less or more than the log says."""
    j, gain = d.one(4), 1 + d.sign() * float(d.sized(0.05, 0.12))
    factor = np.where(np.arange(4) == j, gain, 1.0)
    return writing(world, lambda f: factor * f), Hidden("actuator_gain", f"motor {j + 1}", {"written_over_true": gain})


def actuator_offset(world: World, d: Draw) -> tuple[World, Hidden]:
    """One motor gives some newtons less or more than the log says."""
    j, off = d.one(4), d.sign() * float(d.sized(2, 5))
    shift = np.where(np.arange(4) == j, off, 0.0)
    return writing(world, lambda f: f + shift), Hidden("actuator_offset", f"motor {j + 1}", {"written_less_true": off})


def actuator_lag(world: World, d: Draw) -> tuple[World, Hidden]:
    """All forces follow their commands as a first-order lag, tau f' + f = command."""
    tau, known = float(d.sized(8e-3, 20e-3)), world.written
    return replace(
        world, written=lambda force, step: known(force + tau * np.gradient(force, step, axis=0), step)
    ), Hidden("actuator_lag", "all", {"tau": tau})


def cable_creep(world: World, d: Draw) -> tuple[World, Hidden]:
    """All cables give way slowly, besides at once."""
    share, tau = d.sized(0.25, 0.5), d.rng.uniform(2, 6)
    stretch = with_creep(world.stretch, share / d.arm.k, float(tau))
    return replace(world, stretch=stretch), Hidden("cable_creep", "all", {"share": float(share), "tau": float(tau)})


CATALOGUE: dict[str, Kind] = {
    kind.__name__: kind
    for kind in (
        cable_hardening,
        cable_creep,
        stribeck_friction,
        viscous_friction,
        pulley_friction,
        joint_friction,
        base_tilt,
        tip_payload,
        pulley_radius,
        drum_radius,
        spring_stiffness,
        marker_offset,
        actuator_lag,
        actuator_gain,
        actuator_offset,
    )
}
"""by name, in the order in which several are laid on one another: what replaces a law before what adds to it"""
