"""A light that the controller switches and logs: read in the video, it ties both clocks whatever the cables do.

A frame's brightness is the share of its exposure during which the light was on. A frame that an edge falls into tells the
edge's time to a fraction of the exposure; all others only say on which side of them it lies. Both are in the likelihood,
whose mean and spread over a grid of offset and skew are reported.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import correlate

from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

LEAST_EDGES = 6
LEAST_CONTRAST = 5.0
"""on less off, over the noise of the brightness"""
LEAST_LIKENESS = 0.7
"""correlation of the light seen and logged"""
SEARCH = 1e-3
"""s, step of the first search"""
NEAR = 0.025
"""s around the first guess that are searched"""
MOST_SKEW = 5e-4
LEAST_NOISE = 0.01
"""of the contrast: what a camera's curve and the light's rise leave at best"""
WORST = 5.0
"""sigma beyond which a frame counts no further, as one with something before the light"""
MISFIT = 2.5
"""mean square of z of the frames that edges fell into, above which the sigmas grow with it; ten frames of noise stay below"""
_GRID = 61
_ZOOMS = 8


@dataclass(frozen=True)
class Anchor:
    """Camera to log by the light: offset at `middle` (camera clock), s, skew as a ratio, their sigmas, edges seen."""

    offset: float
    offset_sigma: float
    skew: float
    skew_sigma: float
    middle: float
    edges: int


def fit_anchor(edges: Array, first_on: bool, frame_time: Array, brightness: Array, exposure: float) -> Anchor:
    """The clock from a light that changed at `edges` (E,), s on the log's clock, and was on before the first if `first_on`.

    frame_time: (F,), s, middles of the exposures; brightness: (F,), any unit, NaN where not known; exposure: s.
    Raises Refused where there are too few edges, no contrast, or where light and log do not agree.
    """
    known = np.isfinite(brightness)
    time, seen = frame_time[known], brightness[known]
    if len(edges) < LEAST_EDGES or len(time) < 30:
        raise Refused(
            "anchor", f"the light changes {len(edges)} times in the log", f"let it change {LEAST_EDGES} times"
        )
    level, noise = _level(seen)
    guess = _first_guess(edges, first_on, time, level)
    middle = float(time[0] + time[-1]) / 2
    at = (edges > time[0] + guess - NEAR) & (edges < time[-1] + guess + NEAR)
    if at.sum() < LEAST_EDGES:
        raise Refused("anchor", f"only {at.sum()} changes of the light fall into the video", "record longer")
    near = _near(edges, time + guess, exposure)
    time, level = time[near], level[near]
    most = MOST_SKEW
    offset, skew = np.array([guess - NEAR, guess + NEAR]), np.array([-most, most])
    mean, sigma = np.zeros(2), np.zeros(2)
    for _ in range(_ZOOMS):
        o, s = np.linspace(offset[0], offset[1], _GRID), np.linspace(skew[0], skew[1], _GRID)
        O, S = np.meshgrid(o, s, indexing="ij")  # noqa: E741
        chi = np.zeros(O.shape)
        for t, b in zip(time.tolist(), level.tolist(), strict=True):
            share = lit(edges, first_on, t + O + S * (t - middle), exposure)
            chi += np.minimum(((b - share) / noise) ** 2, WORST**2)
        weight = np.exp(-0.5 * (chi - chi.min()))
        weight /= weight.sum()
        mean = np.array([np.sum(weight * O), np.sum(weight * S)])
        step = np.array([o[1] - o[0], s[1] - s[0]])
        sigma = np.sqrt([np.sum(weight * (O - mean[0]) ** 2), np.sum(weight * (S - mean[1]) ** 2)])
        best = np.unravel_index(int(np.argmin(chi)), chi.shape)
        if np.all(sigma > 4 * step):
            break
        centre = np.where(sigma > 0.5 * step, mean, [o[best[0]], s[best[1]]])
        half = np.maximum(6 * sigma, 4 * step)
        offset, skew = centre[0] + half[0] * np.array([-1, 1]), centre[1] + half[1] * np.array([-1, 1])
    # frames that an edge fell into show whether brightness follows the exposure as said
    share = lit(edges, first_on, time + mean[0] + mean[1] * (time - middle), exposure)
    partly = (share > 0.02) & (share < 0.98)
    misfit = float(np.mean(((level - share)[partly] / noise) ** 2)) if partly.sum() > 3 else 1.0
    sigma = sigma * np.sqrt(misfit if misfit > MISFIT else 1.0)
    return Anchor(float(mean[0]), float(sigma[0]), float(mean[1]), float(sigma[1]), middle, int(at.sum()))


def edges_of(time: Array, led: Array) -> tuple[Array, bool]:
    """When a logged column of 0 and 1 changes, (E,), s, and whether it begins with 1."""
    on = led > 0.5
    return time[1:][on[1:] != on[:-1]], bool(on[0])


def lit(edges: Array, first_on: bool, middle: Array, exposure: float) -> Array:
    """Share of exposures around `middle` (log time, any shape) during which the light was on."""
    knots = np.concatenate([[edges[0] - 1.0], edges, [edges[-1] + 1.0]])
    on = (np.arange(len(knots)) % 2 == 0) == first_on  # between knot k and the next
    total = np.concatenate([[0.0], np.cumsum(np.diff(knots) * on[:-1])])

    def until(t: Array) -> Array:
        inside = np.interp(t, knots, total)
        inside = inside + np.minimum(t - knots[0], 0) * on[0]
        return inside + np.maximum(t - knots[-1], 0) * on[-2]

    width = max(exposure, 1e-6)
    return (until(middle + width / 2) - until(middle - width / 2)) / width


def _level(seen: Array) -> tuple[Array, float]:
    """Brightness as 0 (off) to 1 (on), and its noise in that unit."""
    split = (np.percentile(seen, 2) + np.percentile(seen, 98)) / 2
    for _ in range(20):
        low, high = seen[seen <= split], seen[seen > split]
        if not len(high):
            break
        off, on = float(np.median(low)), float(np.median(high))
        noise = 1.4826 * max(float(np.median(np.abs(low - off))), float(np.median(np.abs(high - on))))
        settled, split = split, (off + on) / 2
        if split == settled and on - off > LEAST_CONTRAST * noise:
            return (seen - off) / (on - off), max(noise / (on - off), LEAST_NOISE)
    raise Refused("anchor", "the light does not stand out in the video", "check the rectangle, or darken the scene")


def _first_guess(edges: Array, first_on: bool, time: Array, level: Array) -> float:
    """Offset by correlation of the light seen with the light logged."""
    begin, end = edges[0] - 0.5, edges[-1] + 0.5
    grid = np.arange(begin, end, SEARCH)
    logged = 2 * lit(edges, first_on, grid, SEARCH) - 1
    bins = np.rint((time - time[0]) / SEARCH).astype(int)
    comb = np.zeros(bins[-1] + 1)
    comb[bins] = 2 * np.clip(level, 0, 1) - 1
    there = np.zeros_like(comb)
    there[bins] = 1.0
    match, count = correlate(logged, comb, method="fft"), correlate(np.ones_like(logged), there, method="fft")
    share = np.where(count > 0.3 * len(time), match / np.maximum(count, 1.0), 0.0)
    best = float(share.max())
    if best < LEAST_LIKENESS:
        raise Refused(
            "anchor", f"the light in the video is not the one in the log (they agree to {best:.2f})", "check `led`"
        )
    flat = np.flatnonzero(share > best - 0.5 / len(time))
    return float(begin - time[0] + (np.mean(flat) - (len(comb) - 1)) * SEARCH)


def _near(edges: Array, at: Array, exposure: float) -> NDArray[np.bool_]:
    """Frames whose exposure may meet an edge for some offset that is searched."""
    after = np.searchsorted(edges, at)
    gap = np.minimum(
        np.abs(at - edges[np.clip(after, 0, len(edges) - 1)]), np.abs(at - edges[np.clip(after - 1, 0, len(edges) - 1)])
    )
    return gap < 2 * NEAR + exposure
