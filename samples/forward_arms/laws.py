"""Hidden effects: what an arm does beside its base laws. A law is of one arm; batches gather laws of a kind.

A law is a frozen dataclass of numbers and arrays. It may change the plant (masses, gravity), add to a cable's tension, to what
resists a motor, to what drives a joint, or turn what the encoder sees, as a function of `Snapshot`, and may remember with
states of its own.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Self

import numpy as np

from samples.forward_arms.friction import turning
from samples.forward_arms.plant import Array, Plant


class _Picked:
    """A value of some arms among those of all, picked out when a law first looks: most laws look at one or two."""

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __get__(self, s: "Snapshot", owner: type) -> Array:
        value = s.whole[self.name]
        if self.name == "memory":
            value = value[s.rows]
        # stands before this descriptor from now on
        s.__dict__[self.name] = value = value[..., s.columns]
        return value


class Snapshot:
    """What a law may depend on: joints (N, B), motors and cables (M, B) and memory (rows, B) of the B arms that have it."""

    alpha = _Picked()
    alpha_d = _Picked()
    theta = _Picked()
    theta_d = _Picked()
    x = _Picked()
    x_d = _Picked()
    tension = _Picked()
    """of the base law alone, N"""
    wrap = _Picked()
    """rad, over which cables lie on the pulleys of their routes"""
    wraps = _Picked()
    """(N, M, B): of that, before the span of each mechanism"""
    wraps_in_halves = _Picked()
    """the same, where half of what is wound before a span is behind it"""
    Z = _Picked()
    """(N, M, B), m: how fast a span gives cable where a joint turns"""
    memory = _Picked()
    f = _Picked()
    """N at the cable, as commanded to the motors"""
    gear = _Picked()
    """turns of each motor by turn of its drum"""
    stiffness = _Picked()
    """N/m, of the base law"""
    drum = _Picked()
    """m, radius of each drum"""

    def __init__(
        self,
        time: float,
        whole: Mapping[str, Array],
        columns: slice | np.ndarray = slice(None),
        rows: slice = slice(None),
    ) -> None:
        """whole: of all arms; columns: those that have the law; rows: of the memory, those of the law."""
        self.time, self.whole, self.columns, self.rows = time, whole, columns, rows


@dataclass(frozen=True)
class Law:
    """Does nothing; effects override what they change."""

    def memory_rows(self, plant: Plant) -> int:
        """How many states it has, all zero at first."""
        return 0

    def altered(self, plant: Plant) -> Plant:
        """The plant of one arm as it truly is."""
        return plant

    def tension(self, s: Snapshot) -> Array | float:
        """N, added to the cables' tension."""
        return 0.0

    def motor(self, s: Snapshot) -> Array | float:
        """N at the cable, added to what resists the motors."""
        return 0.0

    def joint(self, s: Snapshot) -> Array | float:
        """N m, added to what drives the joints."""
        return 0.0

    def joint_damping(self, s: Snapshot) -> Array | float:
        """(N, N, B), N m s/rad, how steeply `joint` falls with the joints' speeds: a step that knows it may be longer."""
        return 0.0

    def encoder(self, time: float, theta: Array) -> Array:
        """rad, the motors' angles as the encoder has them before it counts."""
        return theta

    def memory_d(self, s: Snapshot) -> Array:
        """Rates of its states."""
        return np.zeros_like(s.memory)

    @classmethod
    def side_by_side(cls, laws: Sequence[Self]) -> Self:
        """The same law of many arms: its numbers with the batch last."""
        return cls(
            **{f.name: np.stack([np.asarray(getattr(law, f.name)) for law in laws], axis=-1) for f in fields(cls)}
        )


@dataclass(frozen=True)
class Payload(Law):
    """A point mass (kg) on the top bar, at `at` (m) from the bar's middle along the bar."""

    mass: float
    at: float = 0.0

    def altered(self, plant: Plant) -> Plant:
        com, mass, inertia = (v.copy() for v in (plant.bar_com, plant.bar_mass, plant.bar_inertia))
        total = mass[-1] + self.mass
        inertia[-1] += mass[-1] * self.mass / total * abs(com[-1] - self.at) ** 2
        com[-1] = (mass[-1] * com[-1] + self.mass * self.at) / total
        mass[-1] = total
        return replace(plant, bar_com=com, bar_mass=mass, bar_inertia=inertia)


