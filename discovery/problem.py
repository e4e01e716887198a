"""What a law is looked for in: a residual, what is fitted beside it, and what it may follow, all whitened and in blocks of time."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from discovery.fine_basis import FineBasis, Function
from discovery.form import Constants, Form, Kind, forms_of

Array = NDArray[np.float64]
Index = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Candidate:
    """A variable in the equation where a law of it would act."""

    where: str
    """place, as `motor 3`, or `all`; nothing where there is one only"""
    follows: tuple[str, ...]
    """names of the variables"""
    unit: str
    """of the variable"""
    kind: Kind
    basis: FineBasis
    target_unit: str = "1"
    places: int = 1
    """that each have amounts of their own, under inner constants that they share"""
    factor: str = ""
    """what multiplies the function, in words: `sign(motor_speed)`, `tension`"""
    detail: str = ""
    """what else tells it from others with the same variables: the equation in which it acts"""

    def is_sibling(self, other: "Candidate") -> bool:
        """Whether they differ by their places at most."""
        return (self.detail, self.follows, self.factor) == (other.detail, other.follows, other.factor)

    @property
    def forms(self) -> tuple[Form, ...]:
        """The forms that the function may have."""
        return tuple(form for form in forms_of(self.kind) if self.places == 1 or not form.of_one_place)

    @property
    def variable(self) -> str:
        """What the function is of; products are one variable."""
        return (
            " * ".join(name for name in self.follows if self.factor not in (name, f"sign({name})")) or self.follows[0]
        )

    def expanded(self, coefficients: Array) -> Array:
        """Coefficients (..., K, k) of one place for all, each with its own amounts: (..., K places, k places)."""
        *leading, rows, columns = coefficients.shape
        out = np.zeros((*leading, rows, self.places, columns, self.places))
        for place in range(self.places):
            out[..., place, :, place] = coefficients
        return out.reshape(*leading, rows * self.places, columns * self.places)


class Problem:
    """Rows are whitened: noise of the target is of one size and not correlated, nearly."""

    least_gain: float = 0.0
    """what a law takes from the loss at least"""

    @cached_property
    def target(self) -> Array:
        """The residual, (rows,)."""
        raise NotImplementedError

    @cached_property
    def base(self) -> Array:
        """Columns that are fitted beside any law, (rows, P)."""
        raise NotImplementedError

    @cached_property
    def precision(self) -> Array:
        """Precision of what is known beforehand of the base columns' numbers about zero, (P,)."""
        raise NotImplementedError

    @cached_property
    def blocks(self) -> Index:
        """The block of time of each row, counted from 0, (rows,)."""
        raise NotImplementedError

    @cached_property
    def equation(self) -> Index:
        """The equation of each row, counted from 0, (rows,)."""
        return np.zeros(len(self.target), dtype=np.intp)

    def noise(self, numbers: Array) -> Array:
        """Energy of noise in each equation with the base columns' numbers (P,), over that without them, (C,), at most 1.

        Columns may hold the target's noise themselves: what halves all forces halves noise too, and all that is wrong.
        What makes it louder pays for that in the loss.
        """
        return np.ones(1)

    def allows(self, candidate: Candidate, form: Form, constants: Constants, amounts: Array) -> bool:
        """Whether a law with these amounts (k places,) may be one: some are what the target is made of, not what is wrong."""
        return True

    @cached_property
    def candidates(self) -> tuple[Candidate, ...]:
        """What may be followed; behind one of several places each of these by itself, in their order, with the same knots."""
        raise NotImplementedError

    def columns(self, candidate: Candidate, function: Function) -> Array:
        """What a unit of each amount does to the target, (rows, k places): k columns of the function, each for every place."""
        raise NotImplementedError
