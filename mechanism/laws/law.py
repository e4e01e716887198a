"""What every law is: named terms with units and ranges, and the places of the machine where it takes part.

Forces are in N at the cable, torques in N m at the joint. Arrays have leading axes for batches and samples. A law whose terms
are zero does nothing, so that each model is nested in the next.
"""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import ClassVar, Literal

import numpy as np

from mechanism.arm import Arm, Array
from mechanism.friction import dry
from mechanism.path_memory import PathSteps

Values = Mapping[str, Array]
"""By term: one number for each cable (..., M) or joint (..., N), or one for all (..., 1)"""
Part = Literal["cable", "joint", "arm"]


def _nothing() -> Array:
    return np.zeros(())


@dataclass(frozen=True)
class Term:
    """A number of a law or of another cause: its name, unit, range and size, and what tells it."""

    name: str
    unit: str
    _: KW_ONLY
    low: float
    high: float
    size: float
    """what a person would call a change: scales differences and priors"""
    of: Part = "cable"
    """what has a number of its own: every cable (with its motor), every joint, or the arm as a whole"""
    linear: bool = True
    """whether a law is in proportion to it where it may be zero: an estimate may then come out below, by chance"""
    sigma: float = np.inf
    """standard deviation about zero before any fit"""
    would_tell: str = ""
    """what to record or to measure where it is not identified"""

    def count(self, arm: Arm) -> int:
        """Of how many places an arm has one."""
        return {"cable": arm.M, "joint": arm.N, "arm": 1}[self.of]


@dataclass(frozen=True)
class MotorMotion:
    """Motion of the motors and state of their cables, on which friction may depend, all (..., M)."""

    theta_d: Array
    """motor speed, rad/s"""
    tension: Array
    """N"""
    wrap: Array
    """angle by which the cable is wound around the pulleys of its route, rad"""
    theta: Array = field(default_factory=_nothing)
    """motor angle, rad"""
    drum_angle: Array = field(default_factory=_nothing)
    """of the drum behind the gear, rad"""
    force: Array = field(default_factory=_nothing)
    """that the motor is told, N"""
    time: Array = field(default_factory=_nothing)
    """since the recording began, s"""
    arm: Arm | None = None
    """of which they are; None where angles are not told either"""
    memory: Array = field(default_factory=_nothing)
    """memory variables, (..., M, states): of the machine, and where a law is asked, of its own"""
    kept_shares: "KeptShares" = field(default_factory=list, repr=False, compare=False)
    """by speeds and cm, what `share` gave of late"""

    def share(self, cm: float | Array) -> Array:
        """Dry friction's share of its greatest, (48) for fs = 1 N: several laws ask for it, and for the same one many times."""
        for speed, slope, share in self.kept_shares:
            if speed is self.theta_d and slope is cm:
                return share
        share = dry(self.theta_d, cm)
        self.kept_shares[:] = [(self.theta_d, cm, share), *self.kept_shares[:1]]
        return share


KeptShares = list[tuple[Array, float | Array, Array]]


@dataclass(frozen=True)
class CableMotion:
    """Motion of the cables, on which their tension may depend, all (..., M)."""

    x: Array
    """elongation (41), m"""
    x_d: Array
    """m/s"""
    length: Array
    """l(alpha), m"""
    arm: Arm
    travel_d: Array
    """speed at which the drum winds the cable in, (rd/R) theta', m/s"""
    drum_angle: Array = field(default_factory=_nothing)
    """of the drum behind the gear, rad"""
    theta: Array = field(default_factory=_nothing)
    """motor angle, rad"""
    time: Array = field(default_factory=_nothing)
    """since the recording began, s"""


@dataclass(frozen=True)
class JointMotion:
    """Motion of the joints, (..., N), or with the joints on another axis."""

    alpha: Array
    """rad"""
    alpha_d: Array
    """rad/s"""
    time: Array = field(default_factory=_nothing)
    """since the recording began, s"""
    joint_axis: int = -1
    """0 in simulations, where batches are last"""


