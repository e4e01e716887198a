"""The effects that a diagnosis is to name: what each changes in the world, at a place and of a size drawn at random."""

import copy
from dataclasses import replace
from typing import Any

import numpy as np

from samples.generator.hidden.kind import Draw, Hidden, Kind, numbered, rubbing, writing
from samples.generator.hidden.slack import slackening
from samples.generator.laws import ahead, bending, capstan, cubic, damped, fading, maxwell_slip, toe, way, with_creep
from samples.generator.prescribed import World
from samples.generator.routes import wrap_table
from samples.generator.taut_string import Array

_MOST_N = 160.0
"""tension up to which a hardening cable is solved"""
_CROSSING_N = 15.0
_PEAK = 5.77
"""largest acceleration of u^3 (10 - 15 u + 6 u^2)"""
_STILL_RAD = 1e-9
"""a step of the motor that is rounding only"""


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


def presliding_friction(world: World, d: Draw) -> tuple[World, Hidden]:
    """Dry friction of all motors bends before it slides: three elements, of which each holds a third, after another angle."""
    force, angle = d.sized(6, 10, 4), d.rng.uniform([[0.01], [0.04], [0.1]], [[0.03], [0.08], [0.2]])
    bends = bending(force, angle, d.arm.sharpness)
    return rubbing(world, bends), Hidden("presliding_friction", "all", numbered(force=force))


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


def motor_inertia(world: World, d: Draw) -> tuple[World, Hidden]:
    """What turns with one motor's shaft is heavier or lighter than described."""
    return _other(world, d, "motors", "Ia", "motor_inertia", "motor", (0.6, 0.9))


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


def cable_hysteresis(world: World, d: Draw) -> tuple[World, Hidden]:
    """The fibres of all cables stick and slip: three elements, of which each slips at a third of the force."""
    force, travel = d.sized(2, 5, 4), d.rng.uniform([[0.3e-3], [0.8e-3], [1.5e-3]], [[0.6e-3], [1.2e-3], [2.5e-3]])
    travel = np.repeat(travel, 4, axis=1)
    stretch = maxwell_slip(d.arm.k, d.arm.ca, force / 3 / travel, travel)
    return replace(world, stretch=stretch), Hidden("cable_hysteresis", "all", numbered(force=force))


def cable_slack(world: World, d: Draw) -> tuple[World, Hidden]:
    """One cable goes slack for moments; never the last one, which pulls against all others and keeps most."""
    j, depth = d.one(3), float(d.sized(0.5e-3, 2e-3))
    parameters = {"depth": depth}
    law = slackening(j, depth, min(d.size, 1.0), d.own)
    hanging = replace(world, slack=law) if d.size else world  # moments without slack need not be found
    return hanging, Hidden("cable_slack", f"cable {j + 1}", parameters)


def backlash(world: World, d: Draw) -> tuple[World, Hidden]:
    """One drum lags its motor by half a play; a motor that turns round crosses it as fast as 15 N accelerate its rotor."""
    j, width = d.one(4), float(d.sized(0.5e-3, 1.5e-3))
    motor = world.neck["motors"][j]
    drum = motor["rd"] / motor["R"]
    crossing = float(np.sqrt(_PEAK * width * motor["Ia"] / drum**2 / _CROSSING_N))
    known = world.gear

    def gear(drums: Array, step: float) -> Array:
        theta = known(drums, step)
        theta[:, j] += width / 2 / drum * _side(theta[:, j], max(1, round(crossing / step)))
        return theta

    parameters = {"play": width, "crossing_s": crossing}
    return replace(world, gear=gear), Hidden("backlash", f"motor {j + 1}", parameters)


def _side(theta: Array, rows: int) -> Array:
    """The flank that drives, -1 or 1, with its smooth change over so many rows after each turn, (T,)."""
    steps = np.diff(theta, prepend=theta[0])
    known = np.abs(steps) > _STILL_RAD
    last = np.maximum.accumulate(np.where(known, np.arange(len(steps)), np.argmax(known)))
    u = (np.arange(rows) + 0.5) / rows
    kernel = u**2 * (1 - u) ** 2
    way_of = np.sign(steps[last])
    padded = np.concatenate([np.full(rows - 1, way_of[0]), way_of])
    return np.convolve(padded, kernel / kernel.sum(), mode="valid")


def clock_offset(world: World, d: Draw) -> tuple[World, Hidden]:
    """The log holds the motors' angles of some milliseconds before."""
    late, known = float(d.sized(4e-3, 8e-3)), world.encoder
    return replace(world, encoder=lambda theta, step: ahead(known(theta, step), step, -late)), Hidden(
        "clock_offset", "all", {"late_s": late}
    )


CATALOGUE: dict[str, Kind] = {
    kind.__name__: kind
    for kind in (
        cable_hardening,
        cable_hysteresis,
        cable_creep,
        cable_slack,
        stribeck_friction,
        presliding_friction,
        viscous_friction,
        pulley_friction,
        joint_friction,
        base_tilt,
        tip_payload,
        pulley_radius,
        drum_radius,
        motor_inertia,
        spring_stiffness,
        marker_offset,
        backlash,
        clock_offset,
        actuator_lag,
        actuator_gain,
        actuator_offset,
    )
}
"""by name, in the order in which several are laid on one another: what replaces a law before what adds to it"""
