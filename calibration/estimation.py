"""Views of a board -> camera, its uncertainty, and a refusal where the views cannot tell.

Lens model and board shape are what cross-validation chooses. The reported sigma is the larger of two, of least squares and
of the jackknife that leaves out one view after another; what candidates differ by that predict as well adds to it. Corner
errors of one picture have causes in common (print, blur, board shape), so that least squares, which takes every corner for
independent, comes out two to three times too small on real sets.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from calibration import board_shape, lens
from calibration.board_poses import BoardPoses
from calibration.board_shape import BoardShape
from calibration.bundle_adjustment import (
    BundleFit,
    fit_bundle,
    fit_noise,
    fit_residuals,
    initial_estimate,
    leave_out_groups,
    prediction_distances,
)
from calibration.camera import Camera, camera_from
from calibration.corner_detection import BoardView
from calibration.corner_noise import corner_noise
from calibration.cross_check import CrossCheck, cross_check
from calibration.model_selection import ModelCandidate, ModelSelection, select_model
from calibration.observations import LeftOut, Observations
from calibration.refusals import (
    largest_tilt,
    refuse_few,
    refuse_fisheye,
    refuse_unconverged,
    refuse_undetermined,
    refuse_unexplained,
)
from calibration.stacked_views import StackedViews, stack_views
from calibration.view_selection import drop_disagreeing_views, drop_repeated_views, outlier_corner_notes
from xneck_foundation.errors import Refused

_FULLEST = "k1 k2 p1 p2 k3"
_APART = 1.5
"""ratio of jackknife to least squares, either way, from which on it is worth a word"""


@dataclass(frozen=True)
class PictureUse:
    """What became of one picture."""

    name: str
    used: bool
    why: str  # "" where used
    rms_px: float | None = None
    held_out_rms_px: float | None = None


@dataclass(frozen=True)
class Calibration:
    """A camera and what it was estimated from. Errors in px are root mean square distances over corners."""

    camera: Camera
    rms_px: float
    held_out_rms_px: float  # each view predicted by a camera estimated without it, only its pose fitted
    pictures: tuple[PictureUse, ...]
    sigma_least_squares: np.ndarray  # order of lens.NAMES, shape (9,)
    sigma_jackknife: np.ndarray  # the same by leaving out one view, shape (9,)
    free: tuple[str, ...]  # names of the estimated parameters
    corners: int  # number of corners used
    tilt: float  # largest angle between two boards, rad
    views: tuple[BoardView, ...]  # those used
    poses: BoardPoses  # of those used
    notes: tuple[str, ...]  # what a person should know, in sentences
    candidates: tuple[ModelCandidate, ...]  # lens models and board shapes, simplest first
    lens: str  # the chosen one's, of lens.MODELS
    board: BoardShape  # as estimated; of the model that was chosen
    board_sigma: np.ndarray  # of board.values, zero where fixed, shape (3,)
    noise_px: float  # standard deviation of one coordinate of a corner about the camera's prediction
    corner_noise_px: float | None  # the same about a smooth map of each view, which asks no camera
    cross_check: CrossCheck | None  # OpenCV's own, where it finds one


@dataclass(frozen=True)
class _Jackknife:
    """One estimate without each view, and that view's corners when predicted by it."""

    parameters: np.ndarray  # shape (n, 9)
    shapes: np.ndarray  # values of the board's shape, shape (n, 3)
    rms_views: np.ndarray  # shape (n,), px

    def sigma(self) -> tuple[np.ndarray, np.ndarray]:
        """Of the parameters, shape (9,), and of the board's shape, shape (3,)."""
        n = len(self.parameters)
        spread = [
            np.sqrt((n - 1) / n * np.sum((v - v.mean(axis=0)) ** 2, axis=0)) for v in (self.parameters, self.shapes)
        ]
        return spread[0], spread[1]


