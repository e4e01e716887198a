"""Normal equations of the linkage's fit: shared parameters couple the frames, joint angles belong to one frame each.

The angles are eliminated frame by frame with a Schur complement, so that cost grows linearly with the frames.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from vision.linkage.observed_corners import ObservedCorners
from vision.linkage.scene import Scene, SharedParameters

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

HUBER_KNEE_SIGMA = 5.0
"""standard deviations from which on a corner pulls with constant force (Huber)"""
MIN_VARIANCE = 1e-8
"""least variance of a whitened coordinate, so that a prior still counts where corners are exact"""


@dataclass(frozen=True)
class LinkageEquations:
    """Normal equations at one point, of whitened corners and not yet divided by their variance."""

    residual: Complex
    """(F, markers, 4), normalised coordinates, zero where not seen"""
    squares: Array
    """(F,): sum of the weighted and whitened squared residuals of each frame"""
    scale: float
    """standard deviation of a whitened coordinate by which corners' weights were told"""
    variance: float
    """of a whitened coordinate, from the median frame"""
    normal: Array
    """(F, N, N): normal matrix of each frame's angles"""
    inverse: Array
    """(F, N, N): inverse of `normal`, zero in directions without information"""
    mixed: Array
    """(F, N, p): block between the angles and the shared parameters"""
    g_angles: Array
    """(F, N): right-hand side of the angles"""
    reduced: Array
    """(F, p, p): each frame's normal matrix of the shared parameters, its angles eliminated"""
    g_reduced: Array
    """(F, p): right-hand side that belongs to `reduced`"""


def linkage_equations(
    scene: Scene,
    observed: ObservedCorners,
    shared: SharedParameters,
    alpha: Array,
    course: Array,
    count: int,
    scale: float | None = None,
    beside: Complex | None = None,
) -> LinkageEquations:
    """Normal equations at `shared` and `alpha`, (F, N), rad.

    count: how many shared parameters were estimated from these frames, for the degrees of freedom. scale: standard deviation
    of a whitened coordinate, for the robust weights; from the median residual where None. beside: derivatives of the corners by
    k numbers that are asked for after the shared parameters, (F, markers, 4, k); p then counts these too.
    """
    r = (observed.image - scene.image(shared, alpha, course)) * observed.visible[..., None]
    if scale is None:
        # the median of Rayleigh's distribution is 1.177 standard deviations
        z = np.abs(r[observed.visible]) / observed.sigma[observed.visible]
        scale = float(np.median(z)) / 1.177 if observed.visible.any() else 1.0
    weight = np.sqrt(robust_weights(observed, r, scale))[..., None]
    Ja = whiten(observed, scene.by_angles(shared, alpha, course) * weight)
    by_shared = scene.by_shared(shared, alpha, course)
    Js = whiten(observed, (by_shared if beside is None else np.concatenate([by_shared, beside], axis=-1)) * weight)
    e = whiten(observed, r[..., None] * weight)[..., 0]
    JaT = np.swapaxes(Ja, 1, 2)
    normal, mixed, g_angles = JaT @ Ja, JaT @ Js, (JaT @ e[..., None])[..., 0]
    inverse = inverse_normals(normal)
    # squared only after the angles are eliminated: a difference of squares would be negative by rounding where little is known
    left = Js - Ja @ (inverse @ mixed)
    leftT = np.swapaxes(left, 1, 2)
    squares = np.sum(e**2, axis=1)
    return LinkageEquations(
        residual=r,
        squares=squares,
        scale=scale,
        variance=bounded_variance(squares, degrees_of_freedom(observed, alpha.shape[1], count)),
        normal=normal,
        inverse=inverse,
        mixed=mixed,
        g_angles=g_angles,
        reduced=leftT @ left,
        g_reduced=(leftT @ e[..., None])[..., 0],
    )


def robust_weights(observed: ObservedCorners, residual: Complex, scale: float) -> Array:
    """Huber's weights of corners, (F, markers, 4), by their residuals; scale: standard deviation of a whitened coordinate."""
    z = np.abs(residual) / observed.sigma
    return np.minimum(1.0, HUBER_KNEE_SIGMA * (scale + 1e-12) / np.maximum(z, 1e-12))


def robust_loss(observed: ObservedCorners, residual: Complex, scale: float) -> float:
    """What those weights lessen: squares up to the knee, in proportion from there on (Huber 1964)."""
    weight = robust_weights(observed, residual, scale)
    return float(np.sum(whiten(observed, (residual * np.sqrt(weight * (2 - weight)))[..., None]) ** 2))


def degrees_of_freedom(observed: ObservedCorners, unknowns: int, shared: int = 0) -> Array:
    """Degrees of freedom of each frame's residual, (F,), at least zero; the shared unknowns are spread over all frames."""
    counts = np.maximum(observed.rank.sum(axis=1) - unknowns, 0).astype(float)
    return counts * max(1 - shared / max(counts.sum(), 1.0), 0.1)


def median_variance(squares: Array, free: Array) -> float:
    """Variance of a whitened coordinate from the median frame, which a few wrong frames do not inflate; NaN without a frame.

    squares, free: sum of squares and degrees of freedom of each frame, (F,).
    """
    usable = free > 0.5
    if not usable.any():
        return float("nan")
    # the median of chi-square lies below its mean
    return float(np.median(squares[usable] / chi2.median(free[usable])))


def bounded_variance(squares: Array, free: Array) -> float:
    """`median_variance`, at least MIN_VARIANCE; 1 where there is no frame with degrees of freedom."""
    variance = median_variance(squares, free)
    return max(variance, MIN_VARIANCE) if np.isfinite(variance) else 1.0


def inverse_normals(normal: Array, unknown: float = 0.0) -> Array:
    """Inverses of symmetric matrices (F, N, N); a direction without information gets the variance `unknown`."""
    w, v = np.linalg.eigh(normal)
    informed = w > 1e-9 * np.maximum(w[:, -1:], 1e-300)
    inverted = np.where(informed, 1 / np.where(informed, w, 1.0), unknown)
    return np.einsum("fik,fk,fjk->fij", v, inverted, v)


def whiten(observed: ObservedCorners, slopes: Complex) -> Array:
    """Whitened rows, (F, 8 markers, n), of complex derivatives (F, markers, 4, n)."""
    rows = np.stack([slopes.real, slopes.imag], axis=3).reshape(*slopes.shape[:2], 8, slopes.shape[-1])
    return (observed.whitener @ rows).reshape(len(slopes), -1, slopes.shape[-1])