@dataclass(frozen=True)
class Tilt(Law):
    """The base leans by `angle` (rad, counter-clockwise): in its frame gravity turns the other way."""

    angle: float

    def altered(self, plant: Plant) -> Plant:
        return replace(plant, gravity=plant.gravity * np.exp(-1j * self.angle))


@dataclass(frozen=True)
class ViscousFriction(Law):
    """Of the motors, N s/rad each."""

    fv: Array

    def motor(self, s: Snapshot) -> Array:
        return self.fv * s.theta_d


@dataclass(frozen=True)
class Stribeck(Law):
    """Dry friction of the motors that is larger near rest by `peak` (N), and fades with speed as a Gaussian of `width` (rad/s).

    It turns over with the motor's direction as the base's friction does.
    """

    peak: float
    width: float

    def motor(self, s: Snapshot) -> Array:
        return self.peak * np.exp(-((s.theta_d / self.width) ** 2)) * turning(s.theta_d)


@dataclass(frozen=True)
class Presliding(Law):
    """The motors' dry friction bends bristles over `width` (rad each) before it slides, whatever it was."""

    width: Array

    def altered(self, plant: Plant) -> Plant:
        return replace(plant, presliding=self.width, hyperbola=np.zeros_like(plant.hyperbola))


@dataclass(frozen=True)
class Hardening(Law):
    """Cables that pull more by cubic (N/m^3 each) times the cube of their elongation."""

    cubic: Array

    def tension(self, s: Snapshot) -> Array:
        return self.cubic * np.maximum(s.x, 0.0) ** 3


@dataclass(frozen=True)
class JointFriction(Law):
    """Dry friction of the joints, N m each, that turns over within `width` (rad/s).

    Steps of a row carry joints to and fro across a narrow width: 0.01 rad/s at 0.12 N m wants an eighth of a row.
    """

    dry: Array
    width: float

    def joint(self, s: Snapshot) -> Array:
        return -self.dry * np.tanh(s.alpha_d / self.width)

    def joint_damping(self, s: Snapshot) -> Array:
        steep = self.dry / self.width * (1 - np.tanh(s.alpha_d / self.width) ** 2)
        return np.eye(len(steep))[..., None] * steep


@dataclass(frozen=True)
class PulleyFriction(Law):
    """Cables that rub on their pulleys, by Euler and Eytelwein.

    A motor that winds in pulls exp(mu wrap) times what arrives at the arm; one that gives way holds exp(-mu wrap) times as much.
    """

    mu: float

    def motor(self, s: Snapshot) -> Array:
        pulled = np.maximum(s.tension, 0.0)
        return pulled * np.expm1(self.mu * s.wrap * turning(s.theta_d))


@dataclass(frozen=True)
class RouteFriction(Law):
    """Cables that rub on the pulleys of their route, by the way in which a cable slides over each, within `width` (m/s).

    The cable gives at the motor's end: motors feel what stretches it, spans pull with what the pulleys before them leave.
    """

    mu: Array
    width: float

    def joint(self, s: Snapshot) -> Array:
        left = np.exp(-np.cumsum(self.mu * self._wraps(s) * np.tanh(self._sliding(s) / self.width), axis=0))
        return np.einsum("imb,imb,mb->ib", s.Z, left - 1, np.maximum(s.tension, 0.0))

    def joint_damping(self, s: Snapshot) -> Array:
        steep = self.mu * self._wraps(s) / self.width * (1 - np.tanh(self._sliding(s) / self.width) ** 2)
        joints = np.arange(len(s.Z))
        before_both = np.cumsum(steep, axis=0)[np.minimum(joints[:, None], joints)]
        return np.einsum("imb,kmb,ikmb,mb->ikb", s.Z, s.Z, before_both, np.maximum(s.tension, 0.0))

    def _sliding(self, s: Snapshot) -> Array:
        """(N, M, B), m/s, towards the drum: what the spans from there on give."""
        return np.cumsum((s.Z * s.alpha_d[:, None])[::-1], axis=0)[::-1]

    def _wraps(self, s: Snapshot) -> Array:
        return s.wraps


