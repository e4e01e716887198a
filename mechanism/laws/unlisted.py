"""Laws that no catalogue lists: a form of one variable, against the motors, in their encoders, in the cables or against the joints.

`diagnose` writes those that it finds under a name that says all: what it acts on, the form, and the variable, as
`motor.harmonic.motor_angle` or, where it turns over with the motor's direction, `motor.bump.motor_angle.along`. What is in
proportion to another variable besides has it in its name, as `motor.harmonic.motor_angle.by_force`, and what spans several joints
has these, as `joint.power.joint_angle.over_1_to_2`. A second law of the same kind ends in `.2`.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, cast

import numpy as np

from discovery.form import Constants, Form, Kind, forms_of
from mechanism.arm import Arm, Array
from mechanism.friction import dry, turned_over
from mechanism.kept_by_array import KeptByArray
from mechanism.laws.law import CableMotion, JointMotion, Law, MotorMotion, Part, Term, Values

Acts = Literal["motor", "encoder", "cable", "joint"]
Factor = Literal["", "sign(motor_speed)", "motor_speed", "force", "sign(joint_speed)", "joint_speed"]
"""what multiplies a function of a variable, in words"""
COPIES = 4
"""of one kind of law that a machine may have"""
MAX_SPANNING = 6
"""joints of an arm at most in which something may span several (docs/thresholds.md)"""
_UNITS: Mapping[Acts, str] = {"motor": "N", "encoder": "rad", "cable": "N", "joint": "N m"}
_SIZES: Mapping[Acts, float] = {"motor": 1.0, "encoder": 0.01, "cable": 1.0, "joint": 0.01}
_ELONGATION_SIZES_M = {"drum_angle": 1e-4, "motor_angle": 1e-5}
"""behind the gear it comes more slowly: sizes that change the torque by as much"""
_ANGLE_STEP = 1e-4
"""rad, of the differences that give the rate of an elongation"""
_ENCODER_STEP = 1e-3
"""rad, of those that give the slope and the bend of an encoder's error, which would lose digits by smaller ones"""
_JOINT_TURNS_OVER_RAD_S, _JOINT_TURNS_OVER_POWER = 0.03, 2.7
"""where, and how soon, a law changes sign with the joint's direction (docs/thresholds.md)"""
_PARTS: Mapping[Acts, Part] = {"motor": "cable", "encoder": "cable", "cable": "cable", "joint": "joint"}


@dataclass(frozen=True)
class Variable:
    """What a law may follow, and what it acts on."""

    acts: Acts
    name: str
    """as results have it"""
    unit: str
    kind: Kind
    factor: Factor = ""
    """what multiplies a function of it"""
    span: tuple[int, int] | None = None
    """first and last of the joints, from 1, that it is the sum of: what spans them, as a hose, resists each of them alike"""

    @property
    def place(self) -> str:
        """Where it acts, if at one place only."""
        return "joints {} to {}".format(*self.span) if self.span else ""

    def spanned(self, of_joints: Array, joint_axis: int = -1) -> Array:
        """Of what each joint has (..., N) the sum over those that are spanned, (..., 1); all (..., N) where nothing spans any."""
        if self.span is None:
            return of_joints
        first, last = self.span
        each = [slice(i, i + 1) for i in range(first - 1, last)]
        return sum((of_joints[one] if joint_axis == 0 else of_joints[..., one] for one in each), np.zeros(()))

    def at_joints(self, made: Array, like: Array, joint_axis: int = -1) -> Array:
        """What is made in all that are spanned (..., 1), at each of them, as `like` (..., N); made where nothing spans any."""
        if self.span is None:
            return made
        first, last = self.span
        inside = np.array([float(first <= i + 1 <= last) for i in range(like.shape[joint_axis])])
        return made * (inside.reshape(-1, *[1] * (len(like.shape) - 1)) if joint_axis == 0 else inside)

    @property
    def joints(self) -> int:
        """That an arm has at least which has what it is of."""
        return self.span[1] if self.span else 1

    @property
    def turns_over(self) -> bool:
        """Whether it turns over with the motor's or joint's direction."""
        return self.factor.startswith("sign(")

    @property
    def along_motion(self) -> bool:
        """Whether it has the sign of the motion, if its function has one sign."""
        return "speed" in self.factor

    @property
    def follows(self) -> tuple[str, ...]:
        """Names of all that a law of it depends on."""
        factor = self.factor.removeprefix("sign(").removesuffix(")")
        return (self.name, factor) if factor else (self.name,)

    @property
    def winds(self) -> bool:
        """Whether a law of it says how much less cable a turn winds in than the drum's radius has it.

        Where it does so its torque follows: a drum whose middle is off has another lever at every angle.
        """
        return self.acts == "cable" and self.kind == "turn"

    @property
    def misreads(self) -> bool:
        """Whether a law of it says by how much an encoder reads more than the motor has turned."""
        return self.acts == "encoder"

    @property
    def unit_of_law(self) -> str:
        """N, N m, rad of an encoder, or m of elongation; over that of what it is in proportion to besides."""
        if self.winds:
            return "m"
        return {"force": "1", "motor_speed": "N s/rad", "joint_speed": "N m s/rad"}.get(self.factor, _UNITS[self.acts])

    @property
    def size_of_law(self) -> float:
        """What a person would call a change, in its unit."""
        if self.winds:
            return _ELONGATION_SIZES_M[self.name]
        return _SIZES[self.acts] / {"force": 50.0, "motor_speed": 20.0}.get(self.factor, 1.0)


