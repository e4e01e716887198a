"""What the recordings say about the drawing: numbers that have a tolerance, where they come out, and how surely."""

from dataclasses import dataclass
from typing import Any

from diagnosis.cause_parameters import SCALE_SIGMA
from diagnosis.fit_stage import FitStage

TELLING_SHARE = 0.7
"""of its tolerance: a number's sigma up to which the recordings say something of it (docs/thresholds.md)"""


@dataclass(frozen=True)
class DrawingFinding:
    """A number of neck.yaml: by how much the arm's differs, as a share of itself or in rad."""

    name: str
    kind: str
    """its key in the tolerance"""
    where: str
    value: float
    sigma: float
    unit: str
    tolerance: float
    """what it is known to beforehand, one sigma"""

    @property
    def words(self) -> str:
        """For a person."""
        if self.unit == "rad":
            return f"{self.name}: {1e3 * self.value:+.1f} +- {1e3 * self.sigma:.1f} mrad"
        return f"{self.name}: {100 * self.value:+.2f} +- {100 * self.sigma:.2f} %"

    def as_json(self) -> dict[str, Any]:
        """For the record."""
        return {
            "number": self.name,
            "kind": self.kind,
            "where": self.where,
            "value": self.value,
            "sigma": self.sigma,
            "unit": self.unit,
            "tolerance": self.tolerance,
        }


def drawing_findings(stage: FitStage) -> tuple[DrawingFinding, ...]:
    """Of every number that the recordings tell better than its tolerance does, what is furthest beyond that first.

    What is left above noise widens each sigma, as of causes' numbers: what nobody knows may stand in for the drawing.
    """
    comparison, nuisances = stage.comparison, stage.comparison.nuisances
    numbers, sigma = stage.fit.numbers[comparison.base_count :], stage.sigma[comparison.base_count :]
    found = [
        DrawingFinding(
            name=n.name,
            kind=n.kind,
            where=n.where,
            value=n.sigma * float(already + x),
            sigma=_sigma(stage.widening * n.sigma * float(s), n.unit),
            unit=n.unit,
            tolerance=n.sigma,
        )
        for n, x, s, already in zip(nuisances.drawing, numbers, sigma, nuisances.departures, strict=False)
    ]
    found = [f for f in found if f.sigma < TELLING_SHARE * f.tolerance]
    return tuple(sorted(found, key=lambda f: -abs(f.value) / f.tolerance))


def _sigma(sigma: float, unit: str) -> float:
    """With the arm's size as a whole, which hardly anything tells."""
    return sigma if unit == "rad" else (sigma**2 + SCALE_SIGMA**2) ** 0.5
