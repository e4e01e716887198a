"""Which lens model and which board shape: the simplest that predicts views it has not seen as well as the best does.

K-fold cross-validation over views: a view's held-out error is what a camera and a board estimated without it leave when
only the view's pose is fitted. Of all candidates the one with the fewest parameters is taken whose errors exceed those of
the best by no more than one standard error (Breiman et al. 1984, of the difference, view by view).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calibration import board_shape, lens
from calibration.bundle_adjustment import BundleFit, fit_bundle, leave_out_groups, prediction_distances
from calibration.reprojection import huber_loss
from calibration.stacked_views import StackedViews

FOLDS = 10
_ITERATIONS = 20
"""candidates start from one another and need three to six"""


@dataclass(frozen=True)
class ModelCandidate:
    """A lens model and a board shape, and how well they predict."""

    lens: str  # of lens.MODELS
    board: str  # of board_shape.MODELS
    free: int  # number of free parameters, poses aside
    fx: float  # px
    fy: float  # px
    rms_px: float
    held_out_rms_px: float
    excess: float  # mean over views of the held-out error's logarithm less that of the best candidate
    excess_error: float  # standard error of the excess
    chosen: bool = False


@dataclass(frozen=True)
class ModelSelection:
    """The candidates, simplest first, and the chosen one's fit."""

    candidates: tuple[ModelCandidate, ...]
    fit: BundleFit

    @property
    def chosen(self) -> ModelCandidate:
        """The candidate taken."""
        return next(candidate for candidate in self.candidates if candidate.chosen)

    def rivals(self) -> tuple[ModelCandidate, ...]:
        """Others that predict as well, within one standard error of the best."""
        return tuple(c for c in self.candidates if not c.chosen and c.excess <= c.excess_error)


def select_model(sightings: StackedViews, fitted: BundleFit, noise: float) -> tuple[ModelSelection, dict[tuple[str, str], BundleFit]]:
    """Fit every candidate, starting from a fit of the default one, and take one; also all fits by (lens, board)."""
    groups = view_folds(len(sightings.seen))
    fits: dict[tuple[str, str], BundleFit] = {}
    errors: dict[tuple[str, str], np.ndarray] = {}
    for lens_name, free in lens.LENS_MODELS.items():
        fixed = np.array([name not in free for name in lens.PARAMETER_NAMES])
        start = fitted
        for shape_name, model in board_shape.SHAPE_MODELS.items():
            parameters = np.where(fixed, 0.0, start.parameters)
            # a distortion that was fixed at nothing so far starts there too, and fits are nested: none starts far off
            one = fit_bundle(sightings, parameters, start.poses, free, start.shape, model, noise, _ITERATIONS)
            fits[lens_name, shape_name] = one
            errors[lens_name, shape_name] = held_out_distances(sightings, one, groups)
            if shape_name == "rigid":
                start = one
    return _choice(sightings, fits, errors), fits


def view_folds(count: int) -> list[np.ndarray]:
    """Views in at most FOLDS groups of neighbours: pictures taken one after another are alike, and leave together."""
    return np.array_split(np.arange(count), min(FOLDS, count))


def held_out_distances(sightings: StackedViews, fitted: BundleFit, groups: Sequence[np.ndarray]) -> np.ndarray:
    """Distances of corners predicted by cameras and boards estimated without their group, shape (n, c), px."""
    n = len(sightings.seen)
    parameters, points = np.empty((n, 9)), np.empty((n, *fitted.shape.nominal.shape))
    for group, (p, shape) in zip(groups, leave_out_groups(fitted, groups), strict=True):
        parameters[group], points[group] = p, shape.points
    return prediction_distances(sightings, parameters, points, fitted.poses, fitted.knee)


def root_mean_square(distances: np.ndarray, seen: np.ndarray) -> float:
    """Over corners, px."""
    return float(np.sqrt(np.sum(distances**2) / np.sum(seen)))


def _choice(
    sightings: StackedViews, fits: dict[tuple[str, str], BundleFit], errors: dict[tuple[str, str], np.ndarray]
) -> ModelSelection:
    # logarithms, because one view at the edge of the picture would outweigh all others by its error
    knee = next(iter(fits.values())).knee
    size = {key: 0.5 * np.log(huber_loss(e, knee).sum(axis=1) / sightings.counts + 1e-18) for key, e in errors.items()}
    best = min(size, key=lambda key: float(np.mean(size[key])))
    away = {key: value - size[best] for key, value in size.items()}
    excess = {key: float(np.mean(value)) for key, value in away.items()}
    error = {key: float(np.std(value, ddof=1) / np.sqrt(len(value))) for key, value in away.items()}
    order = sorted(fits, key=lambda key: (_free(fits[key]), excess[key]))
    chosen = next(key for key in order if excess[key] <= error[key])
    candidates = tuple(
        ModelCandidate(
            *key,
            free=_free(fits[key]),
            fx=float(fits[key].parameters[0]),
            fy=float(fits[key].parameters[1]),
            rms_px=fits[key].rms,
            held_out_rms_px=root_mean_square(errors[key], sightings.seen),
            excess=excess[key],
            excess_error=error[key],
            chosen=key == chosen,
        )
        for key in order
    )
    return ModelSelection(candidates, fits[chosen])


def _free(fitted: BundleFit) -> int:
    shape = fitted.shape
    return len(fitted.free) + len(shape.model.free) + (shape.offsets.size if shape.model.offsets else 0)
