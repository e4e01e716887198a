"""Markers from frame to frame: predicted from the last three, refined where predicted, searched only where lost.

The square's edges bring a prediction within a tenth of a pixel, and its cells tell whether it is the marker. On request the fit
of all its grey levels to the marker's template then gives the corners and their covariance, with the blur of its own motion; it
begins at the prediction where that shows the marker, and needs no edges there.

A segment of the video is tracked from a full search on, and forgets what was before it: so segments can be worked on by several
processes with the same result to the last bit.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.dictionaries import marker_cells
from mechanism.description import Markers
from vision.markers.detection import MarkerDetector
from vision.markers.edge_refinement import refine_by_edges
from vision.markers.optics_estimate import estimate_optics
from vision.markers.photometric import MarkerFit, MarkerStart, fit_markers
from vision.markers.planar_motion import homography
from vision.markers.template import Optics
from vision.video import Frame

Array = NDArray[np.float64]
Grey = NDArray[np.uint8]

SEARCH_PERIOD_FRAMES = 150
"""frames between full searches, which also see doubled and foreign markers"""
RETRY_PERIOD_FRAMES = 5
"""frames between full searches once a marker has been missing for PATIENCE frames; until then every frame is searched"""
PATIENCE_FRAMES = 60
SEARCH_MARGIN_SIDES = 1.0
"""of a marker's side: how far around its predicted place a lost marker is searched"""
MIN_CELL_SHARE = 0.85
"""share of a marker's cells that must read right for it to be the marker"""

LEARNING_FRAMES = 12
"""frames of a segment from which the lens' blur and the ink's bleed are learnt"""

TRACKED, SEARCHED, NOT_FOUND, LOST, DOUBLED = range(5)
"""how a marker was come by in a frame: tracked, found by search, not found, lost while tracked, left out as ambiguous"""


@dataclass(frozen=True)
class TrackingOptions:
    """How markers are refined: by their edges, or by the template of all their grey levels, which knows the exposure time, s,
    for the blur of motion."""

    template: bool = False
    exposure_s: float = 0.0


BY_EDGES = TrackingOptions()


@dataclass(frozen=True)
class TrackedFrame:
    """One frame; arrays by marker, (markers, ...)."""

    time: float
    corners: Array
    """(markers, 4, 2), px, NaN where not found"""
    covariance: NDArray[np.float32] | None
    """(markers, 8, 8), px^2, of x1, y1, x2, ..., NaN where not found; None where the edges alone were used"""
    how: NDArray[np.int8]
    hidden: NDArray[np.float32]
    """share of a marker that something covers, or that does not look like it"""
    clipped: NDArray[np.float32]
    """share of its pixels black or white to the limit"""
    fell_back: NDArray[np.bool_]
    """whether the grey levels could not be fitted, so that the corners are those of the edges"""
    foreign: tuple[int, ...]


