"""From views of a board to a camera with its uncertainty, or a refusal where the views do not determine it.

Cross-validation selects lens model and board shape. The reported standard deviation is the larger of two, that of least squares
and that of the jackknife over views; the differences to rival models that predict as well are added. Corner errors of one picture
have common causes (print, blur, board shape), so that least squares, which takes all corners as independent, gives values two to
three times too small on real sets.
"""

from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np

from calibration.board_poses import BoardPoses
from calibration.board_shape import BoardShape
from calibration.bundle_adjustment import (
    BundleFit,
    BundleStart,
    fit_bundle,
    fit_noise,
    fit_residuals,
    initial_estimate,
    leave_out_groups,
    prediction_distances,
    unexplained_corners,
)
from calibration.calibration_notes import board_notes, coverage_notes, jackknife_notes, lens_range_notes
from calibration.camera import Camera, camera_from
from calibration.corner_detection import BoardView
from calibration.corner_noise import corner_noise
from calibration.cross_check import CrossCheck, cross_check
from calibration.model_selection import ModelCandidate, select_model
from calibration.observations import LeftOut, Observations
from calibration.refusals import (
    largest_tilt,
    refuse_few,
    refuse_fisheye,
    refuse_impossible_corners,
    refuse_unconverged,
    refuse_undetermined,
    refuse_unexplained,
)
from calibration.stacked_views import StackedViews, stack_views
from calibration.view_selection import drop_disagreeing_views, drop_repeated_views, outlier_corner_notes
from xneck_foundation.one_blas_thread import one_blas_thread

_FULLEST_LENS = "k1 k2 p1 p2 k3"


@dataclass(frozen=True)
class PictureUse:
    """Whether a picture was used, and why not."""

    name: str
    used: bool
    why: str  # "" where used
    rms_px: float | None = None
    held_out_rms_px: float | None = None


@dataclass(frozen=True)
class Calibration:
    """A camera with the evidence for it. Errors in px are root mean square distances over corners."""

    camera: Camera
    rms_px: float
    held_out_rms_px: float  # each view predicted by a camera estimated without it, only its pose fitted
    pictures: tuple[PictureUse, ...]
    sigma_least_squares: np.ndarray  # order of lens.PARAMETER_NAMES, shape (9,)
    sigma_jackknife: np.ndarray  # by leaving out one view after another, shape (9,)
    free: tuple[str, ...]  # names of the estimated parameters
    corners: int  # number of corners used
    tilt: float  # largest angle between two boards, rad
    views: tuple[BoardView, ...]  # the views used
    poses: BoardPoses  # of the board in the views used
    notes: tuple[str, ...]  # what a person should know, in sentences
    candidates: tuple[ModelCandidate, ...]  # lens models and board shapes, simplest first
    lens: str  # the selected lens model, of lens.LENS_MODELS
    board: BoardShape  # estimated, of the selected board model
    board_sigma: np.ndarray  # of board.values, zero where fixed, shape (3,)
    noise_px: float  # standard deviation of one coordinate of a corner about the camera's prediction
    corner_noise_px: (
        float | None
    )  # of one coordinate about a smooth map of each view, without a camera model; None where not known
    cross_check: CrossCheck | None  # None where OpenCV fails


@dataclass(frozen=True)
class _Jackknife:
    """For each view, the estimate without it, and the error with which that estimate predicts its corners."""

    parameters: np.ndarray  # shape (n, 9)
    shapes: np.ndarray  # values of the board's shape, shape (n, 3)
    rms_views: np.ndarray  # shape (n,), px

    def sigma(self) -> tuple[np.ndarray, np.ndarray]:
        """Standard deviations of the parameters, shape (9,), and of the board's shape parameters, shape (3,)."""
        n = len(self.parameters)
        sigma = [
            np.sqrt((n - 1) / n * np.sum((v - v.mean(axis=0)) ** 2, axis=0)) for v in (self.parameters, self.shapes)
        ]
        return sigma[0], sigma[1]


