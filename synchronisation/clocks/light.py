"""The clock of a light that the controller switches and logs, and the video shows: it needs neither cables nor motion.

A frame's brightness is the share of its exposure during which the light was on. A frame that a switch falls into gives its time to
a fraction of the exposure; all others only say on which side of them it lies. Both are in the likelihood, whose mean and spread
over a grid of offset and skew are reported.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import correlate

from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

MIN_SWITCHES = 6
"""switches of the light that its clock needs, in the log and again within the video (docs/thresholds.md)"""
MIN_LIGHT_FRAMES = 30
"""frames with a known brightness that it needs (docs/thresholds.md)"""
MIN_CONTRAST = 5.0
"""brightness on less off, over its noise (docs/thresholds.md)"""
MIN_LIGHT_CORRELATION = 0.7
"""correlation of the light in video and log (docs/thresholds.md)"""
SEARCH_STEP_S = 1e-3
"""s: step of the first search of the offset"""
SEARCH_RANGE_S = 0.025
"""s around the first guess of the offset that are searched (docs/thresholds.md)"""
MAX_SEARCHED_SKEW = 5e-4
"""ratio: skews that are searched (docs/thresholds.md)"""
MIN_BRIGHTNESS_NOISE = 0.01
"""of the contrast: what a camera's response and the light's rise leave at best (docs/thresholds.md)"""
MAX_DEVIATION_SIGMA = 5.0
"""deviation from which a frame's brightness counts no further, as where something is in front of the light (docs/thresholds.md)"""
MAX_MISFIT = 2.5
"""mean square of z, over frames that switches fell into, above which the sigmas grow with it (docs/thresholds.md)"""
_GRID = 61
_MAX_ZOOMS = 8


@dataclass(frozen=True)
class LightClock:
    """Camera to log by the light: log time = camera time + offset + skew (camera time - middle)."""

    offset: float
    """s"""
    offset_sigma: float
    skew: float
    skew_sigma: float
    middle: float
    """s, camera clock"""
    switches: int
    """changes of the light within the video"""


@dataclass(frozen=True)
class _LightFrames:
    """Frames near a switch, and what the log says of the light."""

    time: Array
    """(F,), s, camera clock: middles of the exposures"""
    level: Array
    """(F,), 0 (off) to 1 (on)"""
    noise: float
    """of the level"""
    edges: Array
    """(E,), s, log clock"""
    first_on: bool
    exposure: float
    middle: float

    def share(self, offset: Array, skew: Array) -> Array:
        """Share of each exposure with the light on, (F,), at a clock (scalars)."""
        at = self.time + offset + skew * (self.time - self.middle)
        return lit_share(self.edges, self.first_on, at, self.exposure)

    def chi_square(self, offset: Array, skew: Array) -> Array:
        """Misfit of clocks, offset (s) and skew of any common shape."""
        out = np.zeros(offset.shape)
        for t, level in zip(self.time.tolist(), self.level.tolist(), strict=True):
            share = lit_share(self.edges, self.first_on, t + offset + skew * (t - self.middle), self.exposure)
            out += np.minimum(((level - share) / self.noise) ** 2, MAX_DEVIATION_SIGMA**2)
        return out


def fit_light(edges: Array, first_on: bool, frame_time: Array, brightness: Array, exposure: float) -> LightClock:
    """The clock from a light that changed at `edges` (E,), s on the log's clock, and was on before the first if `first_on`.

    frame_time: (F,), s, middles of the exposures; brightness: (F,), any unit, NaN where not known; exposure: s.
    Raises Refused where there are too few switches, no contrast, or where light and log do not agree.
    """
    known = np.isfinite(brightness)
    time = frame_time[known]
    if len(edges) < MIN_SWITCHES or len(time) < MIN_LIGHT_FRAMES:
        raise Refused(
            "anchor", f"the light changes {len(edges)} times in the log", f"let it change {MIN_SWITCHES} times"
        )
    level, noise = _level(brightness[known])
    guess = _first_guess(edges, first_on, time, level)
    within = (edges > time[0] + guess - SEARCH_RANGE_S) & (edges < time[-1] + guess + SEARCH_RANGE_S)
    if within.sum() < MIN_SWITCHES:
        raise Refused("anchor", f"only {within.sum()} changes of the light fall into the video", "record longer")
    near = _near_edge(edges, time + guess, exposure)
    frames = _LightFrames(
        time=time[near],
        level=level[near],
        noise=noise,
        edges=edges,
        first_on=first_on,
        exposure=exposure,
        middle=float(time[0] + time[-1]) / 2,
    )
    mean, sigma = _mean_and_sigma(frames, guess)
    sigma = sigma * np.sqrt(_misfit(frames, mean))
    return LightClock(
        offset=float(mean[0]),
        offset_sigma=float(sigma[0]),
        skew=float(mean[1]),
        skew_sigma=float(sigma[1]),
        middle=frames.middle,
        switches=int(within.sum()),
    )


def edges_of(time: Array, led: Array) -> tuple[Array, bool]:
    """When a logged column of 0 and 1 changes, (E,), s, and whether it begins with 1."""
    on = led > 0.5
    return time[1:][on[1:] != on[:-1]], bool(on[0])


