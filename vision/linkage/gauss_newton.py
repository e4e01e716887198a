"""Gauss-Newton for the linkage's fit: over some frames with their angles, and from there over all frames of a recording.

A parameter with a prior stays at the prior's mean as far as the frames leave it undetermined.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vision.linkage.block_covariance import clustered_covariance
from vision.linkage.linkage_equations import (
    LinkageEquations,
    bounded_variance,
    degrees_of_freedom,
    inverse_normals,
    linkage_equations,
    robust_loss,
    robust_weights,
    whiten,
)
from vision.linkage.observed_corners import CHUNK_FRAMES, ObservedCorners
from vision.linkage.scene import Scene, SharedParameters

Array = NDArray[np.float64]

MAX_ITERATIONS = 40
MAX_STEP = 0.5
"""rad, of an angle in one iteration"""
MIN_STEP = 1e-9
"""rad, of a frame's angles: a smaller step was its last"""
MIN_GAIN = 1e-4
"""variances of the corners: a step that promises no more moves nothing by a hundredth of its sigma, and is the last"""
NEAR_GAIN = 1.0
"""variances of the corners: a step that promises no more is taken whole, whatever it leaves"""
MIN_STEP_SHARE = 0.05
"""a step that leaves more is halved, but for a share so small"""
MAX_ALPHA = 2.8
"""rad; short of the singular half turn (docs/thresholds.md)"""
MAX_REFINEMENTS = 4
"""passes over all frames at most"""


@dataclass(frozen=True)
class SharedPrior:
    """Gaussian prior of the p shared parameters, in the order of `SharedParameters.vector`."""

    mean: Array
    """(p,)"""
    information: Array
    """(p,): 1/sigma^2; zero where nothing is known"""
    free: NDArray[np.bool_]
    """(p,): which parameters a fit may change"""
    wider: Array
    """(p,): variance of what is known over 1/information; more than one where a fit holds to it more than it is known"""


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


def fit_frames(
    scene: Scene, observed: ObservedCorners, shared: SharedParameters, alpha: Array, course: Array, prior: SharedPrior
) -> LinkageSolution:
    """The best shared parameters and angles from a start; course: share of each drift term that a frame has, (F, terms)."""
    free = np.flatnonzero(prior.free)
    equations = linkage_equations(scene, observed, shared, alpha, course, len(free))
    for _ in range(MAX_ITERATIONS):
        change = np.zeros(len(prior.mean))
        information, right = _with_prior(equations, prior, shared)
        change[free] = solve_scaled(information[np.ix_(free, free)], right[free])
        step = np.einsum("fnm,fm->fn", equations.inverse, equations.g_angles - equations.mixed @ change)
        promised = right @ change + np.einsum("fn,fnm,fm->", equations.g_angles, equations.inverse, equations.g_angles)
        step = np.clip(step, -MAX_STEP, MAX_STEP)
        before, left, share = equations, _left(observed, equations, equations, prior, shared), 1.0
        while True:
            then, angles = shared.plus(share * change), np.clip(alpha + share * step, -MAX_ALPHA, MAX_ALPHA)
            after = linkage_equations(scene, observed, then, angles, course, len(free))
            whole = share < MIN_STEP_SHARE or promised < NEAR_GAIN * before.variance
            if whole or _left(observed, after, before, prior, then) <= left:
                break
            share /= 2
        shared, alpha, equations = then, angles, after
        if promised < MIN_GAIN * before.variance:
            break
    covariance = np.zeros((len(prior.mean), len(prior.mean)))
    information, _ = _with_prior(equations, prior, shared)
    covariance[np.ix_(free, free)] = equations.variance * solve_scaled(
        information[np.ix_(free, free)], np.eye(len(free))
    )
    return LinkageSolution(shared, alpha, equations, covariance)


def fit_angles(
    scene: Scene, observed: ObservedCorners, shared: SharedParameters, alpha: Array, course: Array, scale: float
) -> tuple[Array, LinkageEquations]:
    """Angles of each frame, (F, N), rad, with the shared parameters held, and the normal equations there."""
    alpha, moving = alpha.copy(), np.arange(len(alpha))
    for _ in range(MAX_ITERATIONS):
        part, at, go = observed.of(moving), alpha[moving], course[moving]
        r = (part.image - scene.image(shared, at, go)) * part.visible[..., None]
        weight = np.sqrt(robust_weights(part, r, scale))[..., None]
        Ja = whiten(part, scene.by_angles(shared, at, go) * weight)
        e = whiten(part, r[..., None] * weight)
        JaT = np.swapaxes(Ja, 1, 2)
        step = (inverse_normals(JaT @ Ja) @ (JaT @ e))[..., 0]
        alpha[moving] = np.clip(at + np.clip(step, -MAX_STEP, MAX_STEP), -MAX_ALPHA, MAX_ALPHA)
        moving = moving[np.max(np.abs(step), axis=1, initial=0.0) > MIN_STEP]
        if not len(moving):
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
        variance = bounded_variance(np.concatenate(squares), total_freedom)
        weight = prior.information * variance
        total = (information.sum(axis=0) + np.diag(weight))[np.ix_(free, free)]
        right = score.sum(axis=0) + weight * (prior.mean - shared.vector)
        change = np.zeros(len(right))
        change[free] = solve_scaled(total, right[free])
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
    covariance[part] = clustered_covariance(
        information[:, *part], score[:, free], prior.information[free], variance, prior.wider[free]
    )
    return covariance


def extend_prior(prior: SharedPrior, information: Array) -> SharedPrior:
    """The prior with n more shared parameters at the end, of mean zero and the given information (n,)."""
    return replace(
        prior,
        mean=np.append(prior.mean, np.zeros(len(information))),
        information=np.append(prior.information, information),
        free=np.append(prior.free, np.ones(len(information), dtype=bool)),
        wider=np.append(prior.wider, np.ones(len(information))),
    )


def _left(
    observed: ObservedCorners,
    equations: LinkageEquations,
    weighed_by: LinkageEquations,
    prior: SharedPrior,
    shared: SharedParameters,
) -> float:
    """What corners and the prior leave, in units of the whitened corners' squares; by the scale and variance of other equations."""
    of_prior = np.sum(prior.information * (shared.vector - prior.mean) ** 2)
    return robust_loss(observed, equations.residual, weighed_by.scale) + float(weighed_by.variance * of_prior)


def _with_prior(equations: LinkageEquations, prior: SharedPrior, shared: SharedParameters) -> tuple[Array, Array]:
    """Normal matrix (p, p) and right-hand side (p,) of the shared parameters over all frames, the prior included."""
    weight = prior.information * equations.variance
    return (
        equations.reduced.sum(axis=0) + np.diag(weight),
        equations.g_reduced.sum(axis=0) + weight * (prior.mean - shared.vector),
    )


def solve_scaled(information: Array, right: Array) -> Array:
    """information^-1 right, with the unknowns scaled to equal information."""
    scale = np.sqrt(np.maximum(np.diag(information), 1e-300))
    scaled = np.linalg.solve(information / np.outer(scale, scale), (right.T / scale).T)
    return (scaled.T / scale).T
