"""Selection of lens model and board shape: the simplest candidate that predicts held-out views as well as the best.

K-fold cross-validation over views: a view's held-out error is that of a camera and a board estimated without the view, with only
its pose fitted. Selected is the candidate with the fewest parameters whose errors exceed those of the best by no more than one
standard error (Breiman et al. 1984, of the difference, view by view).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calibration import board_shape, lens
from calibration.bundle_adjustment import BundleFit, BundleStart, fit_bundle, leave_out_groups, prediction_distances
from calibration.reprojection import huber_loss
from calibration.stacked_views import StackedViews

FOLDS = 10
"""groups of views at most (docs/thresholds.md)"""
_MAX_ITERATIONS = 20
"""of a candidate's fit: candidates start from one another and need three to six"""


@dataclass(frozen=True)
class ModelCandidate:
    """A lens model and a board shape with their prediction error."""

    lens: str  # of lens.LENS_MODELS
    board: str  # of board_shape.SHAPE_MODELS
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
    """The candidates, simplest first, and the fit of the selected one."""

    candidates: tuple[ModelCandidate, ...]
    fit: BundleFit

    @property
    def selected(self) -> ModelCandidate:
        """The selected candidate."""
        return next(candidate for candidate in self.candidates if candidate.chosen)

    def rivals(self) -> tuple[ModelCandidate, ...]:
        """Other candidates within one standard error of the best."""
        return tuple(c for c in self.candidates if not c.chosen and c.excess <= c.excess_error)


def select_model(
    views: StackedViews, fitted: BundleFit, noise: float
) -> tuple[ModelSelection, dict[tuple[str, str], BundleFit]]:
    """The selection among all candidates, and their fits by (lens, board).

    fitted: a fit of the default models, from which the candidates start; noise: of a corner's coordinate, px.
    """
    groups = view_folds(len(views.visible))
    fits: dict[tuple[str, str], BundleFit] = {}
    errors: dict[tuple[str, str], np.ndarray] = {}
    for lens_name, free in lens.LENS_MODELS.items():
        fixed = np.array([name not in free for name in lens.PARAMETER_NAMES])
        base = fitted
        for shape_name, model in board_shape.SHAPE_MODELS.items():
            # models are nested, so that none starts far from its optimum
            start = BundleStart(np.where(fixed, 0.0, base.parameters), base.poses, base.shape)
            fit = fit_bundle(views, start, free, model, noise, _MAX_ITERATIONS)
            fits[lens_name, shape_name] = fit
            errors[lens_name, shape_name] = held_out_distances(views, fit, groups)
            if shape_name == "rigid":
                base = fit
    return _select(views, fits, errors), fits


def view_folds(count: int) -> list[np.ndarray]:
    """Views in at most FOLDS groups of neighbours: pictures taken one after another are similar and are held out together."""
    return np.array_split(np.arange(count), min(FOLDS, count))


def held_out_distances(views: StackedViews, fitted: BundleFit, groups: Sequence[np.ndarray]) -> np.ndarray:
    """Distances of the corners from their prediction by a fit without their group of views, shape (n, c), px."""
    n = len(views.visible)
    parameters, points = np.empty((n, 9)), np.empty((n, *fitted.shape.nominal.shape))
    for group, (p, shape) in zip(groups, leave_out_groups(fitted, groups), strict=True):
        parameters[group], points[group] = p, shape.points
    return prediction_distances(views, parameters, points, fitted.poses, fitted.knee)


def root_mean_square(distances: np.ndarray, visible: np.ndarray) -> float:
    """Root mean square of distances (n, c) over the visible corners, px."""
    return float(np.sqrt(np.sum(distances**2) / np.sum(visible)))


def _select(
    views: StackedViews, fits: dict[tuple[str, str], BundleFit], errors: dict[tuple[str, str], np.ndarray]
) -> ModelSelection:
    """The simplest candidate within one standard error of the best; errors: held-out distances (n, c), px."""
    # logarithms, because one view at the edge of the picture would outweigh all others by its error
    knee = next(iter(fits.values())).knee
    size = {key: 0.5 * np.log(huber_loss(e, knee).sum(axis=1) / views.counts + 1e-18) for key, e in errors.items()}
    best = min(size, key=lambda key: float(np.mean(size[key])))
    difference = {key: value - size[best] for key, value in size.items()}
    excess = {key: float(np.mean(value)) for key, value in difference.items()}
    error = {key: float(np.std(value, ddof=1) / np.sqrt(len(value))) for key, value in difference.items()}
    order = sorted(fits, key=lambda key: (_parameter_count(fits[key]), excess[key]))
    selected = next(key for key in order if excess[key] <= error[key])
    candidates = tuple(
        ModelCandidate(
            lens=key[0],
            board=key[1],
            free=_parameter_count(fits[key]),
            fx=float(fits[key].parameters[0]),
            fy=float(fits[key].parameters[1]),
            rms_px=fits[key].rms,
            held_out_rms_px=root_mean_square(errors[key], views.visible),
            excess=excess[key],
            excess_error=error[key],
            chosen=key == selected,
        )
        for key in order
    )
    return ModelSelection(candidates, fits[selected])


def _parameter_count(fitted: BundleFit) -> int:
    """Number of free parameters, poses aside."""
    shape = fitted.shape
    return len(fitted.free) + len(shape.model.free) + (shape.offsets.size if shape.model.offsets else 0)
