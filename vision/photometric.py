"""Corners of markers from all of their grey levels: each marker's picture, as the template has it, fitted by Gauss-Newton.

Unknown are the motion of the marker (eight numbers, `planar_motion`), a plane of light on black and one on white, and small
changes of blur and bleed against what the recording shares. Pixels that the model does not explain, a cable or a shadow,
lose their weight. The covariance is measured from the scores of picture blocks, so that it holds for compressed pictures too.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.edges import refine
from vision.pixels import Pixels, select
from vision.planar_motion import CORNERS, DOF, corner_slopes, homography, moved, project
from vision.robust import EFFICIENT, block_inflation, scale_of, slope_share, tukey, with_neighbours
from vision.template import Optics, look_up

Array = NDArray[np.float64]
Single = NDArray[np.float32]

ROUNDS = 8
SETTLED = 0.03
"""px; a step below this is the last, since a tenth of it is what remains"""
MOVING = 0.3
"""px; a last step above this means that it did not converge"""
RESELECT = 0.4
"""px; further from where the pixels were chosen, they are chosen anew"""
RESELECTIONS = 3
"""rounds after which that may happen"""
PERSPECTIVE_SD = 0.05
"""how far the perspective terms may be from those of the start; holds small markers, big ones know better"""
FEW = 20
"""pixels of black or white, below which there is no marker"""
MIN_SIDE = 8.0
"""px"""
MIN_CONTRAST = 12.0
"""grey levels between black and white, below which there is nothing to fit"""
MAX_ERROR_SHARE = 0.25
"""residual scale over contrast, above which what is fitted is not this marker"""
SLOPE_SD = 0.2
"""change of the light from a marker's middle to its side, as a share of the contrast: what is to be expected"""
STIFF = 0.002
"""the same in the first round, so that a thing across the marker is not taken for a slope of the light"""
FIRST_SCALE = 0.09
"""share of the contrast that the first round takes for the residuals' scale: a start's error, not a thing across"""
MIN_WEIGHT = 0.4
"""share of the pixels' weight that must be left"""
BLURRED = 1.5
"""px over the exposure, from which on a marker counts as blurred"""
EDGE_SD, LOST_SD = 0.15, 1.0
"""px: corners of the fallback, from the square's edges or as they were"""


@dataclass(frozen=True)
class Start:
    """Where a marker is about to be found."""

    corners: Array
    """(4, 2), px, in OpenCV's order, within half a cell"""
    cells: NDArray[np.bool_]
    """(n, n), True is black, as `marker_cells` gives them"""
    motion: Array
    """(4, 2), px: how far each corner moves during the exposure; corners are those in its middle. Their mean is what blurs"""


@dataclass(frozen=True)
class MarkerFit:
    """A marker's corners and what they rest on."""

    corners: Array
    """(4, 2), px"""
    covariance: Array
    """(8, 8), px^2, of x and y of the first corner, and so on"""
    rms: float
    """of the residual, weighted, grey levels"""
    contrast: float
    """between black and white, grey levels"""
    sigma: float
    """of the lens' blur, px, as this marker shows it"""
    bleed: float
    """px, as this marker shows it"""
    optics_sd: Array
    """standard deviations of sigma and bleed, (2,), px; the optics that were passed in included"""
    hidden: float
    """share of the pixels' weight that robust weighting took away"""
    clipped: float
    """share of the pixels that are black or white to the limit"""
    blurred: bool
    fell_back: bool
    """True where the fit failed and the corners are those of the edges, or of the start"""


def fit_markers(grey: NDArray[np.uint8], starts: Sequence[Start], optics: Optics) -> list[MarkerFit]:
    """Markers of one picture, (height, width) uint8; all are fitted side by side."""
    able = [k for k, start in enumerate(starts) if _is_square(start.corners)]
    fits: dict[int, MarkerFit] = {}
    if able:
        chosen = [starts[k] for k in able]
        state = _gauss_newton(grey, chosen, optics)
        for m, k in enumerate(able):
            if _sound(state, m, chosen[m]):
                fits[k] = _result(state, m, chosen[m], optics)
    return [fits[k] if k in fits else _fallback(grey, start, optics) for k, start in enumerate(starts)]


def _is_square(corners: Array) -> bool:
    """Finite and clockwise at every corner, with sides of some pixels."""
    side = np.roll(corners, -1, axis=0) - corners
    following = np.roll(side, -1, axis=0)
    return bool(np.all(side[:, 0] * following[:, 1] - side[:, 1] * following[:, 0] > MIN_SIDE**2 / 2))


@dataclass(frozen=True)
class _State:
    """The last round, markers first."""

    pixels: Pixels
    corners: Array
    """(M, 4, 2), px"""
    covariance: Array
    """(M, 8, 8), px^2"""
    solution: Array
    """(M, columns)"""
    spread: Array
    """(M, 2): standard deviations of the columns blur and bleed"""
    scale: Array
    """(M,): of the residual, grey levels"""
    rms: Array
    weight: Array
    """(M,): share of the weight left, 1 where nothing but noise is"""
    settled: NDArray[np.bool_]


