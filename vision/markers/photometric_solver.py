"""Gauss-Newton fit of markers' templates to grey levels, all markers of a picture side by side.

Unknown are the motion of the marker (eight numbers, `planar_motion`), a plane of light on black and one on white, and small
changes of blur and ink bleed against those of the recording. Pixels that the model does not explain, a cable or a shadow,
lose their weight. The covariance is measured from the scores of picture blocks, so that it holds for compressed pictures too.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.markers.edge_pixels import EdgePixels, select_pixels
from vision.markers.photometric_model import (
    BLUR_VARIANCE,
    COLUMNS,
    INK_BLEED,
    LIGHT,
    LIGHT_SLOPES,
    MarkerTemplates,
    initial_light,
    model_derivatives,
)
from vision.markers.planar_motion import DOF, corner_slopes, homography, move_corners
from vision.markers.robust_weights import (
    MEAN_NORMAL_WEIGHT,
    block_variance,
    drop_outlier_neighbours,
    influence_slope,
    residual_scale,
    tukey_weights,
)
from vision.markers.template import Optics

Array = NDArray[np.float64]
Single = NDArray[np.float32]

MAX_ITERATIONS = 8
MAX_FINAL_STEP_PX = 0.08
"""px; after a larger last step, or where something lies across a marker, the weights are renewed once more"""
WHOLE_WEIGHT = 0.9
"""share of the weight of a fully visible marker, from which on nothing lies across it"""
LINEAR_PX = 0.15
"""px; the model's derivatives hold within this distance of where they were computed"""
ROUGH_PIXELS = 400
"""pixels of a marker that are enough for a first step"""
CONVERGED_PX = 0.3
"""px; a larger last step means that the fit did not converge (docs/thresholds.md)"""
RESELECT_PX, RESELECT_LIT_PX = 0.4, 0.8
"""px from where the pixels were selected, beyond which they are selected anew; the second where the light was known at first"""
RESELECTION_ITERATIONS = 3
"""iterations after which pixels are no longer selected anew"""
PERSPECTIVE_SD = 0.05
"""prior of the perspective terms about those of the start; it holds small markers, larger ones determine them better"""
MIN_CONTRAST = 12.0
"""grey levels between black and white, below which there is nothing to fit (docs/thresholds.md)"""
SLOPE_SD = 0.2
"""prior of the light's change from a marker's middle to its side, as a share of the contrast"""
FIRST_SLOPE_SD = 0.002
"""`SLOPE_SD` in the first iteration, so that a thing across the marker is not taken for a slope of the light"""
FIRST_SCALE = 0.09
"""residual scale of the first iteration as a share of the contrast: from the error of the start, not from a thing across"""
MAX_MOTION = 0.2
"""of any number of the marker's motion in one iteration, marker coordinates"""


@dataclass(frozen=True)
class PhotometricFit:
    """The last iteration; arrays over the M markers."""

    pixels: EdgePixels
    corners: Array
    """(M, 4, 2), px"""
    covariance: Array
    """(M, 8, 8), px^2"""
    solution: Array
    """(M, COLUMNS)"""
    optics_sd: Array
    """(M, 2): standard deviations of the columns blur variance (px^2) and bleed (px)"""
    scale: Array
    """(M,): standard deviation of the residual, grey levels"""
    rms: Array
    """(M,): weighted root mean square of the residual, grey levels"""
    weight: Array
    """(M,): mean weight of the pixels, 1 where there is nothing but noise"""
    converged: NDArray[np.bool_]
    """(M,)"""


@dataclass
class _Prior:
    """Gaussian prior of the columns: means and inverse variances, (M, COLUMNS); it changes from iteration to iteration."""

    mean: Array
    precision: Array

    @classmethod
    def of(cls, pixels: EdgePixels, optics: Optics) -> "_Prior":
        """Prior of the perspective terms, the blur and the bleed."""
        prior = cls(np.zeros((len(pixels.textures), COLUMNS)), np.zeros((len(pixels.textures), COLUMNS)))
        prior.precision[:, 6:DOF] = PERSPECTIVE_SD**-2
        prior.precision[:, BLUR_VARIANCE] = (2 * optics.sigma * optics.sigma_sd) ** -2
        prior.precision[:, INK_BLEED] = optics.bleed_sd**-2
        prior.mean[:, BLUR_VARIANCE] = -pixels.excess_variance
        return prior

    def hold_slopes(self, light: Array, slope_sd: float) -> None:
        """Set the standard deviation of the light's slopes to a share of the contrast under `light`, (M, 6)."""
        self.precision[:, LIGHT_SLOPES] = (slope_sd * np.maximum(light[:, 3:4], MIN_CONTRAST)) ** -2


