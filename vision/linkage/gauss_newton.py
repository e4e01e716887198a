"""Gauss-Newton over all frames at once: what they share couples them, each frame's angles stand alone.

The angles are eliminated frame by frame with a Schur complement, so that cost grows linearly with the frames. Numbers
with a prior stay where the prior puts them as far as the frames leave them undetermined.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from vision.linkage.block_covariance import clustered
from vision.linkage.observed_corners import PORTION, Observed
from vision.linkage.scene import Scene, Shared

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

ROUNDS = 40
HUBER = 5.0
"""standard deviations from which on a corner pulls with constant force only"""
POLISHING = 4
LEAST_VARIANCE = 1e-8
"""of exact corners, so that a prior keeps its say"""


@dataclass(frozen=True)
class Prior:
    """What is known of the shared numbers beforehand, in the order of `Shared.vector`."""

    mean: Array
    """(p,)"""
    information: Array
    """(p,): 1/sigma^2; zero where nothing is known"""
    free: NDArray[np.bool_]
    """(p,): which ones a fit may move"""


@dataclass(frozen=True)
class Linear:
    """Normal equations at one point; products are of whitened corners, not yet divided by their variance."""

    residual: Complex
    """(F, markers, 4), normalised coordinates, zero where not seen"""
    squares: Array
    """(F,): whitened squares of each frame, robust weights in"""
    variance: float
    """of a whitened number, from the median frame"""
    normal: Array
    """(F, N, N): by the angles"""
    solved: Array
    """(F, N, N): its inverse, zero in directions without information"""
    mixed: Array
    """(F, N, p): between angles and shared"""
    g_angles: Array
    """(F, N)"""
    reduced: Array
    """(F, p, p): of the shared numbers, each frame's angles eliminated"""
    g_reduced: Array
    """(F, p)"""


@dataclass(frozen=True)
class LinkageSolution:
    """Where Gauss-Newton ended."""

    shared: Shared
    alpha: Array
    at: Linear
    covariance: Array
    """(p, p) of `shared.vector`; zero rows for what was not free"""


def freedom(observed: Observed, unknowns: int, shared: int = 0) -> Array:
    """Degrees of freedom of each frame's residual, (F,), at least zero; the shared unknowns cost every frame its part."""
    own = np.maximum(observed.rank.sum(axis=1) - unknowns, 0).astype(float)
    return own * max(1 - shared / max(own.sum(), 1.0), 0.1)


def typical_variance(squares: Array, free: Array) -> float:
    """Variance of a whitened number by the median frame, so that a few wrong frames do not inflate all; NaN without one."""
    able = free > 0.5
    if not able.any():
        return float("nan")
    # the median of chi-square lies below its mean
    return float(np.median(squares[able] / chi2.median(free[able])))


def linearise(
    scene: Scene,
    observed: Observed,
    shared: Shared,
    alpha: Array,
    course: Array,
    count: int,
    scale: float | None = None,
) -> Linear:
    """Normal equations at `shared` and `alpha`, (F, N); `scale`: standard deviations as of a fit before, else from here.

    `count`: how many shared numbers were estimated from these frames, for the degrees of freedom.
    """
    r = (observed.image - scene.image(shared, alpha, course)) * observed.seen[..., None]
    z = np.abs(r) / observed.sigma
    if scale is None:
        scale = float(np.median(z[observed.seen])) / 1.177 if observed.seen.any() else 1.0  # median of Rayleigh's law
    weight = np.sqrt(np.minimum(1.0, HUBER * (scale + 1e-12) / np.maximum(z, 1e-12)))[..., None]
    Ja = _white(observed, scene.by_angles(shared, alpha, course) * weight)
    Js = _white(observed, scene.by_shared(shared, alpha, course) * weight)
    e = _white(observed, r[..., None] * weight)[..., 0]
    JaT = np.swapaxes(Ja, 1, 2)
    normal, mixed, g_angles = JaT @ Ja, JaT @ Js, (JaT @ e[..., None])[..., 0]
    solved = inverse(normal)
    back = np.swapaxes(mixed, 1, 2) @ solved
    squares = np.sum(e**2, axis=1)
    return Linear(
        residual=r,
        squares=squares,
        variance=_variance(squares, freedom(observed, alpha.shape[1], count)),
        normal=normal,
        solved=solved,
        mixed=mixed,
        g_angles=g_angles,
        reduced=np.swapaxes(Js, 1, 2) @ Js - back @ mixed,
        g_reduced=(np.swapaxes(Js, 1, 2) @ e[..., None] - back @ g_angles[..., None])[..., 0],
    )


