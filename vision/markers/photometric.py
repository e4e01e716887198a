"""Corners of markers from all of their grey levels: each marker's picture, as the template has it, fitted by Gauss-Newton.

Unknown are the motion of the marker (eight numbers, `planar_motion`), a plane of light on black and one on white, and small
changes of blur and bleed against what the recording shares. Pixels that the model does not explain, a cable or a shadow,
lose their weight. The covariance is measured from the scores of picture blocks, so that it holds for compressed pictures too.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.markers.edges import refine
from vision.markers.pixels import Pixels, select
from vision.markers.planar_motion import DOF, corner_slopes, homography, moved
from vision.markers.robust import EFFICIENT, block_inflation, scale_of, slope_share, tukey, with_neighbours
from vision.markers.template import Optics, look_up

Array = NDArray[np.float64]
Single = NDArray[np.float32]

ROUNDS = 8
SETTLED = 0.08
"""px; after a step below this even the weights of a marker that is whole stay"""
WHOLE = 0.9
"""share of the weight that a marker has without a thing across"""
LINEAR = 0.15
"""px; within this of where the model's columns were computed they hold"""
ROUGHLY = 400
"""pixels of a marker that are enough for a first step"""
MOVING = 0.3
"""px; a last step above this means that it did not converge"""
RESELECT, RESELECT_LIT = 0.4, 0.8
"""px; further from where the pixels were chosen, they are chosen anew; the second where the light was known from the start"""
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
    light: Array | None = None
    """(6,), grey levels, as in `MarkerFit`, if it is known"""


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
    light: Array
    """(6,), grey levels: of black 1, u and v, in marker coordinates; what white has more"""
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
    if not starts:
        return []
    able = np.flatnonzero(_are_squares(np.stack([start.corners for start in starts]))).tolist()
    fits: dict[int, MarkerFit] = {}
    if able:
        chosen = [starts[k] for k in able]
        state = _gauss_newton(grey, chosen, optics)
        results = _results(state, chosen, optics)
        fits = {k: fit for k, fit, sound in zip(able, results, _sound(state, chosen), strict=True) if sound}
    return [fits[k] if k in fits else _fallback(grey, start, optics) for k, start in enumerate(starts)]


def _are_squares(corners: Array) -> NDArray[np.bool_]:
    """Which of (M, 4, 2) are finite and clockwise at every corner, with sides of some pixels."""
    side = corners[:, NEXT] - corners
    following = side[:, NEXT]
    return np.all(side[..., 0] * following[..., 1] - side[..., 1] * following[..., 0] > MIN_SIDE**2 / 2, axis=1)


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
SLOPES = [DOF + 3, DOF + 4, DOF + 6, DOF + 7]
UNKNOWN = np.full(6, np.nan)
NEXT = [1, 2, 3, 0]


def _gauss_newton(grey: NDArray[np.uint8], starts: Sequence[Start], optics: Optics) -> _State:
    corners = np.stack([s.corners for s in starts]).astype(float)
    motion = np.stack([s.motion for s in starts]).astype(float)
    cells = [s.cells for s in starts]
    pixels = select(grey, cells, corners, motion, optics)
    chosen_at = corners
    light = np.stack([UNKNOWN if s.light is None else s.light for s in starts]).astype(float)
    prior = np.zeros((len(starts), COLUMNS))
    prior[:, 6:DOF] = PERSPECTIVE_SD**-2
    prior[:, HEAT] = (2 * optics.sigma * optics.sigma_sd) ** -2
    prior[:, INK] = optics.bleed_sd**-2
    known = np.zeros((len(starts), COLUMNS))
    known[:, HEAT] = -pixels.excess
    reselect = RESELECT if np.isnan(light).any() else RESELECT_LIT
    turn, fresh, chosen = 0, True, pixels
    while True:
        turn += 1
        # the first step from a light that is known only brings the start nearer
        rough = fresh and not np.isnan(light).any()
        pixels = chosen.thinned(ROUGHLY) if rough else chosen
        H = homography(corners)
        picture = _Picture.of(pixels, H)
        light = _first_light(picture, pixels, light)
        residual = pixels.grey - picture.under(light)
        scale = FIRST_SCALE * light[:, 3] if fresh else scale_of(residual, pixels.used)
        weight = _weights(residual, scale, pixels)
        D = _columns(picture, pixels.grey, light)
        known[:, SLOPES] = light[:, [1, 2, 4, 5]] if fresh else 0.0
        # the perspective's prior holds about the start, so it is carried along
        _hold(prior, light, STIFF if fresh else SLOPE_SD)
        inverse, solution, residual = _solve(D, weight, prior * scale[:, None] ** 2, known)
        there = _step(H, solution)
        step = float(np.abs(there - corners).max())
        if (not fresh and step < LINEAR) or turn == ROUNDS:
            break
        known[:, 6:DOF] -= np.clip(np.nan_to_num(solution[:, 6:DOF]), -0.2, 0.2)
        corners, light, fresh = there, solution[:, LIGHT], False
        if turn <= RESELECTIONS and np.abs(corners - chosen_at).max() > reselect:
            chosen = select(grey, cells, corners, motion, optics)
            chosen_at = corners
            known[:, HEAT] = -chosen.excess
            light, fresh = np.full_like(light, np.nan), True
    scale = scale_of(residual, pixels.used)
    whole = weight.sum(axis=1) > WHOLE * EFFICIENT * np.count_nonzero(pixels.used, axis=1)
    if step > SETTLED or not whole.all():  # so near, the columns stay as they are and only the weights are renewed
        weight = _weights(residual, scale, pixels)
        _hold(prior, solution[:, LIGHT], SLOPE_SD)
        inverse, solution, residual = _solve(D, weight, prior * scale[:, None] ** 2, known)
        scale = scale_of(residual, pixels.used)
        there = _step(H, solution)
    inflation = block_inflation(D[:, :COLUMNS], inverse, weight, residual, pixels.blocks)
    inflation = inflation / slope_share(residual, scale, pixels.used) ** 2
    slopes = corner_slopes(H)
    covariance = slopes @ (inverse[:, :DOF, :DOF] * inflation[:, None, None]) @ np.swapaxes(slopes, 1, 2)
    total = np.maximum(weight.sum(axis=1, dtype=float), 1e-9)
    count = np.maximum(np.count_nonzero(pixels.used, axis=1), 1)
    return _State(
        pixels=pixels,
        corners=there,
        covariance=covariance,
        solution=solution,
        spread=np.sqrt(np.maximum(inverse[:, [HEAT, INK], [HEAT, INK]] * inflation[:, None], 0)),
        scale=scale,
        rms=np.sqrt(np.einsum("mn,mn,mn->m", weight, residual, residual) / total),
        weight=total / count / EFFICIENT,
        settled=np.abs(there - corners).max(axis=(1, 2)) < MOVING,
    )