@dataclass(frozen=True)
class _Iteration:
    """What the last iteration solved."""

    pixels: EdgePixels
    H: Array
    """(M, 3, 3): homographies about which it was linear"""
    D: Single
    """(M, COLUMNS + 1, N): derivatives and grey levels"""
    weight: Single
    """(M, N)"""
    prior: _Prior
    inverse: Array
    """(M, COLUMNS, COLUMNS)"""
    solution: Array
    """(M, COLUMNS)"""
    residual: Single
    """(M, N)"""
    corners_before: Array
    """(M, 4, 2), px: about which it was linear"""
    corners: Array
    """(M, 4, 2), px: after the step"""

    @property
    def step_px(self) -> float:
        """Largest motion of a corner's coordinate in this iteration."""
        return float(np.abs(self.corners - self.corners_before).max())


def fit_templates(
    grey: NDArray[np.uint8],
    cells: Sequence[NDArray[np.bool_]],
    corners: Array,
    motion: Array,
    light: Array,
    optics: Optics,
) -> PhotometricFit:
    """Fit M markers with `cells` to a picture, (height, width), from corners that are right to half a cell.

    corners, motion: (M, 4, 2), px, as `MarkerStart` has them; light: (M, 6), grey levels, NaN where not known.
    """
    last = _iterate(grey, cells, corners, motion, light, optics)
    pixels, D, weight, prior = last.pixels, last.D, last.weight, last.prior
    inverse, solution, residual, moved = last.inverse, last.solution, last.residual, last.corners
    scale = residual_scale(residual, pixels.used)
    whole = weight.sum(axis=1) > WHOLE_WEIGHT * MEAN_NORMAL_WEIGHT * np.count_nonzero(pixels.used, axis=1)
    # so near the optimum the derivatives stay as they are and only the weights are renewed
    if last.step_px > MAX_FINAL_STEP_PX or not whole.all():
        weight = _weights(residual, scale, pixels)
        prior.hold_slopes(solution[:, LIGHT], SLOPE_SD)
        inverse, solution, residual = _solve(D, weight, prior, scale)
        scale = residual_scale(residual, pixels.used)
        moved = _moved(last.H, solution)
    inflation = block_variance(D[:, :COLUMNS], inverse, weight, residual, pixels.blocks)
    inflation = inflation / influence_slope(residual, scale, pixels.used) ** 2
    slopes = corner_slopes(last.H)
    covariance = slopes @ (inverse[:, :DOF, :DOF] * inflation[:, None, None]) @ np.swapaxes(slopes, 1, 2)
    total = np.maximum(weight.sum(axis=1, dtype=float), 1e-9)
    count = np.maximum(np.count_nonzero(pixels.used, axis=1), 1)
    optics_columns = [BLUR_VARIANCE, INK_BLEED]
    return PhotometricFit(
        pixels=pixels,
        corners=moved,
        covariance=covariance,
        solution=solution,
        optics_sd=np.sqrt(np.maximum(inverse[:, optics_columns, optics_columns] * inflation[:, None], 0)),
        scale=scale,
        rms=np.sqrt(np.einsum("mn,mn,mn->m", weight, residual, residual) / total),
        weight=total / count / MEAN_NORMAL_WEIGHT,
        converged=np.abs(moved - last.corners_before).max(axis=(1, 2)) < CONVERGED_PX,
    )