@dataclass(frozen=True)
class Offsets:
    """How corner offsets that stay the same over all frames, normalised coordinates, 8 a marker, pull on what is estimated.

    They do not average out: the codec's error on a marker that stands still, light, the lens model.
    """

    reduced: Array
    """(p, p): normal equations of the shared numbers, the angles eliminated"""
    on_shared: Array
    """(p, 8 markers): the pull on them"""
    on_angles: Array
    """(F, N, 8 markers): d angle / d offset with the shared numbers held"""


def offsets(scene: Scene, observed: Observed, shared: Shared, alpha: Array, course: Array) -> Offsets:
    """At `shared` and `alpha`, (F, N)."""
    count = observed.image.shape[1]
    unit = np.zeros((count, 4, 8 * count), dtype=complex)
    for k in range(count):
        for c in range(4):
            unit[k, c, 8 * k + 2 * c], unit[k, c, 8 * k + 2 * c + 1] = 1.0, 1.0j
    Ja = _white(observed, scene.by_angles(shared, alpha, course))
    Js = _white(observed, scene.by_shared(shared, alpha, course))
    E = _white(observed, np.broadcast_to(unit, (len(alpha), *unit.shape)))
    JaT, JsT = np.swapaxes(Ja, 1, 2), np.swapaxes(Js, 1, 2)
    on_angles = inverse(JaT @ Ja) @ (JaT @ E)
    reduced = JsT @ (Js - Ja @ (inverse(JaT @ Ja) @ (JaT @ Js)))
    return Offsets(np.sum(reduced, axis=0), np.sum(JsT @ (E - Ja @ on_angles), axis=0), on_angles)


def gauss_newton(
    scene: Scene, observed: Observed, shared: Shared, alpha: Array, course: Array, prior: Prior
) -> LinkageSolution:
    """The best shared numbers and angles, from a start. course: (F, terms)."""
    live = np.flatnonzero(prior.free)
    for _ in range(ROUNDS):
        k = linearise(scene, observed, shared, alpha, course, len(live))
        change = np.zeros(len(prior.mean))
        information, pull = _with_prior(k, prior, shared)
        change[live] = _solve(information[np.ix_(live, live)], pull[live])
        turn = np.einsum("fnm,fm->fn", k.solved, k.g_angles - k.mixed @ change)
        shared = shared.moved(change)
        alpha = np.clip(alpha + np.clip(turn, -0.5, 0.5), -2.8, 2.8)
        if max(np.max(np.abs(turn), initial=0.0), np.max(np.abs(change), initial=0.0)) < 1e-8:
            break
    k = linearise(scene, observed, shared, alpha, course, len(live))
    covariance = np.zeros((len(prior.mean), len(prior.mean)))
    information, _ = _with_prior(k, prior, shared)
    covariance[np.ix_(live, live)] = k.variance * _solve(information[np.ix_(live, live)], np.eye(len(live)))
    return LinkageSolution(shared, alpha, k, covariance)


def frame_angles(
    scene: Scene, observed: Observed, shared: Shared, alpha: Array, course: Array, scale: float
) -> tuple[Array, Linear]:
    """Angles of each frame, (F, N), with what the frames share held fast, and the normal equations there."""
    for _ in range(ROUNDS):
        r = (observed.image - scene.image(shared, alpha, course)) * observed.seen[..., None]
        z = np.abs(r) / observed.sigma
        weight = np.sqrt(np.minimum(1.0, HUBER * (scale + 1e-12) / np.maximum(z, 1e-12)))[..., None]
        Ja = _white(observed, scene.by_angles(shared, alpha, course) * weight)
        e = _white(observed, r[..., None] * weight)
        JaT = np.swapaxes(Ja, 1, 2)
        turn = (inverse(JaT @ Ja) @ (JaT @ e))[..., 0]
        alpha = np.clip(alpha + np.clip(turn, -0.5, 0.5), -2.8, 2.8)
        if np.max(np.abs(turn), initial=0.0) < 1e-9:
            break
    return alpha, linearise(scene, observed, shared, alpha, course, 0, scale)


