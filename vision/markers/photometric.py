"""Corners of markers from all of their grey levels: the template of each marker fitted to the picture.

Where the fit does not succeed, the corners are those of the square's edges; without these there is no measurement.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.markers.edge_refinement import refine_by_edges
from vision.markers.photometric_model import BLUR_VARIANCE, INK_BLEED, LIGHT, UNKNOWN_LIGHT, WHITE
from vision.markers.photometric_solver import MIN_CONTRAST, PhotometricFit, fit_templates
from vision.markers.template import Optics

Array = NDArray[np.float64]

MIN_SIDE_PX = 8.0
"""px: side of a marker below which it is not fitted (docs/thresholds.md)"""
MAX_ERROR_SHARE = 0.25
"""residual scale over contrast, above which the picture does not show this marker (docs/thresholds.md)"""
MIN_WEIGHT = 0.4
"""mean weight of the pixels, below which the fit is not trusted (docs/thresholds.md)"""
MIN_SHARE_INSIDE = 0.5
"""share of the marker within the picture, below which the fit is not trusted (docs/thresholds.md)"""
BLURRED_PX = 1.5
"""px of motion during the exposure, from which on a marker counts as blurred (docs/thresholds.md)"""
EDGE_SD_PX = 0.15
"""px: standard deviation of corners by the square's edges, where the grey levels could not be fitted (docs/thresholds.md)"""
MAX_CLEAR_LOSS = 0.2
"""share of a marker that may be hidden, or clipped, where it is to show the optics"""
NEXT_CORNER = [1, 2, 3, 0]


@dataclass(frozen=True)
class MarkerStart:
    """Where a marker's fit starts."""

    corners: Array
    """(4, 2), px, in OpenCV's order, right to half a cell"""
    cells: NDArray[np.bool_]
    """(n, n), True is black, as `marker_cells` gives them"""
    motion: Array
    """(4, 2), px: motion of each corner during the exposure; `corners` are those in its middle. The mean of the four blurs"""
    light: Array | None = None
    """(6,), grey levels, as in `MarkerFit`, if it is known"""


@dataclass(frozen=True)
class MarkerFit:
    """A marker's corners with their covariance, and what was estimated beside them."""

    corners: Array
    """(4, 2), px; NaN where neither grey levels nor edges tell them"""
    covariance: Array
    """(8, 8), px^2, of x1, y1, x2, ...; NaN where there are no corners"""
    rms: float
    """of the weighted residual, grey levels"""
    contrast: float
    """between black and white, grey levels"""
    light: Array
    """(6,), grey levels: black's coefficients of 1, u and v in marker coordinates, then those of white less black"""
    sigma: float
    """standard deviation of the lens' blur, px, as this marker shows it"""
    bleed: float
    """ink bleed, px, as this marker shows it"""
    optics_sd: Array
    """(2,), px: standard deviations of sigma and bleed; the optics that were passed in are part of the estimate"""
    hidden: float
    """share of the pixels' weight that robust weighting took away"""
    clipped: float
    """share of the pixels that are black or white to the limit"""
    blurred: bool
    """whether it moved by more than BLURRED_PX during the exposure"""
    fell_back: bool
    """whether the grey levels could not be fitted, so that the corners are those of the edges"""

    @property
    def is_clear(self) -> bool:
        """Whether the marker was fitted, sharp, and nearly whole, so that it shows the optics."""
        return not (self.fell_back or self.blurred) and self.hidden < MAX_CLEAR_LOSS and self.clipped < MAX_CLEAR_LOSS


def fit_markers(grey: NDArray[np.uint8], starts: Sequence[MarkerStart], optics: Optics) -> list[MarkerFit]:
    """Markers of one picture, (height, width) uint8; all are fitted side by side."""
    if not starts:
        return []
    squares = np.flatnonzero(_are_squares(np.stack([start.corners for start in starts]))).tolist()
    fits: dict[int, MarkerFit] = {}
    if squares:
        fitted = [starts[k] for k in squares]
        fit = fit_templates(
            grey,
            [start.cells for start in fitted],
            np.stack([start.corners for start in fitted]).astype(float),
            np.stack([start.motion for start in fitted]).astype(float),
            np.stack([UNKNOWN_LIGHT if start.light is None else start.light for start in fitted]).astype(float),
            optics,
        )
        results = _results(fit, fitted, optics)
        fits = {k: result for k, result, valid in zip(squares, results, _valid(fit, fitted), strict=True) if valid}
    return [fits[k] if k in fits else _fallback(grey, start, optics) for k, start in enumerate(starts)]


