"""What is believed of an arm and of how it was recorded, while causes are sought."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.dataset import DataSet
from identification.series import Series
from mechanism.arm import Arm, arm_of
from mechanism.description import Neck
from mechanism.laws import LAWS

Array = NDArray[np.float64]

BASE = ("dry_friction", "linear_cable")
"""the laws of the simulation that is put to the test"""


@dataclass(frozen=True)
class Hypothesis:
    """A description, laws beyond the base with their numbers, and errors of what was read."""

    neck: Neck
    laws: tuple[str, ...]
    values: Mapping[str, Array]
    """of these laws' terms, by name: (M,), (N,) or (1,)"""
    misread: Array
    """what angles were read too large, (N,), rad"""
    late: float = 0.0
    """s, by which frames show what was done later than their stamps say"""

    @property
    def arm(self) -> Arm:
        """The description's numbers."""
        return arm_of(self.neck)

    def with_law(self, name: str, values: Mapping[str, Array]) -> "Hypothesis":
        """The same with a law's numbers set."""
        laws = self.laws if name in self.laws else (*self.laws, name)
        return replace(self, laws=laws, values={**self.values, **values})

    def read(self, data: DataSet) -> DataSet:
        """A recording as it reads with these errors put right."""
        s, columns = data.state, dict(data.state.columns)
        for i, wrong in enumerate(self.misread, start=1):
            alpha, alpha_d, alpha_dd = (s.columns[f"alpha{i}{suffix}"] for suffix in ("", "_d", "_dd"))
            columns[f"alpha{i}"] = alpha - wrong + self.late * alpha_d
            columns[f"alpha{i}_d"] = alpha_d + self.late * alpha_dd
            if f"vision{i}" in columns:
                columns[f"vision{i}"] = s.columns[f"vision{i}"] - wrong + self.late * alpha_d
                columns[f"vision{i}_d"] = s.columns[f"vision{i}_d"] + self.late * alpha_dd
        return replace(data, neck=self.neck, state=Series(s.time, columns))


def as_described(neck: Neck) -> Hypothesis:
    """Nothing beyond the base model."""
    return Hypothesis(neck, (), {}, np.zeros(neck.N))


def at_rest(arm: Arm, law: str) -> dict[str, Array]:
    """A law's terms where it does nothing: amounts zero, shapes at their size."""
    counts = {"cable": arm.M, "joint": arm.N, "arm": 1}
    own = [term for term in LAWS[law].terms if term.name not in _shared()]
    return {t.name: np.full(counts[t.of], t.size if t.low > 0 else 0.0) for t in own}


def _shared() -> set[str]:
    return {term.name for name in BASE for term in LAWS[name].terms}