VARIABLES = (
    Variable("motor", "force", "N", "line"),
    Variable("motor", "force", "N", "line", "sign(motor_speed)"),
    Variable("motor", "tension", "N", "line"),
    Variable("motor", "tension", "N", "line", "sign(motor_speed)"),
    Variable("motor", "motor_angle", "rad", "turn"),
    Variable("motor", "motor_angle", "rad", "turn", "sign(motor_speed)"),
    Variable("motor", "drum_angle", "rad", "turn"),
    Variable("motor", "drum_angle", "rad", "turn", "sign(motor_speed)"),
    Variable("motor", "motor_speed", "rad/s", "line"),
    Variable("motor", "time", "s", "time"),
    Variable("motor", "time", "s", "time", "sign(motor_speed)"),
    Variable("motor", "tension", "N", "line", "motor_speed"),
    Variable("motor", "motor_angle", "rad", "turn", "force"),
    Variable("motor", "drum_angle", "rad", "turn", "force"),
    Variable("motor", "time", "s", "time", "force"),
    Variable("motor", "time", "s", "time", "motor_speed"),
    Variable("encoder", "motor_angle", "rad", "turn"),
    Variable("cable", "motor_angle", "rad", "turn"),
    Variable("cable", "drum_angle", "rad", "turn"),
    Variable("cable", "time", "s", "time"),
    Variable("joint", "joint_angle", "rad", "arc"),
    Variable("joint", "joint_angle", "rad", "arc", "sign(joint_speed)"),
    Variable("joint", "joint_angle", "rad", "line", "joint_speed"),
    Variable("joint", "joint_speed", "rad/s", "line"),
    Variable("joint", "time", "s", "time"),
    Variable("joint", "time", "s", "time", "sign(joint_speed)"),
    Variable("joint", "time", "s", "time", "joint_speed"),
    *(
        Variable("joint", "joint_angle", "rad", "line", span=(first, last))
        for last in range(2, MAX_SPANNING + 1)
        for first in range(1, last)
    ),
)
_OF_MOTOR: Mapping[str, Callable[[MotorMotion], Array]] = {
    "force": lambda at: at.force,
    "tension": lambda at: at.tension,
    "motor_angle": lambda at: at.theta,
    "drum_angle": lambda at: at.drum_angle,
    "motor_speed": lambda at: at.theta_d,
    "time": lambda at: at.time,
}
_OF_CABLE: Mapping[str, Callable[[CableMotion], Array]] = {
    "motor_angle": lambda at: at.theta,
    "drum_angle": lambda at: at.drum_angle,
    "time": lambda at: at.time,
}
_OF_JOINT: Mapping[str, Callable[[JointMotion], Array]] = {
    "joint_angle": lambda at: at.alpha,
    "joint_speed": lambda at: at.alpha_d,
    "time": lambda at: at.time,
}


