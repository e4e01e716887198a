"""A law that was found: where it acts, what it follows, its form and its numbers, in words and as an equation."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discovery.form import Form
from discovery.problem import Candidate
from xneck_foundation.parameter import Parameter

Array = NDArray[np.float64]

_KNOWN_SIGMAS = 3.0
"""of a number from zero, beyond which it is identified"""


@dataclass(frozen=True, eq=False)
class FoundLaw:
    """One law."""

    candidate: Candidate
    form: Form
    constants: Mapping[str, float]
    """inner constants"""
    amounts: Array
    """(k places,), each amount over its places"""
    covariance: Array
    """of the amounts, then of the inner constants that are fitted"""
    alike: tuple["FoundLaw", ...] = ()
    """others that explain as well as far as these data tell, the likeliest first"""
    share: float = 0.0
    """of the loss before it"""

    @property
    def free_constants(self) -> tuple[str, ...]:
        """Names of the inner constants that are fitted."""
        return tuple(name for name in self.constants if name not in self.form.fixed)

    def function(self, x: Array) -> Array:
        """Columns of values (T,), (T, k)."""
        return self.form.columns(x, self.constants)

    def curve(self, x: Array, place: int = 0) -> tuple[Array, Array]:
        """Its value at values x (T,) of the variable, at a place counted from 0, and the standard deviation, (T,) each."""
        places = self.candidate.places
        columns = self.function(x)
        count = len(self.amounts)
        slopes = np.zeros((len(x), len(self.covariance)))
        slopes[:, np.arange(columns.shape[1]) * places + place] = columns
        amounts = self.amounts[place::places]
        for i, name in enumerate(self.free_constants):
            step = 1e-4 * max(abs(self.constants[name]), 1e-3)
            moved = self.form.columns(x, {**self.constants, name: self.constants[name] + step})
            slopes[:, count + i] = (moved - columns) @ amounts / step
        variance = np.einsum("ti,ij,tj->t", slopes, self.covariance, slopes)
        return columns @ amounts, np.sqrt(np.maximum(variance, 0.0))

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Amounts, then inner constants; index counts places from 1 where there are several."""
        c, places = self.candidate, self.candidate.places
        sigma = np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
        names = [(name, i + 1 if places > 1 else None) for name in self.form.amounts for i in range(places)]
        numbers = [(*at, float(v), float(s)) for at, v, s in zip(names, self.amounts, sigma, strict=False)]
        free = dict(zip(self.free_constants, sigma[len(self.amounts) :], strict=True))
        numbers += [(name, None, float(v), float(free.get(name, 0.0))) for name, v in self.constants.items()]
        return tuple(
            Parameter(
                name=name,
                index=index,
                value=value,
                unit=self.form.unit(name, c.target_unit, c.unit),
                sigma=s,
                identified=name in self.constants or abs(value) > _KNOWN_SIGMAS * s,
            )
            for name, index, value, s in numbers
        )

    @property
    def words(self) -> str:
        """One line."""
        c = self.candidate
        factor = f", times {c.factor}" if c.factor else ""
        place = ""
        if c.detail:  # `against the motors`: against all motors, or against motor 3
            place = (
                c.detail.replace(" the ", " all ") if c.where == "all" else f"{c.detail.split(' the ')[0]} {c.where}"
            )
            place += ": "
        return f"{place}{self.form.name} of {c.variable}{factor}"

    @property
    def equation(self) -> str:
        """The law with its numbers' names; x is the variable."""
        c = self.candidate
        inner = f"{c.factor} ({self.form.equation})" if c.factor else self.form.equation
        return f"{inner}, x = {c.variable}"

    def as_json(self) -> dict[str, Any]:
        """The contract's record, without a gain that only the whole can tell."""
        return {
            "where": self.candidate.where or "all",
            "follows": list(self.candidate.follows),
            "form": self.form.name,
            "words": self.words,
            "equation": self.equation,
            "terms": [p.as_json() for p in self.parameters],
            "explains": self.share,
            "indistinguishable_from": [law.words for law in self.alike],
        }