HEAT, INK, LIGHT = DOF, DOF + 1, slice(DOF + 2, DOF + 8)
"""columns: the blur's variance, the bleed, and the light's 1, u, v times black and white, then white alone"""
COLUMNS = DOF + 8
WHITE = DOF + 5


def _gauss_newton(grey: NDArray[np.uint8], starts: Sequence[Start], optics: Optics) -> _State:
    corners = np.stack([s.corners for s in starts]).astype(float)
    motion = np.stack([s.motion for s in starts]).astype(float)
    pixels = select(grey, [s.cells for s in starts], corners, motion, optics)
    chosen_at = corners
    count = np.maximum(pixels.used.sum(axis=1), 1)
    light = np.zeros((len(starts), 3))
    prior = np.zeros((len(starts), COLUMNS))
    prior[:, 6:DOF] = PERSPECTIVE_SD**-2
    prior[:, HEAT] = (2 * optics.sigma * optics.sigma_sd) ** -2
    prior[:, INK] = optics.bleed_sd**-2
    known = np.zeros((len(starts), COLUMNS))
    known[:, HEAT] = -pixels.excess
    scale, weight = np.ones(len(starts)), pixels.used.astype(float)
    slopes = [LIGHT.start + 1, LIGHT.start + 2, WHITE + 1, WHITE + 2]
    turn, fresh = 0, True
    while True:
        turn += 1
        H = homography(corners)
        D = _columns(pixels, H, np.tile([1.0, 0.0, 0.0], (len(H), 1)) if fresh else light)
        if fresh:
            light = np.zeros((len(H), 3))
            light[:, 0], scale, weight = _first_light(D, pixels)
            D[:, : LIGHT.start] *= light[:, :1, None].astype(np.float32)
        slope_sd = (STIFF if fresh else SLOPE_SD) * np.maximum(light[:, :1], MIN_CONTRAST)
        prior[:, slopes] = slope_sd**-2
        # the perspective's prior holds about the start, so it is carried along
        inverse, solution, residual = _solve(D, pixels.grey, weight, prior * scale[:, None] ** 2, known)
        scale = scale_of(residual, pixels.used)
        xi = np.clip(np.nan_to_num(solution[:, :DOF]), -0.2, 0.2)
        corners = moved(H, xi)
        known[:, 6:DOF] -= xi[:, 6:]
        light = solution[:, WHITE : WHITE + 3]
        step = np.abs(corners - project(H, np.broadcast_to(CORNERS, (len(H), 4, 2)))).max(axis=(1, 2))
        last = not fresh and float(step.max()) < SETTLED
        if last or turn == ROUNDS:
            break
        if turn <= RESELECTIONS and np.abs(corners - chosen_at).max() > RESELECT:
            pixels = select(grey, [s.cells for s in starts], corners, motion, optics)
            chosen_at, count = corners, np.maximum(pixels.used.sum(axis=1), 1)
            known[:, HEAT] = -pixels.excess
            fresh = True
            continue
        fresh = False
        weight = with_neighbours(tukey(residual, scale) * pixels.used, pixels.used, pixels.x, pixels.y)
    inflation = block_inflation(D, inverse, weight * residual, weight, pixels.block, pixels.blocks)
    inflation = inflation / slope_share(residual, scale, pixels.used) ** 2
    slopes = corner_slopes(H)
    covariance = slopes @ (inverse[:, :DOF, :DOF] * inflation[:, None, None]) @ np.swapaxes(slopes, 1, 2)
    total = np.maximum(weight.sum(axis=1), 1e-9)
    return _State(
        pixels=pixels,
        corners=corners,
        covariance=covariance,
        solution=solution,
        spread=np.sqrt(np.maximum(inverse[:, [HEAT, INK], [HEAT, INK]] * inflation[:, None], 0)),
        scale=scale,
        rms=np.sqrt(np.sum(weight * residual**2, axis=1) / total),
        weight=total / count / EFFICIENT,
        settled=np.asarray(step < MOVING),
    )


def _first_light(D: Single, pixels: Pixels) -> tuple[Array, Array, Array]:
    """Contrast and scale (M,), and weights (M, N), from the middle levels of what ought to be black and white."""
    contrast = np.ones(len(D))
    weight = pixels.used.astype(float)
    for k, (value, grey, used) in enumerate(zip(D[:, WHITE], pixels.grey, pixels.used, strict=True)):
        black, white = grey[used & (value < 0.15)], grey[used & (value > 0.85)]
        if min(len(black), len(white)) < FEW:
            continue
        low = float(np.median(black))
        contrast[k] = max(float(np.median(white)) - low, 1.0)
        weight[k] *= tukey((grey - low - contrast[k] * value)[None], np.array([FIRST_SCALE * contrast[k]]))[0]
    weight = with_neighbours(weight, pixels.used, pixels.x, pixels.y)
    return contrast, FIRST_SCALE * contrast, weight