@one_blas_thread
def calibrate(observations: Observations) -> Calibration:
    """Estimate the camera that took the views.

    Raises Refused for fewer than 6 distinct views, corners that are not finite, boards all tilted alike, views that
    disagree among themselves, an error far above what corner finding leaves, and a fisheye.
    """
    kept = _select_views(observations)
    stack, disagreeing = kept.stack, kept.disagreeing
    detection_noise = corner_noise(stack)
    # what is hopeless needs no model selection
    refuse_unexplained(kept.fit, None, observations.image_size, disagreeing)
    refuse_undetermined(kept.fit)
    selection, fits = select_model(stack, kept.fit, fit_noise(kept.fit))
    full = fits[_FULLEST_LENS, selection.selected.board]
    noise = fit_noise(full) if detection_noise is None else min(detection_noise, fit_noise(full))
    fisheye_note = refuse_fisheye(full, stack, fit_residuals(full, stack), noise)
    selected = selection.fit
    refuse_unexplained(selected, detection_noise, observations.image_size, disagreeing)
    refuse_undetermined(selected)
    # the knee of the loss follows from the noise about the selected model, not about the first guess
    start = BundleStart(selected.parameters, selected.poses, selected.shape)
    final = fit_bundle(stack, start, selected.free, selected.shape.model, fit_noise(selected))
    refuse_unconverged(final)
    rivals = np.array([fits[rival.lens, rival.board].parameters for rival in selection.rivals()]).reshape(-1, 9)
    uncertainty = _uncertainty(stack, final, rivals - selected.parameters)
    camera = camera_from(final.parameters, observations.image_size, covariance=uncertainty.covariance)
    opencv = cross_check(
        kept.views, observations.image_size, final.free, final.parameters, np.sqrt(np.diag(uncertainty.covariance))
    )
    notes = (
        *observations.notes,
        *outlier_corner_notes(kept.views, stack, final),
        *coverage_notes(observations.image_size, kept.views),
        *jackknife_notes(uncertainty.sigma_jackknife, uncertainty.sigma_least_squares),
        *lens_range_notes(observations.image_size, final.parameters),
        *board_notes(final.shape, uncertainty.board_sigma),
        *([fisheye_note] if fisheye_note else []),
        *([note] if opencv and (note := opencv.note(final.shape.model.name == "rigid")) else []),
    )
    calibration = Calibration(
        camera=camera,
        rms_px=final.rms,
        held_out_rms_px=uncertainty.held_out_rms_px,
        pictures=_picture_uses(kept, final, uncertainty.jackknife),
        sigma_least_squares=uncertainty.sigma_least_squares,
        sigma_jackknife=uncertainty.sigma_jackknife,
        free=final.free,
        corners=int(stack.counts.sum()),
        tilt=largest_tilt(final.poses),
        views=tuple(kept.views),
        poses=final.poses,
        notes=notes,
        candidates=selection.candidates,
        lens=selection.selected.lens,
        board=final.shape,
        board_sigma=uncertainty.board_sigma,
        noise_px=fit_noise(final),
        corner_noise_px=detection_noise,
        cross_check=opencv,
    )
    return replace(calibration, camera=replace(camera, info=_camera_info(calibration)))


@dataclass(frozen=True)
class _SelectedViews:
    """The views that a calibration uses, and their first fit."""

    views: list[BoardView]
    stack: StackedViews
    fit: BundleFit
    left_out: list[LeftOut]  # all of them
    disagreeing: list[LeftOut]  # for disagreement with the other views


def _select_views(observations: Observations) -> _SelectedViews:
    """Distinct views that agree with one another, with a fit of the default models. Raises Refused where they are too few."""
    refuse_impossible_corners(observations)
    views, repeats = drop_repeated_views(observations.views, observations.image_size)
    left_out = [*observations.left_out, *repeats]
    refuse_few(len(views), left_out)
    stack = stack_views(views)
    fit = _initial_fit(stack, observations.image_size)
    kept, fit, disagreeing = drop_disagreeing_views(views, stack, fit, fit_noise(fit))
    left_out += disagreeing
    refuse_few(len(kept), left_out)
    return _SelectedViews([views[i] for i in kept.tolist()], stack.of(kept), fit, left_out, disagreeing)


