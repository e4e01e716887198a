"""Bars and diagonals as bodies, springs as tendons, and the constraint that closes each antiparallelogram.

Bar i-1 carries diagonal A (hinged at its lower left end), A carries bar i (hinged at A's upper end, the right one of bar i), and
diagonal B (hinged at the right end of bar i-1) is held to the left end of bar i. All joint coordinates are zero in the straight
pose, so that alpha_i = A_i + bar_i.
"""

from dataclasses import dataclass
from math import atan2, cos, pi, sin, sqrt
from xml.etree.ElementTree import Element

import numpy as np

from mechanism.arm import Arm, Array
from mechanism.geometry import diagonal_angle
from mechanism.mjcf.elements import child

MIN_MASS_KG, MIN_INERTIA_KG_M2 = 1e-9, 1e-12
"""what a body without mass gets, because MuJoCo takes no moving body without"""
BAR_RADIUS_M = 0.002
"""of what is drawn"""
SIDES = ("left", "right")


@dataclass(frozen=True)
class Bodies:
    """The elements to which cables are fixed: bars 0..N (bar 0 is the base) and diagonals A of mechanisms 1..N, in this order."""

    bars: tuple[Element, ...]
    diagonals: tuple[Element, ...]


def straight_lean(L: float, b: float) -> float:
    """Angle of diagonal A against its bottom bar in the straight pose, rad."""
    return atan2(sqrt(L**2 - b**2), b)


def joint_coordinates(arm: Arm, alpha: Array) -> Array:
    """Coordinates of the hinges A, bar and B of every mechanism at joint angles alpha (..., N), rad: (..., N, 3), rad."""
    lean = np.arctan2(np.sqrt(arm.L**2 - arm.b**2), arm.b)
    phi, psi = np.moveaxis(diagonal_angle(arm, np.asarray(alpha, dtype=float)), -1, 0)
    return np.stack([phi - lean, alpha - phi + lean, psi - (pi - lean)], axis=-1)


def write_bodies(arm: Arm, worldbody: Element, equality: Element, tendon: Element) -> Bodies:
    """Writes all bodies with their springs and closing constraints."""
    bars = [child(worldbody, "body", name="bar0")]
    diagonals = []
    for i in range(arm.N):
        L, b = float(arm.L[i]), float(arm.b[i])
        lean, below, number = straight_lean(L, b), bars[-1], i + 1
        A = child(below, "body", name=f"A{number}", pos=(-b / 2, 0, 0), euler=(0, 0, lean))
        child(A, "joint", name=f"A{number}")
        _rod(A, arm, i)
        middle = (L - b / 2 * cos(lean), b / 2 * sin(lean), 0)
        bar = child(A, "body", name=f"bar{number}", pos=middle, euler=(0, 0, -lean))
        child(bar, "joint", name=f"bar{number}", pos=(b / 2, 0, 0))
        com = (float(arm.top_com[i, 0]), float(arm.top_com[i, 1]), 0.0)
        _inertial(bar, float(arm.top_mass[i]), com, float(arm.top_inertia[i]))
        child(bar, "geom", type="capsule", fromto=(-b / 2, 0, 0, b / 2, 0, 0), size=(BAR_RADIUS_M,))
        B = child(below, "body", name=f"B{number}", pos=(b / 2, 0, 0), euler=(0, 0, pi - lean))
        child(B, "joint", name=f"B{number}")
        _rod(B, arm, i)
        child(B, "site", name=f"end_B{number}", pos=(L, 0, 0))
        for side, x in zip(SIDES, (-b / 2, b / 2), strict=True):
            child(below, "site", name=f"bottom_{side}{number}", pos=(x, 0, 0))
            child(bar, "site", name=f"top_{side}{number}", pos=(x, 0, 0))
        child(equality, "connect", name=f"closed{number}", site1=f"end_B{number}", site2=f"top_left{number}")
        bars.append(bar)
        diagonals.append(A)
    child(bars[0], "geom", type="capsule", fromto=(-arm.b[0] / 2, 0, 0, arm.b[0] / 2, 0, 0), size=(BAR_RADIUS_M,))
    _write_springs(arm, tendon)
    return Bodies(tuple(bars), tuple(diagonals))


def _write_springs(arm: Arm, tendon: Element) -> None:
    for i in range(arm.N):
        for k, side in enumerate(SIDES):
            free = float(arm.spring_free_length[k, i])
            spring = child(
                tendon,
                "spatial",
                name=f"spring_{side}{i + 1}",
                stiffness=float(arm.spring_stiffness[k, i]),
                # between two lengths a tendon does nothing
                springlength=(0.0, free) if arm.spring_slack[i] else (free,),
            )
            for end in ("bottom", "top"):
                child(spring, "site", site=f"{end}_{side}{i + 1}")


def _rod(body: Element, arm: Arm, i: int) -> None:
    L = float(arm.L[i])
    _inertial(body, float(arm.diagonal_mass[i]), (L / 2, 0.0, 0.0), float(arm.diagonal_inertia[i]))
    child(body, "geom", type="capsule", fromto=(0, 0, 0, L, 0, 0), size=(BAR_RADIUS_M,))


def _inertial(body: Element, mass: float, at: tuple[float, float, float], inertia: float) -> None:
    """The arm turns about z only: the other two moments never take part."""
    moment = max(inertia, MIN_INERTIA_KG_M2)
    child(body, "inertial", pos=at, mass=max(mass, MIN_MASS_KG), diaginertia=(moment, moment, moment))