class UnlistedLaw(Law):
    """Amounts at each motor, cable or joint; inner constants are common to all."""

    def __init__(self, variable: Variable, form: Form, copy: int) -> None:
        self.variable, self.form = variable, form
        self.name = law_name(variable, form, copy)
        self.amount_terms = tuple(self._term(name) for name in form.amounts)
        """what it is in proportion to"""
        self.constant_terms = tuple(self._term(name) for name in form.constants)
        """how it acts"""
        self.terms = (*self.amount_terms, *self.constant_terms)
        of_tension = variable.acts == "motor" and variable.name == "tension"
        self.rubs_under_tension = variable.winds or variable.misreads or of_tension
        self.follows_force = variable.misreads or "force" in (variable.name, variable.factor)

    @property
    def changes_motor_force(self) -> bool:
        return self.variable.acts in ("motor", "encoder") or self.variable.winds

    def term_name(self, name: str) -> str:
        """Of an amount or inner constant, as no other law has it."""
        return f"{self.name}.{name}"

    def values(self, amounts: Array, constants: Mapping[str, float]) -> dict[str, Array]:
        """A machine's values: amounts (k, places)."""
        named = {self.term_name(name): a for name, a in zip(self.form.amounts, amounts, strict=True)}
        return named | {self.term_name(name): np.full(1, value) for name, value in constants.items()}

    def friction(self, p: Values, at: MotorMotion) -> Array:
        if self.variable.winds and at.arm is not None:
            return self._winding(p, at.theta, at.arm).share_of_tension * at.tension
        if self.variable.misreads and at.arm is not None:
            return self._misreading(p, at.theta).friction(at.force - at.tension, rubbing(p), at.theta_d, at.arm)
        if self.variable.acts != "motor":
            return np.zeros(())
        made = self._made(p, _OF_MOTOR[self.variable.name](at))
        if self.variable.turns_over:
            return made * at.share(p["cm"])
        return made * _OF_MOTOR[self.variable.factor](at) if self.variable.factor else made

    def pull(self, p: Values, at: CableMotion, z: Array) -> Array:
        if self.variable.misreads:
            read = self._misreading(p, at.theta)
            return read.pull(p["k"], p["ca"], at.travel_d, at.arm)
        if self.variable.acts != "cable":
            return np.zeros(())
        if not self.variable.winds:
            return self._made(p, _OF_CABLE[self.variable.name](at))
        wound = self._winding(p, at.theta, at.arm)
        return p["k"] * wound.longer + p["ca"] * wound.share_of_tension * at.travel_d

    def resistance(self, p: Values, at: JointMotion) -> Array:
        if self.variable.acts != "joint":
            return np.zeros(())
        made = self._made(p, self.variable.spanned(_OF_JOINT[self.variable.name](at), at.joint_axis))
        if self.variable.turns_over:
            return made * joint_direction(at.alpha_d)
        made = made * _OF_JOINT[self.variable.factor](at) if self.variable.factor else made
        return self.variable.at_joints(made, at.alpha, at.joint_axis)

    def _winding(self, p: Values, theta: Array, arm: Arm) -> "Winding":
        """By the angles to which motors have turned; what measured ones come to for an amount of 1 is computed once."""
        amounts, constants = self._numbers(p)
        if not (_WINDINGS.keeps(theta) and _are_of_places(amounts, constants, theta)):
            return Winding.of(self.variable, lambda x: self._made(p, x), theta, arm)
        numbers = (arm.gear, arm.drum, *(np.asarray(c) for c in constants.values()))
        key = (self.variable.name, self.form.name, *(number.tobytes() for number in numbers))
        of_ones = _WINDINGS.get(
            theta, key, lambda: Winding.of(self.variable, lambda x: self._functions(x, constants), theta, arm)
        )
        return of_ones.with_amounts(amounts)

    def _misreading(self, p: Values, theta: Array) -> "Misreading":
        """By the angles to which motors have turned, theta less what is read too much."""
        return Misreading.of(lambda x: self._made(p, x - self._made(p, x)), theta)

    def _made(self, p: Values, x: Array) -> Array:
        amounts, constants = self._numbers(p)
        of_places = _are_of_places(amounts, constants, x)
        # a law mostly acts at one place, and columns of all would be most of a fit's time
        at = np.flatnonzero(np.any(amounts, axis=0)) if of_places else np.empty(0, dtype=np.intp)
        if len(at) == 0 or len(at) == x.shape[-1]:
            return self._sum(amounts, constants, x)
        made = self._sum([a[..., at] for a in amounts], constants, x[..., at])
        out = np.zeros(x.shape)
        out[..., at] = made
        return out

    def _numbers(self, p: Values) -> tuple[list[Array], Constants]:
        """Amounts and inner constants."""
        # arrays that broadcast, as numbers do
        constants = cast(Constants, {name: p[self.term_name(name)] for name in self.form.constants})
        return [p[self.term_name(a)] for a in self.form.amounts], constants

    def _sum(self, amounts: Sequence[Array], constants: Constants, x: Array) -> Array:
        columns = self.form.columns(x, constants)
        return sum((a * columns[..., i] for i, a in enumerate(amounts)), np.zeros(()))

    def _functions(self, x: Array, constants: Constants) -> Array:
        """The form's columns as an axis before those of x (T, M), time last in memory, as recordings have it."""
        columns = np.moveaxis(self.form.columns(x, constants), -1, 0)
        return np.ascontiguousarray(columns.swapaxes(-1, -2)).swapaxes(-1, -2)

    def _term(self, name: str) -> Term:
        unit = self.form.unit(name, self.variable.unit_of_law, self.variable.unit)
        if name in self.form.amounts:
            size, part = self.variable.size_of_law, "arm" if self.variable.span else _PARTS[self.variable.acts]
            return Term(self.term_name(name), unit, low=-np.inf, high=np.inf, size=size, of=part)
        is_place = name in ("place", "begin", "low", "high", "side")
        low = -np.inf if is_place else 1e-6
        size = 0.1 if is_place else 1.0
        return Term(self.term_name(name), unit, low=low, high=np.inf, size=size, of="arm", linear=False)


