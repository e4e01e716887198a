"""Laws of motors, cables and joints as elements of MuJoCo; which of them have none, and why.

Every law is either written or refused by its name: a model that leaves one out in silence would be another arm.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal
from xml.etree.ElementTree import Element

import numpy as np

from mechanism.arm import Array
from mechanism.laws import CableMotion, JointMotion, MotorMotion, law_named
from mechanism.laws.unlisted import UnlistedLaw
from mechanism.machine import Machine
from mechanism.mjcf.elements import child, text_of
from mechanism.mjcf.ramps import ramps_of
from xneck_foundation.errors import Refused

MOTOR_SPEED_RAD_S, JOINT_SPEED_RAD_S, JOINT_ANGLE_RAD, ELONGATION_M = 1000.0, 30.0, 3.0, 0.05
"""beyond these a function of one variable is held: faster, further and longer than an arm of this kind goes (docs/thresholds.md)"""
_NO_LIMIT_N = 1e9
_NO_GAIN = 1e-30
"""by which controls act on laws: with 0 MuJoCo takes a force that grows with the speed for a damping ratio, and drops it"""

_MEMORY = "MuJoCo has no element that remembers how a cable was stretched"
REFUSALS: Mapping[str, str] = {
    "backlash": "MuJoCo has no play between two bodies without contacts",
    "cable_creep": _MEMORY,
    "cable_hysteresis": _MEMORY,
    "presliding_friction": "MuJoCo has no element that remembers how far a motor turned since it turned round",
    "pulley_friction": "MuJoCo has no friction in proportion to the tension of a tendon",
    "youngs_modulus_in_pose": "MuJoCo has no tendon whose stiffness follows its length",
}
"""why a law cannot be written, by its name"""
_FORCE_LAWS = ("actuator_gain", "actuator_offset")
_SPEED_LAWS = ("dry_friction", "stribeck_friction")
_LINEAR_CABLES = ("linear_cable", "youngs_modulus")
_ELONGATION_LAWS = ("cable_hardening", "cable_toe", "cable_slack")
WRITTEN = (
    *_FORCE_LAWS,
    "actuator_lag",
    *_SPEED_LAWS,
    "viscous_friction",
    *_LINEAR_CABLES,
    *_ELONGATION_LAWS,
    "joint_friction",
)
"""laws that are written"""
_UNLISTED = ("motor_speed", "joint_angle", "joint_speed")
"""variables that an unlisted law may follow: those of which MuJoCo's actuators know the coordinate"""


@dataclass(frozen=True)
class _Coordinate:
    """A joint or tendon that an actuator acts on, and whether its force follows the place or the speed, in whose unit."""

    kind: Literal["joint", "tendon"]
    name: str
    follows: Literal["place", "speed"]
    unit: float = 1.0
    """of the law's variable in those of the coordinate: m of a motor's slide a radian of the motor"""
    zero: float = 0.0
    """of the law's variable, in the coordinate"""


def refuse_unwritten(names: Iterable[str]) -> None:
    """Raises Refused where a law has no element in MuJoCo, with all such laws and the reasons."""
    reasons = {name: reason for name in names if (reason := _reason(name))}
    if reasons:
        words = "; ".join(f"{name}: {reason}" for name, reason in reasons.items())
        raise Refused("export to MJCF", words, "simulate it with xneck, or take the law out of model.yaml")


def _reason(name: str) -> str | None:
    law = law_named(name)
    if isinstance(law, UnlistedLaw):
        variable = law.variable
        if variable.factor or variable.name not in _UNLISTED:
            return f"MuJoCo's actuators do not follow {' and '.join(variable.follows)}"
        if variable.span:
            return "it is written for single joints only"
        return None
    return REFUSALS.get(name)


def write_motor_forces(machine: Machine, actuator: Element) -> None:
    """Actuators motor1..M, whose controls are the forces as a log has them, N."""
    affine = _only(machine, _FORCE_LAWS)
    offset, one = (affine.acting_force(np.full((1, machine.arm.M), f), 1.0)[0] for f in (0.0, 1.0))
    for j in range(machine.arm.M):
        motor = child(
            actuator,
            "general",
            name=f"motor{j + 1}",
            joint=f"motor{j + 1}",
            gainprm=(float(one[j] - offset[j]),),
            biastype="affine",
            biasprm=(float(offset[j]), 0, 0),
        )
        if "actuator_lag" in machine.names and (lag := _of(machine, "taul", machine.arm.M)[j]) > 0:
            motor.set("dyntype", "filterexact")
            motor.set("dynprm", repr(float(lag)))


def write_motor_friction(machine: Machine, joints: Mapping[str, Element], actuator: Element) -> None:
    """Viscous friction as the slides' damping, all that else follows the speed as ramps."""
    arm, laws = machine.arm, _followed(machine, "motor_speed", _SPEED_LAWS)
    if "viscous_friction" in machine.names:
        for j, fv in enumerate(_of(machine, "fv", arm.M)):
            joints[f"motor{j + 1}"].set("damping", repr(float(fv / arm.drum[j])))
    for j in range(arm.M if laws.names else 0):

        def friction(speed: Array, j: int = j) -> Array:
            at = MotorMotion(np.repeat(speed[:, None], arm.M, axis=1), np.zeros(arm.M), np.zeros(arm.M))
            return np.broadcast_to(laws.friction(at), (len(speed), arm.M))[:, j]

        slide = _Coordinate("joint", f"motor{j + 1}", "speed", unit=float(arm.drum[j]))
        _write_ramps(actuator, f"friction{j + 1}", slide, friction, (-MOTOR_SPEED_RAD_S, MOTOR_SPEED_RAD_S))