def polished(
    scene: Scene,
    take: Callable[[NDArray[np.intp]], Observed],
    fit: LinkageSolution,
    alpha: Array,
    course: Array,
    prior: Prior,
    block: NDArray[np.intp],
) -> tuple[Shared, Array, float]:
    """A fit of some frames carried on over all, portion by portion: shared numbers, their covariance (p, p), the variance.

    take: the corners of given frames; alpha: first angles of all frames, (F, N); course: of all frames, (F, terms); block: of
    all frames, (F,), which ones' errors may go together (`blocks_of`).
    """
    shared, variance, count = fit.shared, fit.at.variance, int(prior.free.sum())
    live = np.flatnonzero(prior.free)
    covariance = np.zeros_like(fit.covariance)
    for _ in range(POLISHING):
        squares, free = [], []
        score = np.zeros((block.max() + 1, len(shared.vector)))
        information = np.zeros((*score.shape, score.shape[1]))
        for start in range(0, len(alpha), PORTION):
            frames = np.arange(start, min(start + PORTION, len(alpha)))
            part = take(frames)
            scale = float(np.sqrt(variance))
            alpha[frames], k = frame_angles(scene, part, shared, alpha[frames], course[frames], scale)
            np.add.at(information, block[frames], k.reduced)
            np.add.at(score, block[frames], k.g_reduced)
            squares.append(k.squares)
            free.append(freedom(part, alpha.shape[1]))
        left = np.concatenate(free)
        left = left * max(1 - count / max(left.sum(), 1.0), 0.1)
        variance = _variance(np.concatenate(squares), left)
        weight = prior.information * variance
        total = (information.sum(axis=0) + np.diag(weight))[np.ix_(live, live)]
        pull = score.sum(axis=0) + weight * (prior.mean - shared.vector)
        change = np.zeros(len(pull))
        change[live] = _solve(total, pull[live])
        shared = shared.moved(change)
        covariance = by_blocks(information, score - information @ change, prior, variance)
        if np.max(np.abs(change[live]) / np.sqrt(np.diag(covariance)[live])) < 0.01:
            break
    return shared, covariance, variance


def by_blocks(information: Array, score: Array, prior: Prior, variance: float) -> Array:
    """`clustered` covariance (p, p) of the shared numbers, zero rows for what was not free."""
    live = np.flatnonzero(prior.free)
    covariance = np.zeros((len(prior.mean), len(prior.mean)))
    part = np.ix_(live, live)
    covariance[part] = clustered(information[:, *part], score[:, live], prior.information[live], variance)
    return covariance


def extended(prior: Prior, information: Array) -> Prior:
    """With more shared numbers at the end, about zero, of the given information (n,)."""
    return replace(
        prior,
        mean=np.append(prior.mean, np.zeros(len(information))),
        information=np.append(prior.information, information),
        free=np.append(prior.free, np.ones(len(information), dtype=bool)),
    )


def inverse(normal: Array, unknown: float = 0.0) -> Array:
    """Inverses of (F, N, N); a direction without information gets the variance `unknown`."""
    w, v = np.linalg.eigh(normal)
    live = w > 1e-9 * np.maximum(w[:, -1:], 1e-300)
    inverted = np.where(live, 1 / np.where(live, w, 1.0), unknown)
    return np.einsum("fik,fk,fjk->fij", v, inverted, v)


def _variance(squares: Array, free: Array) -> float:
    found = typical_variance(squares, free)
    return max(found, LEAST_VARIANCE) if np.isfinite(found) else 1.0


def _with_prior(k: Linear, prior: Prior, shared: Shared) -> tuple[Array, Array]:
    weight = prior.information * k.variance
    return (
        k.reduced.sum(axis=0) + np.diag(weight),
        k.g_reduced.sum(axis=0) + weight * (prior.mean - shared.vector),
    )


def _solve(information: Array, right: Array) -> Array:
    """information^-1 right, the unknowns first scaled alike."""
    scale = np.sqrt(np.maximum(np.diag(information), 1e-300))
    scaled = np.linalg.solve(information / np.outer(scale, scale), (right.T / scale).T)
    return (scaled.T / scale).T


def _white(observed: Observed, by: Complex) -> Array:
    """Whitened rows, (F, 8 markers, n), of complex derivatives (F, markers, 4, n)."""
    rows = np.stack([by.real, by.imag], axis=3).reshape(*by.shape[:2], 8, by.shape[-1])
    return (observed.whitener @ rows).reshape(len(by), -1, by.shape[-1])