def lit_share(edges: Array, first_on: bool, middle: Array, exposure: float) -> Array:
    """Share of exposures around `middle` (log time, any shape) during which the light was on."""
    knots = np.concatenate([[edges[0] - 1.0], edges, [edges[-1] + 1.0]])
    on = (np.arange(len(knots)) % 2 == 0) == first_on  # between knot k and the next
    total = np.concatenate([[0.0], np.cumsum(np.diff(knots) * on[:-1])])

    def on_until(t: Array) -> Array:
        inside = np.interp(t, knots, total)
        inside = inside + np.minimum(t - knots[0], 0) * on[0]
        return inside + np.maximum(t - knots[-1], 0) * on[-2]

    width = max(exposure, 1e-6)
    return (on_until(middle + width / 2) - on_until(middle - width / 2)) / width


def _mean_and_sigma(frames: _LightFrames, guess: float) -> tuple[Array, Array]:
    """Mean and standard deviation (2,) of offset and skew, on grids that zoom in until they resolve them."""
    offsets = np.array([guess - SEARCH_RANGE_S, guess + SEARCH_RANGE_S])
    skews = np.array([-MAX_SEARCHED_SKEW, MAX_SEARCHED_SKEW])
    mean, sigma = np.zeros(2), np.zeros(2)
    for _ in range(_MAX_ZOOMS):
        o, s = np.linspace(offsets[0], offsets[1], _GRID), np.linspace(skews[0], skews[1], _GRID)
        offset, skew = np.meshgrid(o, s, indexing="ij")
        chi = frames.chi_square(offset, skew)
        weight = np.exp(-0.5 * (chi - chi.min()))
        weight /= weight.sum()
        mean = np.array([np.sum(weight * offset), np.sum(weight * skew)])
        step = np.array([o[1] - o[0], s[1] - s[0]])
        sigma = np.sqrt([np.sum(weight * (offset - mean[0]) ** 2), np.sum(weight * (skew - mean[1]) ** 2)])
        if np.all(sigma > 4 * step):
            break
        best = np.unravel_index(int(np.argmin(chi)), chi.shape)
        centre = np.where(sigma > 0.5 * step, mean, [o[best[0]], s[best[1]]])
        half = np.maximum(6 * sigma, 4 * step)
        offsets, skews = centre[0] + half[0] * np.array([-1, 1]), centre[1] + half[1] * np.array([-1, 1])
    return mean, sigma


def _misfit(frames: _LightFrames, clock: Array) -> float:
    """Mean square of z over frames that a switch fell into: they show whether brightness follows the exposure; 1 if it does."""
    share = frames.share(clock[0], clock[1])
    partly = (share > 0.02) & (share < 0.98)
    misfit = float(np.mean(((frames.level - share)[partly] / frames.noise) ** 2)) if partly.sum() > 3 else 1.0
    return misfit if misfit > MAX_MISFIT else 1.0


def _level(brightness: Array) -> tuple[Array, float]:
    """Brightness (F,) as 0 (off) to 1 (on), and its noise in that unit."""
    split = (np.percentile(brightness, 2) + np.percentile(brightness, 98)) / 2
    for _ in range(20):
        low, high = brightness[brightness <= split], brightness[brightness > split]
        if not len(high):
            break
        off, on = float(np.median(low)), float(np.median(high))
        noise = 1.4826 * max(float(np.median(np.abs(low - off))), float(np.median(np.abs(high - on))))
        last, split = split, (off + on) / 2
        if split == last and on - off > MIN_CONTRAST * noise:
            return (brightness - off) / (on - off), max(noise / (on - off), MIN_BRIGHTNESS_NOISE)
    raise Refused("anchor", "the light does not stand out in the video", "check the rectangle, or darken the scene")


def _first_guess(edges: Array, first_on: bool, time: Array, level: Array) -> float:
    """Offset, s, at which the light in the video correlates best with the light in the log."""
    begin, end = edges[0] - 0.5, edges[-1] + 0.5
    grid = np.arange(begin, end, SEARCH_STEP_S)
    logged = 2 * lit_share(edges, first_on, grid, SEARCH_STEP_S) - 1
    bins = np.rint((time - time[0]) / SEARCH_STEP_S).astype(int)
    in_video = np.zeros(bins[-1] + 1)
    in_video[bins] = 2 * np.clip(level, 0, 1) - 1
    is_frame = np.zeros_like(in_video)
    is_frame[bins] = 1.0
    product = correlate(logged, in_video, method="fft")
    count = correlate(np.ones_like(logged), is_frame, method="fft")
    correlation = np.where(count > 0.3 * len(time), product / np.maximum(count, 1.0), 0.0)
    best = float(correlation.max())
    if best < MIN_LIGHT_CORRELATION:
        raise Refused(
            "anchor", f"the light in the video is not the one in the log (they agree to {best:.2f})", "check `led`"
        )
    plateau = np.flatnonzero(correlation > best - 0.5 / len(time))
    return float(begin - time[0] + (np.mean(plateau) - (len(in_video) - 1)) * SEARCH_STEP_S)


def _near_edge(edges: Array, at: Array, exposure: float) -> NDArray[np.bool_]:
    """Frames at log times (F,), s, whose exposure may meet a switch for some offset that is searched."""
    after = np.searchsorted(edges, at)
    next_edge = edges[np.clip(after, 0, len(edges) - 1)]
    last_edge = edges[np.clip(after - 1, 0, len(edges) - 1)]
    return np.minimum(np.abs(at - next_edge), np.abs(at - last_edge)) < 2 * SEARCH_RANGE_S + exposure
