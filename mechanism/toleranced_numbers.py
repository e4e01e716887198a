"""Numbers of a description that are known to a tolerance only, and the description with them moved."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from pydantic import BaseModel

from mechanism.description import Mechanism, Neck, Spring

Description = TypeVar("Description", bound=BaseModel)


@dataclass(frozen=True)
class TolerancedNumber:
    """One number of neck.yaml."""

    name: str
    """what a person reads: `mass of the top bar 2`"""
    kind: str
    """its key in the arm's tolerance"""
    where: str
    """`mechanism 2`, `motor 1` or `base`"""
    sigma: float
    """relative to the number, rad of a tilt"""
    moved: Callable[[Neck, float], Neck]
    """the description with this one changed by an amount in units of `sigma`'s: a share of itself, rad of a tilt"""

    @property
    def unit(self) -> str:
        """Of an amount."""
        return "rad" if self.kind == "tilt" else "1"


_OF_MECHANISMS = (
    ("length", "L of mechanism {}", ("L",)),
    ("length", "b of mechanism {}", ("b",)),
    ("pulley", "pulleys of mechanism {}", ("r",)),
    ("mass", "mass of top bar {}", ("top", "mass")),
    ("mass", "mass of diagonals {}", ("diagonal", "mass")),
    ("inertia", "inertia of top bar {}", ("top", "inertia")),
    ("inertia", "inertia of diagonals {}", ("diagonal", "inertia")),
    ("stiffness", "spring {} left", ("springs", "stiffness")),
    ("stiffness", "spring {} right", ("springs", "right", "stiffness")),
    ("free_length", "free length of spring {} left", ("springs", "free_length")),
    ("free_length", "free length of spring {} right", ("springs", "right", "free_length")),
)
_OF_MOTORS = (("motor_inertia", "inertia of motor {}", ("Ia",)), ("drum", "drum {}", ("rd",)))


def toleranced_numbers(neck: Neck) -> tuple[TolerancedNumber, ...]:
    """All of an arm that have a tolerance, but for what angles are read with."""
    return tuple(_numbers(neck))


def moved(neck: Neck, numbers: Sequence[TolerancedNumber], amounts: Sequence[float]) -> Neck:
    """The description with numbers changed by amounts."""
    for number, amount in zip(numbers, amounts, strict=True):
        neck = number.moved(neck, float(amount))
    return neck


def _numbers(neck: Neck) -> Iterator[TolerancedNumber]:
    for group, place, count, fields in (
        ("mechanisms", "mechanism", neck.N, _OF_MECHANISMS),
        ("motors", "motor", neck.M, _OF_MOTORS),
    ):
        for kind, name, path in fields:
            for i in range(count):
                sigma = getattr(neck.tolerance, kind)
                yield TolerancedNumber(name.format(i + 1), kind, f"{place} {i + 1}", sigma, scaled(group, i, path))
    yield TolerancedNumber("tilt of the base", "tilt", "base", neck.tolerance.tilt, tilted)


def scaled(group: str, place: int, path: tuple[str, ...]) -> Callable[[Neck, float], Neck]:
    """What changes the number at a path in one of the `motors` or `mechanisms`, counted from 0, by a share of itself."""

    def moved(neck: Neck, share: float) -> Neck:
        parts = list(getattr(neck, group))
        if "springs" in path:
            parts[place] = with_springs_apart(parts[place])
        parts[place] = _with_factor(parts[place], path, 1 + share)
        return neck.model_copy(update={group: tuple(parts)})

    return moved


def with_springs_apart(mechanism: Mechanism) -> Mechanism:
    """A mechanism that has its right spring's numbers for themselves, as they are."""
    springs = mechanism.springs
    if springs.right is None:
        right = Spring(stiffness=springs.stiffness, free_length=springs.free_length)
        springs = springs.model_copy(update={"right": right})
    return mechanism.model_copy(update={"springs": springs})


def _with_factor(part: Description, path: tuple[str, ...], factor: float) -> Description:
    """A part of a description with the number at a path multiplied."""
    key, *rest = path
    value = getattr(part, key)
    changed = _with_factor(value, tuple(rest), factor) if rest else value * factor
    return part.model_copy(update={key: changed})


def tilted(neck: Neck, angle: float) -> Neck:
    """A base that leans counter-clockwise: gravity leans the other way in its frame."""
    g = complex(*neck.gravity) * np.exp(-1j * angle)
    return neck.model_copy(update={"gravity": (float(g.real), float(g.imag))})