@dataclass(frozen=True)
class Sliding:
    """Cables that slide over the pulleys of the mechanisms, all (N, ..., M)."""

    speed: Array
    """of what passes the pulleys before each mechanism's span, m/s, towards the drum"""
    before: Array
    """angle by which they are wound around those of the mechanism itself, rad"""
    above: Array
    """the same of those that slide as what is above it, rad"""

    def wrap(self, share: Array) -> Array:
        """Angle of wrap before each span; behind the last one is before it.

        share: of what lies above a span, that slides as the span does all the same; below zero, of what lies before it, that does
        not."""
        sooner, later = np.maximum(share, 0.0) * self.above, np.maximum(-share, 0.0) * self.before
        wrap, above = self.before + sooner - later, self.above - sooner + later
        wrap[1:] += above[:-1]
        wrap[-1] += above[-1]
        return wrap


class Law:
    """A law of the machine: it acts through the methods that it overrides; the others do nothing."""

    name: str
    terms: tuple[Term, ...]
    states: ClassVar[int] = 0
    """number of memory variables of each cable by this law"""
    rubs_under_tension: bool = False
    """whether its friction depends on the cable's tension and on how far it is wound around pulleys"""
    follows_force: bool = False
    """whether its friction depends on what the motor is told"""
    remembers_path: ClassVar[bool] = False
    """whether its friction depends on memory variables, which then follow from the path of the motor's angle alone"""
    memory_bound: ClassVar[float] = np.inf
    """bound of their magnitude; what is bounded forgets nothing: its rate does not depend on it"""
    memory_start: ClassVar[Term | None] = None
    """the variable where a recording begins, if that is not forgotten soon; each recording has its own"""

    @property
    def changes_motor_force(self) -> bool:
        """Whether it changes what force turns the motors: by friction, or by what acts of a command."""
        own = type(self)
        return own.friction is not Law.friction or own.acting_force is not Law.acting_force

    def acting_force(self, p: Values, f: Array, step: float) -> Array:
        """Forces that act where the log says f (..., T, M), N, on rows `step` s apart."""
        return f

    def commanded_force(self, p: Values, force: Array, step: float) -> Array:
        """Forces that the log says where `force` (..., T, M), N, acts: the inverse of `acting_force`."""
        return force

    def next_force(self, p: Values, f: Array, before: Array | None, step: float) -> Array:
        """`acting_force` row by row: the force (M,), N, that acts where the log says f; before: that of the row before, if any."""
        return self.acting_force(p, f[None], step)[0]

    def friction(self, p: Values, at: MotorMotion) -> Array:
        """Force that friction takes from the motor's command, (..., M), N."""
        return np.zeros(())

    def path_steps(self, p: Values, travel: Array) -> PathSteps:
        """What steps of a motor angle's travel (S, M), rad, do to the memory variables, of a law that remembers the path."""
        raise NotImplementedError

    def pull(self, p: Values, at: CableMotion, z: Array) -> Array:
        """Part of a cable's tension by this law, (..., M), N; z: memory variables (..., M, states)."""
        return np.zeros(())

    def undragged(self, p: Values, at: CableMotion, z: Array) -> Array:
        """Tension more, (..., M), N, if the cable's damper felt all of the motor's speed while it crosses its play."""
        return np.zeros(())

    def memory_in_motion(self, at: CableMotion) -> Array:
        """Memory variables, (..., M, states), of cables that have gone on as they go; nothing of what fades or stands anywhere."""
        return np.zeros((*at.x.shape, self.states))

    def memory_rate(self, p: Values, at: CableMotion, z: Array) -> Array:
        """Rate of the memory variables, (..., M, states)."""
        return np.zeros_like(z)

    def loses(self, p: Values) -> bool:
        """Whether `loss` is anything but zero."""
        return False

    def loss(self, p: Values, at: Sliding) -> Array:
        """Logarithm of the ratio of a cable's tension before pulleys to that behind them, (..., M)."""
        return np.zeros(())

    def resistance(self, p: Values, at: JointMotion) -> Array:
        """Torque against the joints' motion, (..., N), N m."""
        return np.zeros(())

    def held_torque(self, p: Values, at: JointMotion) -> Array:
        """By which dry friction may hold a joint at rest otherwise than `resistance` says, (..., N), N m: none where it slides."""
        return np.zeros(())

    def held_loss(self, p: Values, at: Sliding) -> Array:
        """By which dry friction may hold a cable at rest on its pulleys otherwise than `loss` says, (..., M)."""
        return np.zeros(())