def _columns(pixels: Pixels, H: Array, light: Array) -> Single:
    """The model's derivatives, (M, COLUMNS, N); motion, blur and bleed for the light at hand (M, 3: white's 1, u, v)."""
    u, v = (at.astype(np.float32) for at in pixels.seen_from(np.linalg.inv(H).astype(float)))
    D = np.empty((len(H), COLUMNS, u.shape[1]), dtype=np.float32)
    for k, texture in enumerate(pixels.textures):
        D[k, [WHITE, 0, 1, HEAT, INK]] = look_up(texture, u[k], v[k])
    one, along_u, along_v = light.astype(np.float32).T[..., None]
    white = one + along_u * u + along_v * v
    D[:, [HEAT, INK]] *= white[:, None]
    a, b = (np.multiply(D[:, k], -white, out=D[:, k]) for k in range(2))
    # the displacements of `planar_motion`, times the picture's slopes
    np.multiply(a, u, out=D[:, 2])
    np.multiply(a, v, out=D[:, 3])
    np.multiply(b, u, out=D[:, 4])
    np.multiply(b, v, out=D[:, 5])
    away = D[:, 2] + D[:, 5]
    np.multiply(away, u, out=D[:, 6])
    np.multiply(away, v, out=D[:, 7])
    D[:, LIGHT.start], D[:, LIGHT.start + 1], D[:, LIGHT.start + 2] = 1.0, u, v
    np.multiply(D[:, WHITE], u, out=D[:, WHITE + 1])
    np.multiply(D[:, WHITE], v, out=D[:, WHITE + 2])
    return D


def _solve(D: Single, grey: Array, weight: Array, prior: Array, known: Array) -> tuple[Array, Array, Array]:
    """Weighted least squares: inverse of the normal matrix (M, P, P), solution (M, P), residual (M, N)."""
    level = grey.mean(axis=1, keepdims=True)  # single precision serves differences
    weighted = D * weight[:, None].astype(np.float32)
    normal = (weighted @ np.swapaxes(D, 1, 2)).astype(float)
    right = (weighted @ (grey - level)[..., None].astype(np.float32)).astype(float)[..., 0]
    diagonal = np.einsum("mpp->mp", normal)
    diagonal += prior + 1e-9 * diagonal + 1e-12
    inverse = np.linalg.inv(normal)
    solution = (inverse @ (right + prior * known)[..., None])[..., 0]
    residual = grey - level - (solution[:, None].astype(np.float32) @ D)[:, 0]
    solution[:, LIGHT.start] += level[:, 0]
    return inverse, solution, residual


def _sound(state: _State, k: int, start: Start) -> bool:
    cell = np.mean(np.linalg.norm(np.roll(start.corners, -1, axis=0) - start.corners, axis=1)) / len(start.cells)
    reach = cell + np.abs(start.motion).max() / 2
    contrast = state.solution[k, WHITE]
    return bool(
        np.isfinite(state.covariance[k]).all()
        and state.settled[k]
        and np.abs(state.corners[k] - start.corners).max() < reach
        and contrast > MIN_CONTRAST
        and state.scale[k] < MAX_ERROR_SHARE * contrast
        and state.weight[k] > MIN_WEIGHT
        and state.pixels.inside[k] > 0.5
    )


def _result(state: _State, k: int, start: Start, optics: Optics) -> MarkerFit:
    variance = optics.sigma**2 + state.pixels.excess[k] + state.solution[k, HEAT]
    sigma = float(np.sqrt(max(variance, 0.01)))
    return MarkerFit(
        corners=state.corners[k],
        covariance=state.covariance[k],
        rms=float(state.rms[k]),
        contrast=float(state.solution[k, WHITE]),
        sigma=sigma,
        bleed=optics.bleed + float(state.solution[k, INK]),
        optics_sd=state.spread[k] * [1 / (2 * sigma), 1.0],
        hidden=float(np.clip(1 - state.weight[k], 0, 1)),
        clipped=float(state.pixels.clipped[k]),
        blurred=bool(np.linalg.norm(start.motion, axis=1).max() > BLURRED),
        fell_back=False,
    )


def _fallback(grey: NDArray[np.uint8], start: Start, optics: Optics) -> MarkerFit:
    corners = refine(grey, start.corners[None], len(start.cells))[0] if _is_square(start.corners) else start.corners
    smear = float(np.linalg.norm(start.motion, axis=1).max())
    sd = np.hypot(LOST_SD if np.array_equal(corners, start.corners, equal_nan=True) else EDGE_SD, smear / np.sqrt(12))
    return MarkerFit(
        corners=corners,
        covariance=sd**2 * np.eye(8),
        rms=float("nan"),
        contrast=float("nan"),
        sigma=optics.sigma,
        bleed=optics.bleed,
        optics_sd=np.array([optics.sigma_sd, optics.bleed_sd]),
        hidden=float("nan"),
        clipped=float("nan"),
        blurred=smear > BLURRED,
        fell_back=True,
    )