def _iterate(
    grey: NDArray[np.uint8],
    cells: Sequence[NDArray[np.bool_]],
    corners: Array,
    motion: Array,
    light: Array,
    optics: Optics,
) -> _Iteration:
    """Gauss-Newton until a step is small; arguments as in `fit_templates`."""
    H = homography(corners)
    selected = select_pixels(grey, cells, corners, H, motion, optics)
    selected_at = corners
    prior = _Prior.of(selected, optics)
    reselect_px = RESELECT_PX if np.isnan(light).any() else RESELECT_LIT_PX
    iteration, fresh = 0, True
    while True:
        iteration += 1
        # the first step from a light that is known only brings the start nearer
        rough = fresh and not np.isnan(light).any()
        pixels = selected.thinned(ROUGH_PIXELS) if rough else selected
        templates = MarkerTemplates.of(pixels, H)
        light = initial_light(templates, pixels, light)
        residual = pixels.grey - templates.under(light)
        scale = FIRST_SCALE * light[:, 3] if fresh else residual_scale(residual, pixels.used)
        weight = _weights(residual, scale, pixels)
        D = model_derivatives(templates, pixels.grey, light)
        prior.mean[:, LIGHT_SLOPES] = light[:, [1, 2, 4, 5]] if fresh else 0.0
        prior.hold_slopes(light, FIRST_SLOPE_SD if fresh else SLOPE_SD)
        inverse, solution, residual = _solve(D, weight, prior, scale)
        last = _Iteration(
            pixels=pixels,
            H=H,
            D=D,
            weight=weight,
            prior=prior,
            inverse=inverse,
            solution=solution,
            residual=residual,
            corners_before=corners,
            corners=_moved(H, solution),
        )
        if (not fresh and last.step_px < LINEAR_PX) or iteration == MAX_ITERATIONS:
            return last
        # the prior of the perspective terms holds about the start, so its mean is carried along
        prior.mean[:, 6:DOF] -= _motion(solution)[:, 6:]
        # where no pixel has weight the start was too far off for the first scale: nothing was learnt of the light either
        informed = np.any(weight, axis=1, keepdims=True)
        corners, light, fresh = last.corners, np.where(informed, solution[:, LIGHT], light), False
        H = homography(corners)
        if iteration <= RESELECTION_ITERATIONS and np.abs(corners - selected_at).max() > reselect_px:
            selected = select_pixels(grey, cells, corners, H, motion, optics)
            selected_at = corners
            prior.mean[:, BLUR_VARIANCE] = -selected.excess_variance
            light, fresh = np.full_like(light, np.nan), True


def _weights(residual: Single, scale: Array, pixels: EdgePixels) -> Single:
    """Tukey's weights of the pixels, zero beside things across the marker, (M, N)."""
    return drop_outlier_neighbours(tukey_weights(residual, scale) * pixels.used, pixels.used, *pixels.xy)


def _moved(H: Array, solution: Array) -> Array:
    """Corners (M, 4, 2), px, after the motion of a solution."""
    return move_corners(H, _motion(solution))


def _motion(solution: Array) -> Array:
    """The marker's motion in a solution (M, COLUMNS), (M, DOF): at most MAX_MOTION, none where it is not a number."""
    xi = solution[:, :DOF]
    return np.clip(np.where(np.isnan(xi), 0.0, xi), -MAX_MOTION, MAX_MOTION)


def _solve(D: Single, weight: Single, prior: _Prior, scale: Array) -> tuple[Array, Array, Single]:
    """Weighted least squares with a prior: inverse of the normal matrix (M, P, P), solution (M, P), residual (M, N).

    scale: (M,), grey levels, the residuals' standard deviation, against which the prior is weighed.
    """
    precision = prior.precision * scale[:, None] ** 2
    weighted = D[:, :COLUMNS] * weight[:, None]
    product = (weighted @ np.swapaxes(D, 1, 2)).astype(float)
    normal, right = product[:, :, :COLUMNS], product[:, :, COLUMNS]
    diagonal = np.einsum("mpp->mp", normal)
    diagonal += precision + 1e-9 * diagonal + 1e-12
    inverse = np.linalg.inv(normal)
    solution = (inverse @ (right + precision * prior.mean)[..., None])[..., 0]
    coefficients = np.ones((len(D), 1, COLUMNS + 1), dtype=np.float32)
    coefficients[:, 0, :COLUMNS] = -solution
    return inverse, solution, (coefficients @ D)[:, 0]
