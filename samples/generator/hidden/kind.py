"""What an effect is: a world changed, and the truth about the change."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from samples.generator.hidden.arms import Arm
from samples.generator.laws import Friction
from samples.generator.prescribed import World
from samples.generator.taut_string import Array


@dataclass(frozen=True)
class Hidden:
    """One effect that a recording hides."""

    effect: str
    where: str
    """such as "cable 3", "motor 2", "mechanism 2", "bar 3", or "all\""""
    parameters: dict[str, float]
    """true values, SI; a number at the end of a name is that of the cable or motor"""


@dataclass(frozen=True)
class Draw:
    """What an effect is drawn from."""

    arm: Arm
    rng: np.random.Generator
    """the same for all recordings of an arm: places and sizes"""
    own: np.random.Generator
    """each recording's own: times at which something happens"""
    seconds: float
    """of the recording"""
    longest: float
    """of the arm's recordings, s"""
    size: float
    """1 is normal, 0 is no effect"""

    def one(self, count: int) -> int:
        """A place, from 0."""
        return int(self.rng.integers(count))

    def sized(self, low: float, high: float, shape: int | None = None) -> Array:
        """Sizes of normal range low..high times `size`, shape () or (shape,)."""
        return np.asarray(self.size * self.rng.uniform(low, high, shape))

    def sign(self) -> float:
        """-1 or 1."""
        return float(self.rng.choice([-1.0, 1.0]))


Kind = Callable[[World, Draw], tuple[World, Hidden]]


def numbered(**values: Array) -> dict[str, float]:
    """Arrays (M,) as name1 .. nameM."""
    return {f"{name}{j}": float(v) for name, array in values.items() for j, v in enumerate(array, 1)}


def rubbing(world: World, more: Friction) -> World:
    """The world with another force in its gears and cables."""
    known = world.friction
    return replace(world, friction=lambda at: known(at) + more(at))


def writing(world: World, change: Callable[[Array], Array]) -> World:
    """The world whose log says other forces."""
    known = world.written
    return replace(world, written=lambda force, step: change(known(force, step)))