def _weights(residual: Single, scale: Array, pixels: Pixels) -> Single:
    return with_neighbours(tukey(residual, scale) * pixels.used, pixels.used, *pixels.at)


def _hold(prior: Array, light: Array, slope_sd: float) -> None:
    prior[:, SLOPES] = (slope_sd * np.maximum(light[:, 3:4], MIN_CONTRAST)) ** -2


def _step(H: Array, solution: Array) -> Array:
    return moved(H, np.clip(np.nan_to_num(solution[:, :DOF]), -0.2, 0.2))


@dataclass(frozen=True)
class _Picture:
    """The templates at the pixels, markers first."""

    u: Single
    """(M, N)"""
    v: Single
    channels: Single
    """(M, 5, N): as `Texture` has them"""

    @classmethod
    def of(cls, pixels: Pixels, H: Array) -> "_Picture":
        u, v = pixels.seen_from(np.linalg.inv(H).astype(float))
        channels = np.empty((len(H), 5, u.shape[1]), dtype=np.float32)
        for k, texture in enumerate(pixels.textures):
            channels[k] = look_up(texture, u[k], v[k])
        return cls(u, v, channels)

    def under(self, light: Array) -> Single:
        """Grey levels under light (M, 6), (M, N)."""
        b0, bu, bv, w0, wu, wv = light.astype(np.float32).T[..., None]
        return b0 + bu * self.u + bv * self.v + (w0 + wu * self.u + wv * self.v) * self.channels[:, 0]


def _first_light(picture: _Picture, pixels: Pixels, light: Array) -> Array:
    """Light (M, 6) completed from the middle levels of what ought to be black and white."""
    unknown = np.flatnonzero(np.isnan(light[:, 0]))
    light = light.copy()
    for k in unknown:
        value, grey, used = picture.channels[k, 0], pixels.grey[k], pixels.used[k]
        black, white = grey[used & (value < 0.15)], grey[used & (value > 0.85)]
        enough = min(len(black), len(white)) >= FEW
        low, high = (float(np.median(black)), float(np.median(white))) if enough else (0.0, 0.0)
        light[k] = [low, 0.0, 0.0, max(high - low, 1.0), 0.0, 0.0]
    return light