def _are_squares(corners: Array) -> NDArray[np.bool_]:
    """Which of the corners (M, 4, 2), px, are finite and clockwise, with sides of MIN_SIDE_PX or so."""
    side = corners[:, NEXT_CORNER] - corners
    following = side[:, NEXT_CORNER]
    cross = side[..., 0] * following[..., 1] - side[..., 1] * following[..., 0]
    return np.all(cross > MIN_SIDE_PX**2 / 2, axis=1)


def _valid(fit: PhotometricFit, starts: Sequence[MarkerStart]) -> NDArray[np.bool_]:
    """Which fits are trusted, (M,)."""
    begun, motion = np.stack([s.corners for s in starts]), np.stack([s.motion for s in starts])
    side = begun[:, NEXT_CORNER] - begun
    cell = np.sqrt((side**2).sum(axis=2)).mean(axis=1) / [len(s.cells) for s in starts]
    reach = cell + np.abs(motion).max(axis=(1, 2)) / 2
    contrast = fit.solution[:, WHITE]
    return np.asarray(
        np.isfinite(fit.covariance).all(axis=(1, 2))
        & (np.diagonal(fit.covariance, axis1=1, axis2=2) > 0).all(axis=1)
        & fit.converged
        & (np.abs(fit.corners - begun).max(axis=(1, 2)) < reach)
        & (contrast > MIN_CONTRAST)
        & (fit.scale < MAX_ERROR_SHARE * contrast)
        & (fit.weight > MIN_WEIGHT)
        & (fit.pixels.share_inside > MIN_SHARE_INSIDE)
    )


def _results(fit: PhotometricFit, starts: Sequence[MarkerStart], optics: Optics) -> list[MarkerFit]:
    """A record of each marker's fit."""
    variance = optics.sigma**2 + fit.pixels.excess_variance + fit.solution[:, BLUR_VARIANCE]
    sigma = np.sqrt(np.maximum(variance, 0.01))
    optics_sd = fit.optics_sd / np.column_stack([2 * sigma, np.ones(len(sigma))])
    hidden = np.clip(1 - fit.weight, 0, 1)
    return [
        MarkerFit(
            corners=fit.corners[k],
            covariance=fit.covariance[k],
            rms=float(fit.rms[k]),
            contrast=float(fit.solution[k, WHITE]),
            light=fit.solution[k, LIGHT],
            sigma=float(sigma[k]),
            bleed=optics.bleed + float(fit.solution[k, INK_BLEED]),
            optics_sd=optics_sd[k],
            hidden=float(hidden[k]),
            clipped=float(fit.pixels.clipped_share[k]),
            blurred=_smear_px(start) > BLURRED_PX,
            fell_back=False,
        )
        for k, start in enumerate(starts)
    ]


def _smear_px(start: MarkerStart) -> float:
    """Motion of the fastest corner during the exposure, px."""
    return float(np.sqrt((start.motion**2).sum(axis=1).max()))


def _fallback(grey: NDArray[np.uint8], start: MarkerStart, optics: Optics) -> MarkerFit:
    """The corners by the edges of the square."""
    corners, smear = np.full((4, 2), np.nan), _smear_px(start)
    if _are_squares(start.corners[None])[0]:
        corners = refine_by_edges(grey, start.corners[None], len(start.cells))[0]
    sd = np.hypot(EDGE_SD_PX, smear / np.sqrt(12)) if np.isfinite(corners).all() else np.nan
    return MarkerFit(
        corners=corners,
        covariance=sd**2 * np.eye(8),
        rms=float("nan"),
        contrast=float("nan"),
        light=UNKNOWN_LIGHT,
        sigma=optics.sigma,
        bleed=optics.bleed,
        optics_sd=np.array([optics.sigma_sd, optics.bleed_sd]),
        hidden=float("nan"),
        clipped=float("nan"),
        blurred=smear > BLURRED_PX,
        fell_back=True,
    )
