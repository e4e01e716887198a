"""Cables as spatial tendons whose lengths change as those of the pulley model, exactly.

A tendon of MuJoCo cannot be wound around a pulley several times. Its length is therefore made of branches, each of which is exact:

    what the motor winds in     a straight piece to a slide, whose coordinate is (rd/R) theta
    (19), (20)                  from the lowest point of the lower pulley around it to the centre of the upper one, as it is
    (25)                        the side, and r alpha: a wrap around a pulley on each of the two hinges that make alpha
    (30)                        r (bar - A) by the same two: 2 psi - alpha = 2 pi - A + bar, up to a constant

A wrap on a hinge covers less than half a turn at any angle of the joint, as MuJoCo needs. Constants do not matter: the elongation
is told from the length in the straight pose.
"""

from dataclasses import dataclass
from math import acos, cos, pi, sin, sqrt
from xml.etree.ElementTree import Element

from mechanism.arm import Arm
from mechanism.description import SIDE_OF
from mechanism.mjcf.bodies import Bodies, straight_lean
from mechanism.mjcf.elements import child

SLIDE_M = 1.0
"""m of cable between a motor's slide and its anchor at theta = 0, more than any drum winds"""
_SIGN = {"left": -1.0, "right": 1.0}
_ANGLES = {
    "right_through": (1.0, 1.0),
    "left_through": (-1.0, -1.0),
    "strut": (-1.0, 1.0),
    "strut_mirrored": (-1.0, 1.0),
}
"""change of a portion's length by the hinges A and bar, in units of r, beside that of its side"""


@dataclass(frozen=True)
class _Hinge:
    """A hinge with the bodies that it joins; its coordinate goes from -low to pi - low as the joint goes from -pi to pi."""

    name: str
    centre: tuple[float, float]
    """in the lower body's frame, m"""
    carried_centre: tuple[float, float]
    """in the upper body's frame, m"""
    turned: float
    """angle of the upper body against the lower one where the coordinate is zero, rad"""
    low: float
    lower: Element
    upper: Element


def write_cables(arm: Arm, bodies: Bodies, worldbody: Element, tendon: Element) -> tuple[float, ...]:
    """Writes motors as slides, and cables; returns the cables' lengths in the straight pose with theta = 0, m."""
    rest_lengths = []
    for j, route in enumerate(arm.routes):
        name = f"cable{j + 1}"
        _write_motor(worldbody, j, float(arm.motor_mass[j]))
        cable = child(tendon, "spatial", name=name, rgba=(0.2, 0.2, 0.2, 1.0))
        child(cable, "site", site=f"anchor{j + 1}")
        child(cable, "site", site=f"wound{j + 1}")
        length = SLIDE_M
        for i, word in enumerate(route):
            length += _write_portion(arm, bodies, cable, name, i, word)
        rest_lengths.append(length)
    return tuple(rest_lengths)


def _write_motor(worldbody: Element, j: int, mass: float) -> None:
    """A motor as a mass on its cable, on a slide along z, which gravity does not move."""
    x = -0.2 - 0.03 * j
    child(worldbody, "site", name=f"anchor{j + 1}", pos=(x, 0, -SLIDE_M))
    body = child(worldbody, "body", name=f"motor{j + 1}", pos=(x, 0, 0))
    child(body, "inertial", pos=(0, 0, 0), mass=mass, diaginertia=(mass, mass, mass))
    child(body, "joint", name=f"motor{j + 1}", type="slide", axis=(0, 0, 1))
    child(body, "site", name=f"wound{j + 1}", pos=(0, 0, 0))