def _columns(picture: _Picture, grey: Single, light: Array) -> Single:
    """The model's derivatives and at last the grey levels, (M, COLUMNS + 1, N); motion, blur and bleed under light (M, 6)."""
    u, v = picture.u, picture.v
    value, by_u, by_v, heat, ink = picture.channels.transpose(1, 0, 2)
    D = np.empty((len(u), COLUMNS + 1, u.shape[1]), dtype=np.float32)
    w0, wu, wv = light[:, 3:].astype(np.float32).T[..., None]
    white = w0 + wu * u + wv * v
    np.multiply(heat, white, out=D[:, HEAT])
    np.multiply(ink, white, out=D[:, INK])
    np.negative(white, out=white)
    a, b = np.multiply(by_u, white, out=D[:, 0]), np.multiply(by_v, white, out=D[:, 1])
    # the displacements of `planar_motion`, times the picture's slopes
    np.multiply(a, u, out=D[:, 2])
    np.multiply(a, v, out=D[:, 3])
    np.multiply(b, u, out=D[:, 4])
    np.multiply(b, v, out=D[:, 5])
    away = D[:, 2] + D[:, 5]
    np.multiply(away, u, out=D[:, 6])
    np.multiply(away, v, out=D[:, 7])
    D[:, LIGHT.start], D[:, LIGHT.start + 1], D[:, LIGHT.start + 2], D[:, WHITE] = 1.0, u, v, value
    np.multiply(value, u, out=D[:, WHITE + 1])
    np.multiply(value, v, out=D[:, WHITE + 2])
    D[:, COLUMNS] = grey
    return D


def _solve(D: Single, weight: Single, prior: Array, known: Array) -> tuple[Array, Array, Single]:
    """Weighted least squares: inverse of the normal matrix (M, P, P), solution (M, P), residual (M, N)."""
    weighted = D[:, :COLUMNS] * weight[:, None]
    product = (weighted @ np.swapaxes(D, 1, 2)).astype(float)
    normal, right = product[:, :, :COLUMNS], product[:, :, COLUMNS]
    diagonal = np.einsum("mpp->mp", normal)
    diagonal += prior + 1e-9 * diagonal + 1e-12
    inverse = np.linalg.inv(normal)
    solution = (inverse @ (right + prior * known)[..., None])[..., 0]
    by_all = np.ones((len(D), 1, COLUMNS + 1), dtype=np.float32)
    by_all[:, 0, :COLUMNS] = -solution
    return inverse, solution, (by_all @ D)[:, 0]


def _sound(state: _State, starts: Sequence[Start]) -> NDArray[np.bool_]:
    begun, motion = np.stack([s.corners for s in starts]), np.stack([s.motion for s in starts])
    side = begun[:, NEXT] - begun
    cell = np.sqrt((side**2).sum(axis=2)).mean(axis=1) / [len(s.cells) for s in starts]
    reach = cell + np.abs(motion).max(axis=(1, 2)) / 2
    contrast = state.solution[:, WHITE]
    return np.asarray(
        np.isfinite(state.covariance).all(axis=(1, 2))
        & state.settled
        & (np.abs(state.corners - begun).max(axis=(1, 2)) < reach)
        & (contrast > MIN_CONTRAST)
        & (state.scale < MAX_ERROR_SHARE * contrast)
        & (state.weight > MIN_WEIGHT)
        & (state.pixels.inside > 0.5)
    )


def _results(state: _State, starts: Sequence[Start], optics: Optics) -> list[MarkerFit]:
    variance = optics.sigma**2 + state.pixels.excess + state.solution[:, HEAT]
    sigma = np.sqrt(np.maximum(variance, 0.01))
    optics_sd = state.spread / np.column_stack([2 * sigma, np.ones(len(sigma))])
    hidden = np.clip(1 - state.weight, 0, 1)
    return [
        MarkerFit(
            corners=state.corners[k],
            covariance=state.covariance[k],
            rms=float(state.rms[k]),
            contrast=float(state.solution[k, WHITE]),
            light=state.solution[k, LIGHT],
            sigma=float(sigma[k]),
            bleed=optics.bleed + float(state.solution[k, INK]),
            optics_sd=optics_sd[k],
            hidden=float(hidden[k]),
            clipped=float(state.pixels.clipped[k]),
            blurred=_smear(start) > BLURRED,
            fell_back=False,
        )
        for k, start in enumerate(starts)
    ]


def _smear(start: Start) -> float:
    """The way of the fastest corner during the exposure, px."""
    return float(np.sqrt((start.motion**2).sum(axis=1).max()))


def _fallback(grey: NDArray[np.uint8], start: Start, optics: Optics) -> MarkerFit:
    corners, smear = start.corners, _smear(start)
    if _are_squares(corners[None])[0]:
        corners = refine(grey, corners[None], len(start.cells))[0]
    sd = np.hypot(LOST_SD if np.array_equal(corners, start.corners, equal_nan=True) else EDGE_SD, smear / np.sqrt(12))
    return MarkerFit(
        corners=corners,
        covariance=sd**2 * np.eye(8),
        rms=float("nan"),
        contrast=float("nan"),
        light=UNKNOWN,
        sigma=optics.sigma,
        bleed=optics.bleed,
        optics_sd=np.array([optics.sigma_sd, optics.bleed_sd]),
        hidden=float("nan"),
        clipped=float("nan"),
        blurred=smear > BLURRED,
        fell_back=True,
    )
