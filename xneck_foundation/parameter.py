"""A parameter as a person reads it: its value, unit and standard deviation, and whether the data determine it."""

from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Parameter:
    """A named number with its uncertainty; `index` counts cables or mechanisms from 1, None where there is one of a kind."""

    name: str
    index: int | None
    value: float
    unit: str
    sigma: float
    identified: bool

    @property
    def relative_sigma_percent(self) -> float:
        """100 sigma / |value|, as Fasquelle's tables print it; infinite at zero."""
        return float(100 * self.sigma / abs(self.value)) if self.value else float("inf")

    def as_json(self) -> dict[str, Any]:
        """The contract's record of a parameter; an infinite number becomes null."""
        relative = self.relative_sigma_percent
        return {
            "name": self.name,
            "index": self.index,
            "value": self.value,
            "unit": self.unit,
            "sigma": self.sigma if np.isfinite(self.sigma) else None,
            "relative_sigma_percent": relative if np.isfinite(relative) else None,
            "identified": self.identified,
        }
