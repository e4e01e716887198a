"""The arm as arrays, so that many arms can be computed at once."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from mechanism.description import Neck

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Arm:
    """Numbers of one arm, or of a batch of arms that share their cables' routes (leading axes of every array).

    Per mechanism, shape (..., N): L, b, r in m; diagonal_mass, top_mass in kg; diagonal_inertia, top_inertia in kg m^2.
    top_com, shape (..., N, 2), m, in the bar's frame. Of the springs on the left and on the right, shape (..., 2, N):
    spring_stiffness in N/m, spring_free_length in m.
    Per cable and motor, shape (..., M): x0, cable_length in m; section in m^2; drum = rd/R in m/rad (cable travel per motor angle),
    gear = R, motor_inertia in kg m^2. gravity, shape (..., 2), m/s^2.
    """

    L: Array
    b: Array
    r: Array
    diagonal_mass: Array
    diagonal_inertia: Array
    top_mass: Array
    top_inertia: Array
    top_com: Array
    spring_stiffness: Array
    spring_free_length: Array
    gravity: Array
    x0: Array
    cable_length: Array
    section: Array
    drum: Array
    gear: Array
    motor_inertia: Array
    spring_slack: tuple[bool, ...]
    routes: tuple[tuple[str, ...], ...]

    @property
    def N(self) -> int:
        """Number of mechanisms."""
        return len(self.spring_slack)

    @property
    def M(self) -> int:
        """Number of cables."""
        return len(self.routes)

    @property
    def motor_mass(self) -> Array:
        """Ia (R/rd)^2, the motor's inertia as a mass on its cable, shape (..., M), kg."""
        return self.motor_inertia / self.drum**2


def arm_of(neck: Neck) -> Arm:
    """The arrays of an arm that neck.yaml describes."""
    m, c, a = neck.mechanisms, neck.cables, neck.motors
    return Arm(
        L=np.array([x.L for x in m]),
        b=np.array([x.b for x in m]),
        r=np.array([x.r for x in m]),
        diagonal_mass=np.array([x.diagonal.mass for x in m]),
        diagonal_inertia=np.array([x.diagonal.inertia for x in m]),
        top_mass=np.array([x.top.mass for x in m]),
        top_inertia=np.array([x.top.inertia for x in m]),
        top_com=np.array([x.top.com for x in m]),
        spring_stiffness=np.array([[side.stiffness for side in x.springs.sides] for x in m]).T,
        spring_free_length=np.array([[side.free_length for side in x.springs.sides] for x in m]).T,
        gravity=np.array(neck.gravity),
        x0=np.array([x.x0 for x in c]),
        cable_length=np.array([x.length for x in c]),
        section=np.array([x.section for x in c]),
        drum=np.array([x.rd / x.R for x in a]),
        gear=np.array([float(x.R) for x in a]),
        motor_inertia=np.array([x.Ia for x in a]),
        spring_slack=tuple(x.springs.slack for x in m),
        routes=tuple(x.route for x in c),
    )


def batch(arms: Sequence[Arm]) -> Arm:
    """Arms of the same routes as one, with a new first axis over the arms."""
    if len({(a.routes, a.spring_slack) for a in arms}) != 1:
        raise ValueError("a batch needs arms of the same routes and kind of springs")
    stacked = {
        f.name: np.stack([getattr(a, f.name) for a in arms])
        for f in fields(Arm)
        if f.name not in ("spring_slack", "routes")
    }
    return Arm(**stacked, spring_slack=arms[0].spring_slack, routes=arms[0].routes)