@dataclass(frozen=True)
class HalvedRouteFriction(RouteFriction):
    """The same on an arm whose cables wind half of what they wind behind a span."""

    def _wraps(self, s: Snapshot) -> Array:
        return s.wraps_in_halves


@dataclass(frozen=True)
class Described(Law):
    """A number of the plant that is `factor` times what the drawing has, at one place."""

    field: str
    place: int
    factor: float

    def altered(self, plant: Plant) -> Plant:
        value = getattr(plant, self.field).copy()
        value[self.place] *= self.factor
        return replace(plant, **{self.field: value})


@dataclass(frozen=True)
class ActuatorGain(Law):
    """Motors that pull by `share` (each) of their command more than they are told."""

    share: Array

    def motor(self, s: Snapshot) -> Array:
        return -self.share * s.f


@dataclass(frozen=True)
class ActuatorOffset(Law):
    """Motors that pull by a constant `force` (N each) more than they are told."""

    force: Array

    def motor(self, s: Snapshot) -> Array:
        return -self.force + 0 * s.theta


@dataclass(frozen=True)
class ActuatorLag(Law):
    """Motors whose force follows the command by a first order of `time` (s)."""

    time: float

    def memory_rows(self, plant: Plant) -> int:
        return plant.M

    def motor(self, s: Snapshot) -> Array:
        return s.f - s.memory

    def memory_d(self, s: Snapshot) -> Array:
        return (s.f - s.memory) / self.time


@dataclass(frozen=True)
class Creep(Law):
    """A Zener element beside each cable: a share of its stiffness that relaxes over `time` (s)."""

    share: float
    time: float

    def memory_rows(self, plant: Plant) -> int:
        return plant.M

    def tension(self, s: Snapshot) -> Array:
        return self.share * s.stiffness * (s.x - s.memory)

    def memory_d(self, s: Snapshot) -> Array:
        return (s.x - s.memory) / self.time


@dataclass(frozen=True)
class Hysteresis(Law):
    """Strands that slide within each cable: up to `force` (N), reached over `width` (m), by Dahl's law."""

    force: float
    width: float

    def memory_rows(self, plant: Plant) -> int:
        return plant.M

    def tension(self, s: Snapshot) -> Array:
        return self.force * s.memory

    def memory_d(self, s: Snapshot) -> Array:
        return (s.x_d - np.abs(s.x_d) * s.memory) / self.width


@dataclass(frozen=True)
class Gathered:
    """A law of some columns of a batch, and where its states stand among those of all laws."""

    law: Law
    columns: slice | np.ndarray
    rows: slice


def gathered(laws: Sequence[Sequence[Law]], plants: Sequence[Plant]) -> list[Gathered]:
    """laws[column]: the laws of each arm in the batch. The n-th law of a kind in one arm is gathered with the n-th in others."""
    groups: dict[tuple[type[Law], int], list[int]] = {}
    chosen: dict[tuple[type[Law], int], list[Law]] = {}
    for column, own in enumerate(laws):
        seen: dict[type[Law], int] = {}
        for law in own:
            key = (type(law), seen.get(type(law), 0))
            seen[type(law)] = key[1] + 1
            groups.setdefault(key, []).append(column)
            chosen.setdefault(key, []).append(law)
    out, row = [], 0
    for key, columns in groups.items():
        rows = chosen[key][0].memory_rows(plants[columns[0]])
        out.append(Gathered(type(chosen[key][0]).side_by_side(chosen[key]), _places(columns), slice(row, row + rows)))
        row += rows
    return out


def _places(columns: Sequence[int]) -> slice | np.ndarray:
    """Ascending columns of an array: neighbours are looked at where they are, others are copied each time."""
    first, end = columns[0], columns[-1] + 1
    return slice(first, end) if end - first == len(columns) else np.array(columns)