_WINDINGS = KeptByArray["Winding"]()
"""of measured angles"""


def _are_of_places(amounts: Sequence[Array], constants: Constants, x: Array) -> bool:
    """Whether there are as many amounts as places, and places are last: several machines at once have theirs before."""
    return all(a.shape == x.shape[-1:] for a in amounts) and all(np.size(c) == 1 for c in constants.values())


@dataclass(frozen=True)
class Winding:
    """How a drum winds where it does not as its radius has it, of each cable: (..., M), or with an axis more of functions."""

    longer: Array
    """what the cable is longer by, m"""
    share_of_tension: Array
    """its change by the cable that is wound in; by virtual work the motor feels as much more of the tension"""

    @classmethod
    def of(cls, variable: Variable, function: Callable[[Array], Array], theta: Array, arm: Arm) -> "Winding":
        """By a function, m, of the motor's or of the drum's angle; theta: of the motors, (..., M), rad."""
        gear = arm.gear if variable.name == "drum_angle" else np.ones(())
        angle = theta / gear
        slope = (function(angle + _ANGLE_STEP) - function(angle - _ANGLE_STEP)) / (2 * _ANGLE_STEP)
        return cls(function(angle), slope / (gear * arm.drum))

    def with_amounts(self, amounts: Sequence[Array]) -> "Winding":
        """The sum of functions that are an axis before the others, with an amount (M,) of each."""
        each = (self.longer, self.share_of_tension)
        return Winding(*(sum((a * f for a, f in zip(amounts, of, strict=True)), np.zeros(())) for of in each))


@dataclass(frozen=True)
class Misreading:
    """What an encoder reads too much, of each motor: (..., M), or with an axis more of functions.

    The motor has turned by theta less that. So the drum has wound in less, the motor rubs at another speed, and what speeds it up
    is not what the reading's second derivative says: all are put right as forces.
    """

    error: Array
    """rad"""
    slope: Array
    """by the motor's angle"""
    bend: Array
    """second derivative, 1/rad"""

    @classmethod
    def of(cls, function: Callable[[Array], Array], theta: Array) -> "Misreading":
        """By a function, rad, of the motors' angles (..., M), rad."""
        h = _ENCODER_STEP
        less, error, more = function(theta - h), function(theta), function(theta + h)
        return cls(error, (more - less) / (2 * h), (more - 2 * error + less) / h**2)

    def pull(self, k: Array, ca: Array, travel_d: Array, arm: Arm) -> Array:
        """By which a cable pulls more, N: it is shorter by what the drum has not wound in; travel_d: by the reading, m/s."""
        return -(k * arm.drum * self.error + ca * self.slope * travel_d)

    def friction(self, left: Array, rubs: Callable[[Array], Array], theta_d: Array, arm: Arm) -> Array:
        """What the reading's second derivative has too much of, as friction beside what rubs, N.

        left: force that the tension leaves, N; rubs: friction at speeds, N; theta_d: by the reading, rad/s."""
        turned = theta_d * (1 - self.slope)
        moving = left - rubs(turned) + arm.motor_inertia / arm.drum * self.bend * theta_d**2
        return left - rubs(theta_d) - moving / (1 - self.slope)


def rubbing(p: Values) -> Callable[[Array], Array]:
    """Dry and viscous friction of the motors, N, at their speeds, rad/s; none where the machine has no such law."""
    fs, cm, fv = p.get("fs", np.zeros(1)), p.get("cm", np.ones(1)), p.get("fv", np.zeros(1))
    return lambda theta_d: fs * dry(theta_d, cm) + fv * theta_d


def joint_direction(alpha_d: Array) -> Array:
    """With which laws turn over at rates of a joint (...,), rad/s: -1 to 1."""
    return turned_over(alpha_d / _JOINT_TURNS_OVER_RAD_S, _JOINT_TURNS_OVER_POWER)


def law_name(variable: Variable, form: Form, copy: int = 1) -> str:
    """Of a law; copy counts those of the same kind from 1."""
    parts = [variable.acts, form.name.replace(" ", "_"), variable.name]
    if variable.factor:
        parts.append("along" if variable.turns_over else f"by_{variable.factor}")
    if variable.span:
        parts.append("over_{}_to_{}".format(*variable.span))
    parts += [f"degree{len(form.amounts)}"] if form.name == "polynomial" else []
    parts += [str(copy)] if copy > 1 else []
    return ".".join(parts)


@lru_cache(maxsize=1)
def unlisted_laws() -> Mapping[str, UnlistedLaw]:
    """All that there may be, by name."""
    laws = [
        UnlistedLaw(variable, form, copy)
        for variable in VARIABLES
        for form in forms_of(variable.kind)
        for copy in range(1, COPIES + 1)
    ]
    return {law.name: law for law in laws}