def _initial_fit(stack: StackedViews, image_size: tuple[int, int]) -> BundleFit:
    """A robust fit of the default lens model and a flat board."""
    try:
        start = initial_estimate(stack, image_size)
    except cv2.error as error:
        raise unexplained_corners() from error
    if not all(np.all(np.isfinite(values)) for values in (start.parameters, start.poses.R, start.poses.t)):
        raise unexplained_corners()
    fit = fit_bundle(stack, start)
    return fit_bundle(stack, BundleStart(fit.parameters, fit.poses), noise=fit_noise(fit))


@dataclass(frozen=True)
class _Uncertainty:
    """How well a fit is determined."""

    jackknife: _Jackknife
    sigma_least_squares: np.ndarray  # shape (9,)
    sigma_jackknife: np.ndarray  # shape (9,)
    covariance: np.ndarray  # of the parameters, all sources of error included, shape (9, 9)
    board_sigma: np.ndarray  # shape (3,)
    held_out_rms_px: float


def _uncertainty(stack: StackedViews, fit: BundleFit, to_rivals: np.ndarray) -> _Uncertainty:
    """The uncertainty of a fit; to_rivals: parameters of rival models less those of the selected one, shape (r, 9)."""
    jackknife = _jackknife(stack, fit)
    sigma_jackknife, board_jackknife = jackknife.sigma()
    sigma_least_squares = np.sqrt(np.diag(fit.covariance))
    # distortion coefficients compensate one another, so that each alone may differ much between models of the same camera
    sigma_choice = np.where(np.arange(9) < 4, np.max(np.abs(to_rivals), axis=0, initial=0.0), 0.0)
    # the correlations of least squares (a jackknife of few views has no full rank) with the total sigma of each
    estimated = sigma_least_squares > 0
    inflation = np.ones(9)
    total = np.hypot(np.maximum(sigma_jackknife, sigma_least_squares), sigma_choice)[estimated]
    inflation[estimated] = total / sigma_least_squares[estimated]
    counts = stack.counts
    return _Uncertainty(
        jackknife=jackknife,
        sigma_least_squares=sigma_least_squares,
        sigma_jackknife=sigma_jackknife,
        covariance=fit.covariance * np.outer(inflation, inflation),
        board_sigma=np.maximum(np.sqrt(np.diag(fit.shape_covariance)), board_jackknife),
        held_out_rms_px=float(np.sqrt(np.sum(counts * jackknife.rms_views**2) / counts.sum())),
    )


def _jackknife(stack: StackedViews, fit: BundleFit) -> _Jackknife:
    """The estimates without one view after another."""
    estimates = leave_out_groups(fit, [np.array([i]) for i in range(len(stack.visible))])
    parameters = np.array([p for p, _ in estimates])
    points = np.array([shape.points for _, shape in estimates])
    distances = prediction_distances(stack, parameters, points, fit.poses, fit.knee)
    rms = np.sqrt(np.sum(distances**2, axis=1) / stack.counts)
    return _Jackknife(parameters, np.array([shape.values for _, shape in estimates]), rms)


def _picture_uses(kept: _SelectedViews, fit: BundleFit, jackknife: _Jackknife) -> tuple[PictureUse, ...]:
    """All pictures by name, with the errors of those that were used."""
    pictures = [PictureUse(entry.name, False, entry.why) for entry in kept.left_out] + [
        PictureUse(view.name, True, "", float(rms), float(held_out))
        for view, rms, held_out in zip(kept.views, fit.rms_views, jackknife.rms_views, strict=True)
    ]
    return tuple(sorted(pictures, key=lambda picture: picture.name))


def _camera_info(calibration: Calibration) -> dict[str, Any]:
    """What camera.yaml says of the calibration beside the camera."""
    return {
        "rms_px": calibration.rms_px,
        "held_out_rms_px": calibration.held_out_rms_px,
        "corners": calibration.corners,
        "lens": calibration.lens,
        "board": calibration.board.model.name,
        "notes": list(calibration.notes),
        "candidates": [
            {
                "lens": candidate.lens,
                "board": candidate.board,
                "rms_px": candidate.rms_px,
                "held_out_rms_px": candidate.held_out_rms_px,
                "chosen": candidate.chosen,
            }
            for candidate in calibration.candidates
        ],
        "pictures": [
            {"file": picture.name, "used": picture.used, "why": picture.why} for picture in calibration.pictures
        ],
    }