def calibrate(observations: Observations) -> Calibration:
    """Estimate the camera that took the views.

    Raises Refused for fewer than 6 distinct views, corners that are not finite, boards all tilted alike, views that
    disagree among themselves, an error far above what corner finding leaves, and a fisheye.
    """
    for view in observations.views:
        if not (np.all(np.isfinite(view.image_points)) and np.all(np.isfinite(view.object_points))):
            raise Refused(view.name, "corner coordinates that are not finite", "leave the picture out")
    views, repeats = drop_repeated_views(observations.views, observations.image_size)
    left_out = [*observations.left_out, *repeats]
    refuse_few(len(views), left_out)
    seen = stack_views(views)
    fitted = _first(seen, observations.image_size)
    noise = fit_noise(fitted)
    kept, fitted, disagreeing = drop_disagreeing_views(views, seen, fitted, noise)
    left_out += disagreeing
    refuse_few(len(kept), left_out)
    views, seen = [views[i] for i in kept.tolist()], seen.of(kept)
    of_corners = corner_noise(seen)
    # what is hopeless needs no choice of models
    refuse_unexplained(fitted, None, observations.image_size, disagreeing)
    refuse_undetermined(fitted)
    choice, fits = select_model(seen, fitted, fit_noise(fitted))
    full = fits[_FULLEST, choice.chosen.board]
    about = fit_noise(full) if of_corners is None else min(of_corners, fit_noise(full))
    wide = refuse_fisheye(full, seen, fit_residuals(full, seen), about)
    refuse_unexplained(choice.fit, of_corners, observations.image_size, disagreeing)
    refuse_undetermined(choice.fit)
    # the noise about the chosen model, not about the first guess at it, sets the knee of the loss
    one = choice.fit
    chosen = fit_bundle(seen, one.parameters, one.poses, one.free, one.shape, one.shape.model, fit_noise(one))
    refuse_unconverged(chosen)
    rivals = np.array([fits[rival.lens, rival.board].parameters for rival in choice.rivals()]).reshape(-1, 9)
    return _result(observations, views, seen, left_out, choice, chosen, rivals - one.parameters, of_corners, wide)


def _first(seen: StackedViews, image_size: tuple[int, int]) -> BundleFit:
    """The default lens model and a flat board, robustly."""
    unexplained = Refused("pictures", "no camera explains the corners", "check board.yaml and take tilted views")
    try:
        parameters, poses = initial_estimate(seen, image_size)
    except cv2.error as error:
        raise unexplained from error
    if not all(np.all(np.isfinite(values)) for values in (parameters, poses.R, poses.t)):
        raise unexplained
    fitted = fit_bundle(seen, parameters, poses)
    return fit_bundle(seen, fitted.parameters, fitted.poses, noise=fit_noise(fitted))


def _jackknife(seen: StackedViews, fitted: BundleFit) -> _Jackknife:
    n = len(seen.seen)
    each = leave_out_groups(fitted, [np.array([i]) for i in range(n)])
    parameters = np.array([p for p, _ in each])
    distances = prediction_distances(seen, parameters, np.array([shape.points for _, shape in each]), fitted.poses, fitted.knee)
    rms = np.sqrt(np.sum(distances**2, axis=1) / seen.counts)
    return _Jackknife(parameters, np.array([shape.values for _, shape in each]), rms)


