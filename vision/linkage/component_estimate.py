"""Components of the corners' errors from what the arm's fit leaves of them.

An arm has fewer joints than its markers have shifts and turns, so their errors show. The mean square of what is left in a component
is compared with what the stated covariance leaves there, after the angles have taken their part (variance components, Förstner
1979). Markers that move are assumed to err alike, and those that stand still. Along their paths the angles follow shifts: there
markers are assumed to err as across them.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from vision.linkage.camera_shake import on_base
from vision.linkage.error_components import ErrorComponents, is_even, shared_shift_slopes
from vision.linkage.gauss_newton import fit_angles
from vision.linkage.linkage_equations import inverse_normals, whiten
from vision.linkage.observed_corners import ObservedCorners
from vision.linkage.shared_fit import SharedFit

Array = NDArray[np.float64]

OUTLYING_SIGMAS = 5.0
"""standard deviations from which on what is left of a marker says that its frame tells nothing (docs/thresholds.md)"""
PRIOR_MARKERS = 20.0
"""so many markers count for a component's variance being that of all of them together (docs/thresholds.md)"""
ROUNDS = 8


def estimate_components(
    fit: SharedFit, observed: ObservedCorners, frames: NDArray[np.intp], shaken: bool = False
) -> ErrorComponents:
    """The components that explain what a fit leaves of the corners of some frames, beside its variance of all corners.

    shaken: whether the corners were corrected by the base's motion in the picture, so that its error is in all others."""
    course, scale = fit.course[frames], float(np.sqrt(fit.variance))
    alpha, _ = fit_angles(fit.scene, observed, fit.shared, fit.first_angles(frames), course, scale)
    residual = (observed.image - fit.scene.image(fit.shared, alpha, course)) * observed.visible[..., None]
    count, markers = observed.visible.shape
    left = whiten(observed, residual[..., None] / scale).reshape(count, markers, 8, 1)
    Ja = whiten(observed, fit.scene.by_angles(fit.shared, alpha, course))
    taken = Ja @ inverse_normals(np.swapaxes(Ja, 1, 2) @ Ja) @ np.swapaxes(Ja, 1, 2)
    remains = (np.eye(8 * markers) - taken).reshape(count, markers, 8, markers, 8)
    components = ErrorComponents.as_stated(fit.image[frames])
    to_corners = observed.unwhitener
    along = components.directions(observed.image) @ to_corners
    weight = 1 / np.sum(to_corners**2, axis=(2, 3))[..., None]  # each marker counts by its own stated variance
    squares = weight * _by_component(along, to_corners, left)
    even = observed.visible & is_even(observed)
    shift = shifted = of_shift = np.zeros(())
    if shaken:
        shift = shared_shift_slopes(observed).reshape(count, markers, 8, 2) * ~on_base(fit.scene)[:, None, None]
        shifted = np.einsum("fminj,fnjk->fmik", remains, shift, optimize=True)
        of_shift = weight * _by_component(along, to_corners, shifted)
    for _ in range(ROUNDS):
        root = components.whitened_errors(observed) * observed.visible[..., None, None]
        spread = np.einsum("fminj,fnjk->fmink", remains, root, optimize=True)
        spread = spread.reshape(count, markers, 8, -1)
        shared = components.shared_shift / fit.variance
        expected = weight * _by_component(along, to_corners, spread) + shared * of_shift
        outlying = even & (squares.sum(axis=-1) > OUTLYING_SIGMAS**2 * expected.sum(axis=-1))
        usable = even & ~outlying.any(axis=1, keepdims=True)  # it draws the angles, and the others stand beside
        ratio = np.ones_like(components.factor)
        for row, chosen in zip(ratio, (usable & ~components.standing, usable & components.standing), strict=True):
            if chosen.any():
                row[:] = _ratio(squares[chosen], expected[chosen])
        if shaken:
            told = usable.all(axis=1)
            beyond = _squares(shift[told], left[told]) - _squares(shift[told], spread[told])
            shared = max(beyond / _squares(shift[told], shifted[told]), 0.0) if told.any() else 0.0
        components = replace(components, factor=components.factor * np.sqrt(ratio), shared_shift=shared * fit.variance)
    return components


def _ratio(squares: Array, expected: Array) -> Array:
    """Of each component, (4,), squares (n, 4) of n markers over what is expected of them."""
    total, of_all = squares.sum(axis=0), expected.sum(axis=0)
    prior = PRIOR_MARKERS * of_all / len(expected)
    return (total + prior * total.sum() / of_all.sum()) / (of_all + prior)


def _squares(slopes: Array, whitened: Array) -> float:
    """Sum of squares of whitened corners (F, markers, 8, n) along slopes (F, markers, 8, k)."""
    return float(np.sum(np.einsum("fmik,fmin->fkn", slopes, whitened, optimize=True) ** 2))


def _by_component(along: Array, to_corners: Array, whitened: Array) -> Array:
    """Squares of whitened corners (F, markers, 8, n) in the directions of each component, (F, markers, 4); of the shifts those
    across the path."""
    along_path, across, turn, size = np.moveaxis(np.sum((along @ whitened) ** 2, axis=-1), -1, 0)
    whole = np.sum((to_corners @ whitened) ** 2, axis=(2, 3))
    return np.stack([across, turn, size, whole - along_path - across - turn - size], axis=-1)
