"""Where each marker really sits on its bar, as the motion of the linkage shows it.

Seen from bar i-1, the middle of bar i moves on d(alpha) (-sin(alpha/2), cos(alpha/2)), with d even in alpha: enough motion
tells the bar's own middle and direction from the marker's, on the base bar too. What the motion does not tell stays
where the person put it, with the prior's standard deviation.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibration.camera import Camera
from mechanism.description import Neck, markers_of
from vision.linkage.shared_fit import PlacementPrior, SharedFit, fit_shared

Array = NDArray[np.float64]

DETERMINED = 0.25
PARTLY = 0.5
"""shares of the prior's standard deviation below which a number is determined, or partly so"""


@dataclass(frozen=True)
class PlacedNumber:
    """One estimated number of the arm: of a marker on its bar, or a length."""

    name: str
    """x, y, angle; L, b"""
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
        """Whether the recording tells it, rather than neck.yaml."""
        return self.sigma < DETERMINED * self.prior_sigma

    @property
    def word(self) -> str:
        """For a person to read."""
        if self.determined:
            return "determined"
        if self.sigma < PARTLY * self.prior_sigma:
            return "partly determined: leans on neck.yaml"
        return "not determined by this recording: as in neck.yaml"

    def as_json(self) -> dict[str, Any]:
        """Plain values."""
        names = ("name", "where", "value", "nominal", "sigma", "prior_sigma", "unit")
        return {name: getattr(self, name) for name in names} | {"determined": self.determined, "word": self.word}


@dataclass(frozen=True)
class Placement:
    """All of them, and the arm as they correct it."""

    numbers: tuple[PlacedNumber, ...]
    covariance: Array
    """(len(numbers), len(numbers))"""
    neck: Neck
    """with the markers (and lengths) where they were found; `neck_text` of the mechanism writes it out"""

    @property
    def undetermined(self) -> tuple[PlacedNumber, ...]:
        """Those that the recording does not tell."""
        return tuple(n for n in self.numbers if not n.determined)


def estimate_placement(
    neck: Neck,
    camera: Camera,
    corners: Array,
    where: str,
    covariance: Array | None = None,
    prior: PlacementPrior | None = None,
) -> Placement:
    """Placement of every marker from corners (F, markers, 4, 2), px, NaN where not found, of a recording with motion.

    covariance: (F, markers, 8, 8), px^2. Pose, its drift and all angles are estimated with it.
    """
    prior = prior or PlacementPrior()
    return placement_of(neck, fit_shared(neck, camera, corners, where, covariance, placement=prior), prior)


def placement_of(neck: Neck, fit: SharedFit, prior: PlacementPrior) -> Placement:
    """The readable result of a fit that had the placement free."""
    markers = markers_of(neck, "neck.yaml")
    numbers, rows = [], []
    sigma = np.sqrt(np.diag(fit.whole_covariance))
    for k, m in enumerate(markers.on_bars):
        beforehand = ((*m.at, m.angle), (prior.at_sigma, prior.at_sigma, prior.angle_sigma))
        for j, (name, unit) in enumerate((("x", "m"), ("y", "m"), ("angle", "rad"))):
            row = 6 + 3 * k + j
            value = float(fit.shared.placement[k, j])
            place = f"marker {m.id} on {m.place}"
            numbers.append(
                PlacedNumber(name, place, value, beforehand[0][j], float(sigma[row]), beforehand[1][j], unit)
            )
            rows.append(row)
    if prior.length_sigma is not None:
        start = 6 + 3 * len(markers.on_bars)
        for j, name in enumerate(("L", "b")):
            for i, m in enumerate(neck.mechanisms):
                row = start + j * neck.N + i
                value, was = float(fit.shared.lengths[j, i]), float(getattr(m, name))
                place = f"mechanism {i + 1}"
                numbers.append(PlacedNumber(name, place, value, was, float(sigma[row]), prior.length_sigma, "m"))
                rows.append(row)
    return Placement(tuple(numbers), fit.whole_covariance[np.ix_(rows, rows)], _corrected(neck, fit, prior))


def _corrected(neck: Neck, fit: SharedFit, prior: PlacementPrior) -> Neck:
    markers = markers_of(neck, "neck.yaml")
    on_bars = tuple(
        m.model_copy(update={"at": (float(x), float(y)), "angle": float(np.angle(np.exp(1j * angle)))})
        for m, (x, y, angle) in zip(markers.on_bars, fit.shared.placement, strict=True)
    )
    changed: dict[str, Any] = {"markers": markers.model_copy(update={"on_bars": on_bars})}
    if prior.length_sigma is not None:
        changed["mechanisms"] = tuple(
            m.model_copy(update={"L": float(L), "b": float(b)})
            for m, L, b in zip(neck.mechanisms, *fit.shared.lengths, strict=True)
        )
    return neck.model_copy(update=changed)
