"""Gauss-Newton over all frames at once: shared parameters couple the frames, joint angles belong to one frame each.

The angles are eliminated frame by frame with a Schur complement, so that cost grows linearly with the frames. A parameter
with a prior stays at the prior's mean as far as the frames leave it undetermined.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from vision.linkage.block_covariance import clustered_covariance
from vision.linkage.observed_corners import CHUNK_FRAMES, ObservedCorners
from vision.linkage.scene import Scene, SharedParameters

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

MAX_ITERATIONS = 40
MAX_STEP = 0.5
"""rad, of an angle in one iteration"""
MAX_ALPHA = 2.8
"""rad; short of the singular half turn"""
HUBER_KNEE_SIGMA = 5.0
"""standard deviations from which on a corner pulls with constant force (Huber)"""
MAX_REFINEMENTS = 4
"""passes over all frames at most"""
MIN_VARIANCE = 1e-8
"""least variance of a whitened coordinate, so that a prior still counts where corners are exact"""


@dataclass(frozen=True)
class SharedPrior:
    """Gaussian prior of the p shared parameters, in the order of `SharedParameters.vector`."""

    mean: Array
    """(p,)"""
    information: Array
    """(p,): 1/sigma^2; zero where nothing is known"""
    free: NDArray[np.bool_]
    """(p,): which parameters a fit may change"""


@dataclass(frozen=True)
class LinkageEquations:
    """Normal equations at one point, of whitened corners and not yet divided by their variance."""

    residual: Complex
    """(F, markers, 4), normalised coordinates, zero where not seen"""
    squares: Array
    """(F,): sum of the weighted and whitened squared residuals of each frame"""
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


@dataclass(frozen=True)
class LinkageSolution:
    """The optimum that Gauss-Newton reached."""

    shared: SharedParameters
    alpha: Array
    """(F, N), rad"""
    equations: LinkageEquations
    """normal equations at the optimum"""
    covariance: Array
    """(p, p) of `shared.vector`; zero rows for parameters that were not free"""


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


def linkage_equations(
    scene: Scene,
    observed: ObservedCorners,
    shared: SharedParameters,
    alpha: Array,
    course: Array,
    count: int,
    scale: float | None = None,
) -> LinkageEquations:
    """Normal equations at `shared` and `alpha`, (F, N), rad.

    count: how many shared parameters were estimated from these frames, for the degrees of freedom. scale: standard deviation
    of a whitened coordinate, for the robust weights; from the median residual where None.
    """
    r = (observed.image - scene.image(shared, alpha, course)) * observed.visible[..., None]
    z = np.abs(r) / observed.sigma
    if scale is None:
        scale = (
            float(np.median(z[observed.visible])) / 1.177 if observed.visible.any() else 1.0
        )  # median of Rayleigh's law
    weight = np.sqrt(np.minimum(1.0, HUBER_KNEE_SIGMA * (scale + 1e-12) / np.maximum(z, 1e-12)))[..., None]
    Ja = _white(observed, scene.by_angles(shared, alpha, course) * weight)
    Js = _white(observed, scene.by_shared(shared, alpha, course) * weight)
    e = _white(observed, r[..., None] * weight)[..., 0]
    JaT = np.swapaxes(Ja, 1, 2)
    normal, mixed, g_angles = JaT @ Ja, JaT @ Js, (JaT @ e[..., None])[..., 0]
    inverse = inverse_normals(normal)
    eliminated = np.swapaxes(mixed, 1, 2) @ inverse
    squares = np.sum(e**2, axis=1)
    return LinkageEquations(
        residual=r,
        squares=squares,
        variance=_variance(squares, degrees_of_freedom(observed, alpha.shape[1], count)),
        normal=normal,
        inverse=inverse,
        mixed=mixed,
        g_angles=g_angles,
        reduced=np.swapaxes(Js, 1, 2) @ Js - eliminated @ mixed,
        g_reduced=(np.swapaxes(Js, 1, 2) @ e[..., None] - eliminated @ g_angles[..., None])[..., 0],
    )


@dataclass(frozen=True)
class OffsetSensitivity:
    """How corner offsets that stay the same over all frames change the estimates; 8 a marker, normalised coordinates.

    Such offsets do not average out. They come from the codec's error on a marker that stands still, from light, and from the
    lens model.
    """

    reduced: Array
    """(p, p): normal matrix of the shared parameters, the angles eliminated"""
    on_shared: Array
    """(p, 8 markers): derivative of the right-hand side that belongs to `reduced` by the offsets"""
    on_angles: Array
    """(F, N, 8 markers): derivative of the angles by the offsets, the shared parameters held"""


def offset_sensitivity(
    scene: Scene, observed: ObservedCorners, shared: SharedParameters, alpha: Array, course: Array
) -> OffsetSensitivity:
    """Sensitivity to lasting corner offsets at `shared` and `alpha`, (F, N), rad."""
    count = observed.image.shape[1]
    unit = np.zeros((count, 4, 8 * count), dtype=complex)
    for k in range(count):
        for c in range(4):
            unit[k, c, 8 * k + 2 * c], unit[k, c, 8 * k + 2 * c + 1] = 1.0, 1.0j
    Ja = _white(observed, scene.by_angles(shared, alpha, course))
    Js = _white(observed, scene.by_shared(shared, alpha, course))
    E = _white(observed, np.broadcast_to(unit, (len(alpha), *unit.shape)))
    JaT, JsT = np.swapaxes(Ja, 1, 2), np.swapaxes(Js, 1, 2)
    on_angles = inverse_normals(JaT @ Ja) @ (JaT @ E)
    reduced = JsT @ (Js - Ja @ (inverse_normals(JaT @ Ja) @ (JaT @ Js)))
    return OffsetSensitivity(np.sum(reduced, axis=0), np.sum(JsT @ (E - Ja @ on_angles), axis=0), on_angles)


def fit_frames(
    scene: Scene, observed: ObservedCorners, shared: SharedParameters, alpha: Array, course: Array, prior: SharedPrior
) -> LinkageSolution:
    """The best shared parameters and angles from a start; course: share of each drift term that a frame has, (F, terms)."""
    free = np.flatnonzero(prior.free)
    for _ in range(MAX_ITERATIONS):
        equations = linkage_equations(scene, observed, shared, alpha, course, len(free))
        change = np.zeros(len(prior.mean))
        information, right = _with_prior(equations, prior, shared)
        change[free] = _solve(information[np.ix_(free, free)], right[free])
        step = np.einsum("fnm,fm->fn", equations.inverse, equations.g_angles - equations.mixed @ change)
        shared = shared.plus(change)
        alpha = np.clip(alpha + np.clip(step, -MAX_STEP, MAX_STEP), -MAX_ALPHA, MAX_ALPHA)
        if max(np.max(np.abs(step), initial=0.0), np.max(np.abs(change), initial=0.0)) < 1e-8:
            break
    equations = linkage_equations(scene, observed, shared, alpha, course, len(free))
    covariance = np.zeros((len(prior.mean), len(prior.mean)))
    information, _ = _with_prior(equations, prior, shared)
    covariance[np.ix_(free, free)] = equations.variance * _solve(information[np.ix_(free, free)], np.eye(len(free)))
    return LinkageSolution(shared, alpha, equations, covariance)


def fit_angles(
    scene: Scene, observed: ObservedCorners, shared: SharedParameters, alpha: Array, course: Array, scale: float
) -> tuple[Array, LinkageEquations]:
    """Angles of each frame, (F, N), rad, with the shared parameters held, and the normal equations there."""
    for _ in range(MAX_ITERATIONS):
        r = (observed.image - scene.image(shared, alpha, course)) * observed.visible[..., None]
        z = np.abs(r) / observed.sigma
        weight = np.sqrt(np.minimum(1.0, HUBER_KNEE_SIGMA * (scale + 1e-12) / np.maximum(z, 1e-12)))[..., None]
        Ja = _white(observed, scene.by_angles(shared, alpha, course) * weight)
        e = _white(observed, r[..., None] * weight)
        JaT = np.swapaxes(Ja, 1, 2)
        step = (inverse_normals(JaT @ Ja) @ (JaT @ e))[..., 0]
        alpha = np.clip(alpha + np.clip(step, -MAX_STEP, MAX_STEP), -MAX_ALPHA, MAX_ALPHA)
        if np.max(np.abs(step), initial=0.0) < 1e-9:
            break
    return alpha, linkage_equations(scene, observed, shared, alpha, course, 0, scale)


def refine_over_recording(
    scene: Scene,
    corners_of: Callable[[NDArray[np.intp]], ObservedCorners],
    fit: LinkageSolution,
    alpha: Array,
    course: Array,
    prior: SharedPrior,
    block: NDArray[np.intp],
) -> tuple[SharedParameters, Array, float]:
    """A fit of some frames continued over all frames, chunk by chunk: shared parameters, their covariance (p, p), the variance.

    corners_of: gives the corners of some frames; alpha: initial angles of all frames, (F, N), rad; course: (F, terms); block:
    (F,), the block of frames with correlated errors to which each frame belongs (`frame_blocks`).
    """
    shared, variance, count = fit.shared, fit.equations.variance, int(prior.free.sum())
    free = np.flatnonzero(prior.free)
    covariance = np.zeros_like(fit.covariance)
    for _ in range(MAX_REFINEMENTS):
        squares, freedom = [], []
        score = np.zeros((block.max() + 1, len(shared.vector)))
        information = np.zeros((*score.shape, score.shape[1]))
        for start in range(0, len(alpha), CHUNK_FRAMES):
            frames = np.arange(start, min(start + CHUNK_FRAMES, len(alpha)))
            part = corners_of(frames)
            scale = float(np.sqrt(variance))
            alpha[frames], equations = fit_angles(scene, part, shared, alpha[frames], course[frames], scale)
            np.add.at(information, block[frames], equations.reduced)
            np.add.at(score, block[frames], equations.g_reduced)
            squares.append(equations.squares)
            freedom.append(degrees_of_freedom(part, alpha.shape[1]))
        total_freedom = np.concatenate(freedom)
        total_freedom = total_freedom * max(1 - count / max(total_freedom.sum(), 1.0), 0.1)
        variance = _variance(np.concatenate(squares), total_freedom)
        weight = prior.information * variance
        total = (information.sum(axis=0) + np.diag(weight))[np.ix_(free, free)]
        right = score.sum(axis=0) + weight * (prior.mean - shared.vector)
        change = np.zeros(len(right))
        change[free] = _solve(total, right[free])
        shared = shared.plus(change)
        covariance = shared_covariance(information, score - information @ change, prior, variance)
        if np.max(np.abs(change[free]) / np.sqrt(np.diag(covariance)[free])) < 0.01:
            break
    return shared, covariance, variance


def shared_covariance(information: Array, score: Array, prior: SharedPrior, variance: float) -> Array:
    """Covariance (p, p) of the shared parameters clustered by blocks; zero rows for parameters that were not free."""
    free = np.flatnonzero(prior.free)
    covariance = np.zeros((len(prior.mean), len(prior.mean)))
    part = np.ix_(free, free)
    covariance[part] = clustered_covariance(information[:, *part], score[:, free], prior.information[free], variance)
    return covariance


def extend_prior(prior: SharedPrior, information: Array) -> SharedPrior:
    """The prior with n more shared parameters at the end, of mean zero and the given information (n,)."""
    return replace(
        prior,
        mean=np.append(prior.mean, np.zeros(len(information))),
        information=np.append(prior.information, information),
        free=np.append(prior.free, np.ones(len(information), dtype=bool)),
    )


def inverse_normals(normal: Array, unknown: float = 0.0) -> Array:
    """Inverses of symmetric matrices (F, N, N); a direction without information gets the variance `unknown`."""
    w, v = np.linalg.eigh(normal)
    informed = w > 1e-9 * np.maximum(w[:, -1:], 1e-300)
    inverted = np.where(informed, 1 / np.where(informed, w, 1.0), unknown)
    return np.einsum("fik,fk,fjk->fij", v, inverted, v)


def _variance(squares: Array, free: Array) -> float:
    variance = median_variance(squares, free)
    return max(variance, MIN_VARIANCE) if np.isfinite(variance) else 1.0


def _with_prior(equations: LinkageEquations, prior: SharedPrior, shared: SharedParameters) -> tuple[Array, Array]:
    """Normal matrix (p, p) and right-hand side (p,) of the shared parameters over all frames, the prior included."""
    weight = prior.information * equations.variance
    return (
        equations.reduced.sum(axis=0) + np.diag(weight),
        equations.g_reduced.sum(axis=0) + weight * (prior.mean - shared.vector),
    )


def _solve(information: Array, right: Array) -> Array:
    """information^-1 right, with the unknowns scaled to equal information."""
    scale = np.sqrt(np.maximum(np.diag(information), 1e-300))
    scaled = np.linalg.solve(information / np.outer(scale, scale), (right.T / scale).T)
    return (scaled.T / scale).T


def _white(observed: ObservedCorners, slopes: Complex) -> Array:
    """Whitened rows, (F, 8 markers, n), of complex derivatives (F, markers, 4, n)."""
    rows = np.stack([slopes.real, slopes.imag], axis=3).reshape(*slopes.shape[:2], 8, slopes.shape[-1])
    return (observed.whitener @ rows).reshape(len(slopes), -1, slopes.shape[-1])