class MarkerTracker:
    """Follows the arm's markers through one segment of a video."""

    def __init__(self, markers: Markers, manner: TrackingOptions = BY_EDGES) -> None:
        self._finder = MarkerDetector(markers)
        self._ids = [marker.id for marker in markers.on_bars]
        self._cells = np.stack([marker_cells(markers.dictionary, i) for i in self._ids])
        self._black = self._cells.reshape(len(self._ids), -1)
        n = self._cells.shape[1]
        centre = (2 * np.arange(n) + 1) / n - 1  # in the marker's own coordinates, -1 to 1
        self._centres = np.stack([np.tile(centre, n), np.repeat(centre, n), np.ones(n * n)])
        self._past: list[tuple[float, Array]] = []
        self._since_search = 0
        self._lost_for = 0
        self._manner = manner
        self._optics = Optics()
        self._learnt: list[MarkerFit] | None = []
        self._learning = 0
        self._light = np.full((len(self._ids), 6), np.nan)

    def see(self, frame: Frame) -> TrackedFrame:
        """The next frame of the segment."""
        count = len(self._ids)
        corners, how = np.full((count, 4, 2), np.nan), np.full(count, NOT_FOUND, dtype=np.int8)
        foreign: tuple[int, ...] = ()
        predicted = self._predicted(frame.time)
        known = np.flatnonzero(~np.isnan(predicted[:, 0, 0]))
        self._since_search += 1
        fits: dict[int, MarkerFit] = {}
        if self._past and self._since_search < SEARCH_PERIOD_FRAMES:
            fits = self._at_once(frame, predicted)
            for k, fit in fits.items():
                corners[k], how[k] = fit.corners, TRACKED
            known = np.array([k for k in known if k not in fits], dtype=np.intp)
            refined = refine_by_edges(frame.grey, predicted[known], self._cells.shape[1])
            right = self._read(frame.grey, refined, known) >= MIN_CELL_SHARE
            corners[known[right]] = refined[right]
            how[known[right]] = TRACKED
            how[known[~right]] = LOST
            for k in known[~right]:
                found = self._around(frame.grey, predicted[k], self._ids[k])
                if found is not None:
                    corners[k], how[k] = found, SEARCHED
        lost = np.isnan(corners[:, 0, 0])
        self._lost_for = self._lost_for + 1 if lost.any() else 0
        pause = (
            SEARCH_PERIOD_FRAMES if not lost.any() else RETRY_PERIOD_FRAMES if self._lost_for > PATIENCE_FRAMES else 1
        )
        if not self._past or self._since_search >= pause:
            everything = self._finder.find(frame.grey)
            foreign = everything.foreign
            for k, i in enumerate(self._ids):
                if i in everything.duplicate:
                    corners[k], how[k] = np.nan, DOUBLED
                elif i in everything.corners:
                    corners[k] = everything.corners[i]
                    how[k] = SEARCHED
                fits = {m: fit for m, fit in fits.items() if how[m] == TRACKED}
            self._since_search = 0
        if self._manner.template:
            rest = [k for k in np.flatnonzero(~np.isnan(corners[:, 0, 0])).tolist() if k not in fits]
            fits |= self._fitted(frame, corners, rest)
            self._learn(fits)
        covariance = np.full((count, 8, 8), np.nan, dtype=np.float32) if self._manner.template else None
        hidden, clipped = np.zeros(count, dtype=np.float32), np.zeros(count, dtype=np.float32)
        fell_back = np.zeros(count, dtype=bool)
        for k, fit in fits.items():
            corners[k] = fit.corners
            if covariance is not None:
                covariance[k] = fit.covariance
            hidden[k], clipped[k], fell_back[k] = fit.hidden, fit.clipped, fit.fell_back
        self._past = [*self._past[-2:], (frame.time, corners)]
        return TrackedFrame(frame.time, corners, covariance, how, hidden, clipped, fell_back, foreign)

    def _at_once(self, frame: Frame, predicted: Array) -> dict[int, MarkerFit]:
        """Fits from the prediction, of markers that three frames predict, under light that is known, and that are there."""
        steady = ~np.isnan(self._light[:, 0])
        for _, corners in self._past:
            steady &= ~np.isnan(corners[:, 0, 0])
        which = np.flatnonzero(steady)
        if len(self._past) < 3 or not len(which):
            return {}
        there = which[self._read(frame.grey, predicted[which], which) >= MIN_CELL_SHARE]
        fits = self._fitted(frame, predicted, there.tolist())
        return {k: fit for k, fit in fits.items() if not fit.fell_back}

    def _fitted(self, frame: Frame, corners: Array, which: list[int]) -> dict[int, MarkerFit]:
        """Photometric fits of the markers `which` in the list, that are near `corners` (markers, 4, 2)."""
        motion = np.nan_to_num(self._velocity(frame.time, corners)) * self._manner.exposure_s
        light = [None if np.isnan(self._light[k, 0]) else self._light[k] for k in which]
        starts = [MarkerStart(corners[k], self._cells[k], motion[k], at) for k, at in zip(which, light, strict=True)]
        return dict(zip(which, fit_markers(frame.grey, starts, self._optics), strict=True))

    def _learn(self, fits: dict[int, MarkerFit]) -> None:
        """The light for the next frame, and from the first frames the optics."""
        self._light = np.full_like(self._light, np.nan)
        for k, fit in fits.items():
            self._light[k] = fit.light
        if self._learnt is not None:
            self._learnt += fits.values()
            self._learning += 1
            if self._learning == LEARNING_FRAMES:
                self._optics, self._learnt = estimate_optics(self._optics, self._learnt), None

    def _velocity(self, time: float, corners: Array) -> Array:
        """Slope at `time` of the parabola through the last two frames and this one, px/s; of the line where one is missing."""
        if not self._past:
            return np.full_like(corners, np.nan)
        (t1, c1), slope = self._past[-1], (corners - self._past[-1][1]) / (time - self._past[-1][0])
        if len(self._past) < 2:
            return slope
        t0, c0 = self._past[-2]
        before = (c1 - c0) / (t1 - t0)
        curved = slope + (slope - before) / (time - t0) * (time - t1)
        return np.where(np.isnan(curved), slope, curved)

    def _predicted(self, time: float) -> Array:
        """Corners at `time` by the parabola through the last three frames, the line or the point where fewer are known."""
        if not self._past:
            return np.full((len(self._ids), 4, 2), np.nan)
        out = self._past[-1][1]
        for used in (2, 3):
            if len(self._past) >= used:
                times = np.array([t for t, _ in self._past[-used:]])
                weights = [np.prod([(time - s) / (t - s) for s in times if s != t]) for t in times]
                further = sum(w * c for w, (_, c) in zip(weights, self._past[-used:], strict=True))
                out = np.where(np.isnan(further), out, further)
        return out

    def _read(self, grey: Grey, corners: Array, which: NDArray[np.intp]) -> Array:
        """Share of each marker's cells that are as dark or bright as they should be, (len(which),)."""
        if not len(which):
            return np.empty(0)
        places = homography(corners) @ self._centres
        x, y = ((places[:, axis] / places[:, 2]).astype(np.float32) for axis in range(2))
        samples = cv2.remap(grey, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE).astype(float)
        black = self._black[which]
        count = np.count_nonzero(black, axis=1)
        dark, every = np.einsum("kc,kc->k", samples, black), samples.sum(axis=1)
        dark, bright = dark / count, (every - dark) / np.maximum(black.shape[1] - count, 1)
        threshold = ((dark + bright) / 2)[:, None]
        share = np.mean((samples < threshold) == black, axis=1)
        inside = np.all((corners > 0) & (corners < np.array(grey.shape[::-1]) - 1), axis=(1, 2))
        return np.where(inside & (bright - dark > 10), share, 0.0)

    def _around(self, grey: Grey, predicted: Array, marker_id: int) -> Array | None:
        """The marker searched near its predicted place; None where it is not."""
        side = float(np.max(np.ptp(predicted, axis=0)))
        low = np.floor(predicted.min(axis=0) - SEARCH_MARGIN_SIDES * side).astype(int)
        high = np.ceil(predicted.max(axis=0) + SEARCH_MARGIN_SIDES * side).astype(int)
        x0, y0 = np.clip(low, 0, None)
        x1, y1 = np.clip(high, 0, np.array(grey.shape[::-1]))
        if x1 - x0 < 12 or y1 - y0 < 12:
            return None
        hits = [c for i, c in self._finder.detections(grey[y0:y1, x0:x1]) if i == marker_id]
        return hits[0] + np.array([x0, y0], dtype=float) if len(hits) == 1 else None
