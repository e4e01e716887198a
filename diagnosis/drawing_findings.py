"""What the recordings say about the drawing: numbers that have a tolerance, where they come out, and how surely."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from diagnosis.cause_parameters import SCALE_SIGMA
from diagnosis.fit_stage import FitStage

TELLING_SHARE = 0.7
"""of its tolerance: a number's sigma up to which the recordings say something of it (docs/thresholds.md)"""

FAR_TOLERANCES = 3.0
"""from which on a number is spoken of where nothing is named (docs/thresholds.md)"""


@dataclass(frozen=True)
class DrawingFinding:
    """A number of neck.yaml, or the turn of a bar's markers: by how much the arm's differs, as a share of itself or in rad."""

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
    def tolerances(self) -> float:
        """How many of them it is off."""
        return abs(self.value) / self.tolerance

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
    known = [(n.name, n.kind, n.where, n.sigma, n.unit) for n in nuisances.drawing]
    if nuisances.zero_sigma > 0:
        bars = range(stage.hypothesis.arm.N + 1)
        known += [(f"markers of bar {i}", "marker_angle", f"bar {i}", nuisances.zero_sigma, "rad") for i in bars]
    found = [
        DrawingFinding(
            name=name,
            kind=kind,
            where=where,
            value=tolerance * float(already + x),
            sigma=_sigma(stage.widening * tolerance * float(s), unit),
            unit=unit,
            tolerance=tolerance,
        )
        for (name, kind, where, tolerance, unit), x, s, already in zip(
            known, numbers, sigma, nuisances.departures, strict=False
        )
    ]
    found = [f for f in found if f.sigma < TELLING_SHARE * f.tolerance]
    return tuple(sorted(found, key=lambda f: -f.tolerances))


def furthest_in_words(found: Sequence[DrawingFinding]) -> str:
    """Of findings, what is furthest off the drawing, where that is by more than some tolerances; else nothing."""
    if not found or found[0].tolerances < FAR_TOLERANCES:
        return ""
    return f"{found[0].words}, {found[0].tolerances:.1f} tolerances off the drawing"


def _sigma(sigma: float, unit: str) -> float:
    """With the arm's size as a whole, which hardly anything tells."""
    return sigma if unit == "rad" else (sigma**2 + SCALE_SIGMA**2) ** 0.5
