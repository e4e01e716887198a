"""Where each marker sits on its bar, as the motion of the linkage shows it.

Seen from bar i-1, the middle of bar i moves on d(alpha) (-sin(alpha/2), cos(alpha/2)), with d even in alpha: enough motion
tells the bar's middle and direction from the marker's, on the base bar too. What the motion does not determine keeps the
value of neck.yaml, with the prior's standard deviation.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechanism.description import Neck, markers_of
from vision.linkage.scene import PLACEMENT
from vision.linkage.shared_fit import PlacementPrior, SharedFit

Array = NDArray[np.float64]

_DEPTH = 3
"""of the numbers of a marker's placement"""
DETERMINED_SHARE = 0.25
"""share of the prior's standard deviation below which a number counts as determined (docs/thresholds.md)"""
PARTLY_DETERMINED_SHARE = 0.5
"""share of the prior's standard deviation below which a number counts as partly determined (docs/thresholds.md)"""


@dataclass(frozen=True)
class PlacedNumber:
    """One estimated number: the place or angle of a marker on its bar, or a length of a mechanism."""

    name: str
    """x, y, angle, depth; L, b"""
    where: str
    """`marker 3 on bar 1`, `mechanism 2`"""
    value: float
    nominal: float
    """as in neck.yaml"""
    sigma: float
    prior_sigma: float
    unit: str

    @property
    def determined(self) -> bool:
        """Whether the recording determines it rather than neck.yaml."""
        return self.sigma < DETERMINED_SHARE * self.prior_sigma

    @property
    def word(self) -> str:
        """How well it is determined, in words."""
        if self.determined:
            return "determined"
        if self.sigma < PARTLY_DETERMINED_SHARE * self.prior_sigma:
            return "partly determined: leans on neck.yaml"
        return "not determined by this recording: as in neck.yaml"

    def as_json(self) -> dict[str, Any]:
        """The number as plain values for JSON."""
        names = ("name", "where", "value", "nominal", "sigma", "prior_sigma", "unit")
        return {name: getattr(self, name) for name in names} | {"determined": self.determined, "word": self.word}


@dataclass(frozen=True)
class MarkerPlacement:
    """All estimated numbers, and the arm corrected by them."""

    numbers: tuple[PlacedNumber, ...]
    covariance: Array
    """of the numbers, (len(numbers), len(numbers))"""
    neck: Neck
    """the description with the estimated placement (and lengths)"""


def describe_depth(neck: Neck, fit: SharedFit) -> tuple[PlacedNumber, ...]:
    """How far each marker lies before the arm's plane, as a fit has it.

    What all have in common the camera's distance may as well explain. Where no depth was measured the arm's plane is therefore
    the mean of theirs."""
    markers = markers_of(neck, "neck.yaml")
    depth, count = fit.shared.placement[:, _DEPTH], len(markers.on_bars)
    rows = 6 + _DEPTH + PLACEMENT * np.arange(count)
    covariance = fit.total_covariance[np.ix_(rows, rows)]
    if all(m.depth is None for m in markers.on_bars):
        depth, from_mean = depth - depth.mean(), np.eye(count) - 1 / count
        covariance = from_mean @ covariance @ from_mean
    sigma = np.sqrt(np.diag(covariance))
    return tuple(
        PlacedNumber(
            name="depth",
            where=f"marker {m.id} on {m.place}",
            value=float(depth[k]),
            nominal=m.depth_known[0],
            sigma=float(sigma[k]),
            prior_sigma=m.depth_known[1],
            unit="m",
        )
        for k, m in enumerate(markers.on_bars)
    )


def describe_placement(neck: Neck, fit: SharedFit, prior: PlacementPrior) -> MarkerPlacement:
    """The placement of a fit that estimated it, number by number."""
    markers = markers_of(neck, "neck.yaml")
    numbers, rows = [], []
    sigma = np.sqrt(np.diag(fit.total_covariance))
    for k, m in enumerate(markers.on_bars):
        nominal = (*m.at, m.angle)
        prior_sigma = (prior.at_sigma, prior.at_sigma, prior.angle_sigma)
        for j, (name, unit) in enumerate((("x", "m"), ("y", "m"), ("angle", "rad"))):
            row = 6 + PLACEMENT * k + j
            rows.append(row)
            numbers.append(
                PlacedNumber(
                    name=name,
                    where=f"marker {m.id} on {m.place}",
                    value=float(fit.shared.placement[k, j]),
                    nominal=nominal[j],
                    sigma=float(sigma[row]),
                    prior_sigma=prior_sigma[j],
                    unit=unit,
                )
            )
    if prior.length_sigma is not None:
        start = 6 + PLACEMENT * len(markers.on_bars)
        for j, name in enumerate(("L", "b")):
            for i, m in enumerate(neck.mechanisms):
                row = start + j * neck.N + i
                rows.append(row)
                numbers.append(
                    PlacedNumber(
                        name=name,
                        where=f"mechanism {i + 1}",
                        value=float(fit.shared.lengths[j, i]),
                        nominal=float(getattr(m, name)),
                        sigma=float(sigma[row]),
                        prior_sigma=prior.length_sigma,
                        unit="m",
                    )
                )
    covariance = fit.total_covariance[np.ix_(rows, rows)]
    return MarkerPlacement(tuple(numbers), covariance, _corrected(neck, fit, prior))


def _corrected(neck: Neck, fit: SharedFit, prior: PlacementPrior) -> Neck:
    """The description with the markers (and lengths) as the fit has them."""
    markers = markers_of(neck, "neck.yaml")
    on_bars = tuple(
        m.model_copy(update={"at": (float(x), float(y)), "angle": float(np.angle(np.exp(1j * angle)))})
        for m, (x, y, angle) in zip(markers.on_bars, fit.shared.placement[:, :3], strict=True)
    )
    changed: dict[str, Any] = {"markers": markers.model_copy(update={"on_bars": on_bars})}
    if prior.length_sigma is not None:
        changed["mechanisms"] = tuple(
            m.model_copy(update={"L": float(L), "b": float(b)})
            for m, L, b in zip(neck.mechanisms, *fit.shared.lengths, strict=True)
        )
    return neck.model_copy(update=changed)