def _result(
    observations: Observations,
    views: Sequence[BoardView],
    seen: StackedViews,
    left_out: Sequence[LeftOut],
    choice: ModelSelection,
    fitted: BundleFit,
    to_rivals: np.ndarray,
    of_corners: float | None,
    wide: str | None,
) -> Calibration:
    out = _jackknife(seen, fitted)
    sigma_jackknife, board_jackknife = out.sigma()
    sigma_least_squares = np.sqrt(np.diag(fitted.covariance))
    # distortion numbers make up for one another, so that each alone may differ much between models of the same camera
    sigma_choice = np.where(np.arange(9) < 4, np.max(np.abs(to_rivals), axis=0, initial=0.0), 0.0)
    # the correlations of least squares (a jackknife of few views has no full rank) with the total sigma of each
    estimated = sigma_least_squares > 0
    grow = np.ones(9)
    total = np.hypot(np.maximum(sigma_jackknife, sigma_least_squares), sigma_choice)[estimated]
    grow[estimated] = total / sigma_least_squares[estimated]
    covariance = fitted.covariance * np.outer(grow, grow)
    counts = seen.counts
    held_out = float(np.sqrt(np.sum(counts * out.rms_views**2) / counts.sum()))
    pictures = [PictureUse(entry.name, False, entry.why) for entry in left_out] + [
        PictureUse(view.name, True, "", float(rms), float(held))
        for view, rms, held in zip(views, fitted.rms_views, out.rms_views, strict=True)
    ]
    pictures.sort(key=lambda picture: picture.name)
    board_sigma = np.maximum(np.sqrt(np.diag(fitted.shape_covariance)), board_jackknife)
    beside = cross_check(views, observations.image_size, fitted.free, fitted.parameters, np.sqrt(np.diag(covariance)))
    notes = [
        *observations.notes,
        *outlier_corner_notes(views, seen, fitted),
        *_notes(observations.image_size, views, fitted, sigma_jackknife, sigma_least_squares),
        *_board_notes(fitted.shape, board_sigma),
        *([wide] if wide else []),
    ]
    said = beside.note(fitted.shape.model.name == "rigid") if beside else None
    notes += [said] if said else []
    info = {
        "rms_px": fitted.rms,
        "held_out_rms_px": held_out,
        "corners": int(counts.sum()),
        "lens": choice.chosen.lens,
        "board": choice.chosen.board,
        "notes": notes,
        "candidates": [
            {
                "lens": candidate.lens,
                "board": candidate.board,
                "rms_px": candidate.rms_px,
                "held_out_rms_px": candidate.held_out_rms_px,
                "chosen": candidate.chosen,
            }
            for candidate in choice.candidates
        ],
        "pictures": [{"file": picture.name, "used": picture.used, "why": picture.why} for picture in pictures],
    }
    return Calibration(
        camera=camera_from(fitted.parameters, observations.image_size, covariance=covariance, info=info),
        rms_px=fitted.rms,
        held_out_rms_px=held_out,
        pictures=tuple(pictures),
        sigma_least_squares=sigma_least_squares,
        sigma_jackknife=sigma_jackknife,
        free=fitted.free,
        corners=int(counts.sum()),
        tilt=largest_tilt(fitted.poses),
        views=tuple(views),
        poses=fitted.poses,
        notes=tuple(notes),
        candidates=choice.candidates,
        lens=choice.chosen.lens,
        board=fitted.shape,
        board_sigma=board_sigma,
        noise_px=fit_noise(fitted),
        corner_noise_px=of_corners,
        cross_check=beside,
    )


def _notes(
    image_size: tuple[int, int],
    views: Sequence[BoardView],
    fitted: BundleFit,
    jackknife: np.ndarray,
    least_squares: np.ndarray,
) -> list[str]:
    width, height = image_size
    notes: list[str] = []
    points = np.concatenate([view.image_points for view in views])
    column = np.clip((3 * points[:, 0] / width).astype(int), 0, 2)
    row = np.clip((3 * points[:, 1] / height).astype(int), 0, 2)
    empty = [
        f"{('upper', 'middle', 'lower')[r]} {('left', 'middle', 'right')[c]}".replace("middle middle", "middle")
        for r in range(3)
        for c in range(3)
        if not np.any((column == c) & (row == r))
    ]
    if empty:
        notes.append(f"no corners in these ninths of the picture: {', '.join(empty)}; the lens is a guess there")
    free = least_squares > 0
    ratio = np.ones(9)
    ratio[free] = jackknife[free] / least_squares[free]
    for words, which in (("larger", ratio > _APART), ("smaller", ratio < 1 / _APART)):
        if which.any():
            found = ", ".join(f"{lens.PARAMETER_NAMES[i]} {ratio[i]:.1f}" for i in np.nonzero(which)[0])
            notes.append(f"sigma by leaving out views is {words} than that of least squares, times: {found}")
    border = np.array([[0, 0], [width - 1, 0], [0, height - 1], [width - 1, height - 1]], float)
    if np.any(np.isnan(lens.pixels_to_rays(border, fitted.parameters))):
        notes.append("the lens model turns back before the picture's corners: do not use it there")
    return notes


def _board_notes(shape: BoardShape, sigma: np.ndarray) -> list[str]:
    """What is worth saying of the board's shape."""
    free = shape.model.free
    words: list[str] = []
    if "bow_x" in free:
        bow, s = 1e3 * shape.values, 1e3 * sigma
        words.append(f"bowed by {bow[0]:.2f} +- {s[0]:.2f} mm along x and {bow[1]:.2f} +- {s[1]:.2f} mm along y")
    if "aspect" in free:
        i = board_shape.SHAPE_NAMES.index("aspect")
        words.append(f"with rows {100 * shape.values[i]:+.2f} +- {100 * sigma[i]:.2f} % apart")
    if shape.model.offsets:
        away = 1e3 * np.sqrt(np.mean(shape.offsets**2, axis=0))
        plane = float(np.hypot(away[0], away[1]))
        words.append(
            f"with corners off their places by {plane:.2f} mm in the plane and {away[2]:.2f} mm out of it (rms)"
        )
    return [f"the board is estimated {', '.join(words)}"] if words else []