def write_cable_forces(machine: Machine, rest_lengths: tuple[float, ...], actuator: Element) -> None:
    """Actuators cable1..M: minus the tension, which is never below zero; rest_lengths: of the tendons at x = x0, m."""
    arm = machine.arm
    linear = _only(machine, _LINEAR_CABLES)
    k, ca = (_pull(linear, *x) for x in (((1.0,), (0.0,)), ((0.0,), (1.0,))))
    for j in np.flatnonzero(k[0] <= 0):
        raise Refused(
            "export to MJCF", f"cable {j + 1} has no stiffness above zero", "identify it from a livelier motion"
        )
    further = _only(machine, _ELONGATION_LAWS)
    for j, rest in enumerate(rest_lengths):
        zero = rest - float(arm.x0[j])  # length of the tendon that is not stretched
        child(
            actuator,
            "general",
            name=f"cable{j + 1}",
            tendon=f"cable{j + 1}",
            gainprm=(_NO_GAIN,),
            biastype="affine",
            biasprm=(float(k[0, j]) * zero, -float(k[0, j]), -float(ca[0, j])),
            forcerange=(-_NO_LIMIT_N, 0),
            forcelimited=True,
        )

        def pull(x: Array, j: int = j) -> Array:
            """Beyond the cable above, neither of which pushes."""
            of_linear = float(k[0, j]) * x
            return np.maximum(of_linear + _pull(further, x, np.zeros_like(x))[:, j], 0.0) - np.maximum(of_linear, 0.0)

        if further.names:
            tendon = _Coordinate("tendon", f"cable{j + 1}", "place", zero=zero)
            _write_ramps(actuator, f"stiffening{j + 1}", tendon, pull, (-ELONGATION_M, ELONGATION_M))


def write_joint_forces(machine: Machine, tendons: Mapping[str, Element], actuator: Element) -> None:
    """Friction of the arm's own joints, on the fixed tendons alpha1..N."""
    n = machine.arm.N
    dry = _followed(machine, "joint_speed", ("joint_friction",))
    if "joint_friction" in machine.names:
        for i, dj in enumerate(_of(machine, "dj", n)):
            tendons[f"alpha{i + 1}"].set("damping", repr(float(dj)))
        dry = replace(dry, values={**dry.values, "dj": np.zeros(1)})
    of_angle = _followed(machine, "joint_angle", ())
    for i in range(n):

        def by_speed(speed: Array, i: int = i) -> Array:
            rows = np.repeat(speed[:, None], n, axis=1)
            return np.broadcast_to(dry.resistance(JointMotion(np.zeros_like(rows), rows)), rows.shape)[:, i]

        def by_angle(angle: Array, i: int = i) -> Array:
            rows = np.repeat(angle[:, None], n, axis=1)
            return np.broadcast_to(of_angle.resistance(JointMotion(rows, np.zeros_like(rows))), rows.shape)[:, i]

        name = f"alpha{i + 1}"
        if dry.names:
            speed = _Coordinate("tendon", name, "speed")
            _write_ramps(actuator, f"joint_friction{i + 1}", speed, by_speed, (-JOINT_SPEED_RAD_S, JOINT_SPEED_RAD_S))
        if of_angle.names:
            place = _Coordinate("tendon", name, "place")
            _write_ramps(actuator, f"joint_torque{i + 1}", place, by_angle, (-JOINT_ANGLE_RAD, JOINT_ANGLE_RAD))


def _write_ramps(
    actuator: Element,
    name: str,
    at: _Coordinate,
    resistance: Callable[[Array], Array],
    ends: tuple[float, float],
) -> None:
    """Actuators that take `resistance`, a function of the law's variable between two ends, from a coordinate."""
    constant, ramps = ramps_of(lambda v: -resistance(v), *ends)
    for number, ramp in enumerate(ramps, start=1):
        slope, begin = ramp.slope / at.unit, at.zero + at.unit * ramp.begin
        bias = (-slope * begin, slope, 0) if at.follows == "place" else (-slope * begin, 0, slope)
        limits = (ramp.low, ramp.high)
        part = child(actuator, "general", name=f"{name}_{number}", gainprm=(_NO_GAIN,), biastype="affine", biasprm=bias)
        part.attrib |= {at.kind: at.name, "forcelimited": "true", "forcerange": text_of(limits)}
    if constant:
        whole = child(
            actuator, "general", name=f"{name}_0", gainprm=(_NO_GAIN,), biastype="affine", biasprm=(constant, 0, 0)
        )
        whole.set(at.kind, at.name)


def _only(machine: Machine, names: Iterable[str]) -> Machine:
    """The machine with those of its laws that are among `names`."""
    wanted = set(names)
    return replace(machine, names=tuple(name for name in machine.names if name in wanted))


def _followed(machine: Machine, variable: str, listed: Iterable[str]) -> Machine:
    """The machine with those of its laws that are among `listed`, or are in no catalogue and follow a variable."""
    unlisted = [name for name in machine.names if isinstance(law := law_named(name), UnlistedLaw)
                and law.variable.name == variable]  # fmt: skip
    return _only(machine, (*listed, *unlisted))


def _pull(machine: Machine, x: Sequence[float] | Array, x_d: Sequence[float] | Array) -> Array:
    """Tension of every cable at elongations x (K,), m, and rates x_d (K,), m/s: (K, M), N."""
    arm = machine.arm
    rows, rates = (np.repeat(np.asarray(v, dtype=float)[:, None], arm.M, axis=1) for v in (x, x_d))
    at = CableMotion(rows, rates, np.ones(arm.M), arm, rates)
    return np.broadcast_to(machine.pull(at, np.zeros((*rows.shape, 0))), rows.shape)


def _of(machine: Machine, term: str, count: int) -> Array:
    return np.broadcast_to(machine.values[term], count)