def _write_portion(arm: Arm, bodies: Bodies, cable: Element, name: str, i: int, word: str) -> float:
    """The portion of a cable in mechanism i, from 0; returns its length in the straight pose."""
    L, b, r = float(arm.L[i]), float(arm.b[i]), float(arm.r[i])
    side, number, straight = SIDE_OF[word], i + 1, sqrt(L**2 - b**2)
    if word in ("left", "right"):
        return _write_end(bodies.bars[i], cable, name, number, side, _SIGN[side] * b / 2, r, straight)
    length = 0.0
    if word.endswith("_through"):
        child(cable, "pulley", divisor=1)
        child(cable, "site", site=f"bottom_{side}{number}")
        child(cable, "site", site=f"top_{side}{number}")
        length += straight
    if r > 0:
        lean = straight_lean(L, b)
        below, A, above = bodies.bars[i], bodies.diagonals[i], bodies.bars[i + 1]
        hinges = (
            _Hinge(
                name="A", centre=(-b / 2, 0.0), carried_centre=(0.0, 0.0), turned=lean, low=lean, lower=below, upper=A
            ),
            _Hinge(
                name="bar",
                centre=(L, 0.0),
                carried_centre=(b / 2, 0.0),
                turned=-lean,
                low=pi - lean,
                lower=A,
                upper=above,
            ),
        )
        for hinge, sign in zip(hinges, _ANGLES[word], strict=True):
            length += _write_wrap(hinge, cable, f"{name}_{number}{hinge.name}", sign, r)
    return length


def _write_end(
    bar: Element, cable: Element, name: str, number: int, side: str, x: float, r: float, straight: float
) -> float:
    """(19), (20): from the lowest point of the lower pulley around its outer side to the centre of the upper one."""
    child(cable, "pulley", divisor=1)
    if not r:
        child(cable, "site", site=f"bottom_{side}{number}")
        child(cable, "site", site=f"top_{side}{number}")
        return straight
    out = _SIGN[side]
    child(bar, "site", name=f"{name}_entry", pos=(x - out * r, -r, 0))
    child(bar, "site", name=f"{name}_side", pos=(x + out * 2 * r, 0, 0))
    child(bar, "geom", name=f"{name}_pulley", class_="pulley", pos=(x, 0, 0), size=(r, r))
    child(cable, "site", site=f"{name}_entry")
    child(cable, "geom", geom=f"{name}_pulley", sidesite=f"{name}_side")
    child(cable, "site", site=f"top_{side}{number}")
    return r + sqrt(straight**2 - r**2) + r * (pi - acos(r / straight))


def _write_wrap(hinge: _Hinge, cable: Element, name: str, sign: float, r: float) -> float:
    """sign r times the hinge's coordinate, and a constant: between a site on each of its bodies around a pulley on the hinge.

    The cable leaves the lower body's site along the tangent at angle 0 of that body, and meets the upper body's after a wrap of
    `covered` where the coordinate is zero.
    """
    covered = hinge.low if sign > 0 else pi - hinge.low
    upper_angle = (
        sign * covered - hinge.turned
    )  # of the point where the cable leaves the pulley, in the upper body's frame
    child(hinge.lower, "site", name=f"{name}_from", pos=_tangent(hinge.centre, 0.0, -sign, r))
    child(hinge.lower, "site", name=f"{name}_side", pos=(hinge.centre[0], hinge.centre[1] + sign * 2 * r, 0))
    child(hinge.lower, "geom", name=name, class_="pulley", pos=(*hinge.centre, 0), size=(r, r))
    child(hinge.upper, "site", name=f"{name}_to", pos=_tangent(hinge.carried_centre, upper_angle, sign, r))
    child(cable, "pulley", divisor=1)
    child(cable, "site", site=f"{name}_from")
    child(cable, "geom", geom=name, sidesite=f"{name}_side")
    child(cable, "site", site=f"{name}_to")
    return 2 * r + r * covered


def _tangent(centre: tuple[float, float], angle: float, along: float, r: float) -> tuple[float, float, float]:
    """A point r along the tangent (1: counter-clockwise) that touches the circle at an angle."""
    x, y = centre
    return x + r * (cos(angle) - along * sin(angle)), y + r * (sin(angle) + along * cos(angle)), 0.0
