"""Markers from frame to frame: predicted from the last three frames, refined there, and searched only where lost.

The edges of its square bring a prediction within a tenth of a pixel, and its cells tell whether it is the marker. On request the
fit of all grey levels to the marker's template then gives the corners and their covariance, with the blur of its own motion; it
starts at the prediction where the marker's cells are readable, and needs no edges there.

Tracking begins with a full search in every segment of a video and uses nothing of the segments before, so that several processes
can share a video with the same result to the last bit.
"""

from dataclasses import dataclass, replace
from math import prod

import numpy as np
from numpy.typing import NDArray

from calibration.dictionaries import marker_cells
from mechanism.printed_markers import Markers
from vision.interlacing import row_shift
from vision.markers.cell_reading import read_cells
from vision.markers.detection import DetectedMarkers, MarkerDetector
from vision.markers.edge_refinement import refine_by_edges
from vision.markers.optics_estimate import estimate_optics
from vision.markers.photometric import MarkerFit, MarkerStart, fit_markers
from vision.markers.template import Optics
from vision.markers.tone_curve import LINEAR
from vision.markers.tone_estimate import estimate_tone
from vision.video import Frame

Array = NDArray[np.float64]
Grey = NDArray[np.uint8]

SEARCH_PERIOD_FRAMES = 150
"""frames between full searches, which also detect doubled and foreign markers (docs/thresholds.md)"""
RETRY_PERIOD_FRAMES = 5
"""frames between full searches once a marker has been missing for PATIENCE_FRAMES (docs/thresholds.md)"""
SMALL_PERIOD_FRAMES = 30
"""frames between searches of the whole picture for a missing marker of few pixels, which cost five others (docs/thresholds.md)"""
PATIENCE_FRAMES = 60
"""frames after the loss of a marker that are all searched in full (docs/thresholds.md)"""
SEARCH_MARGIN_SIDES = 1.0
"""in sides of a marker: how far around its predicted place a lost marker is searched"""
MIN_CELL_SHARE = 0.85
"""share of a marker's cells that must have the right colour for it to be the marker (docs/thresholds.md)"""
MIN_SEARCH_PX = 12
"""px: side of a search window below which a lost marker is not searched"""
MAX_FOCUS_ROUNDS = 8
"""times that the markers of a first frame are fitted anew, each from the blur that the last fits told"""
LEARNING_FRAMES = 12
"""first frames of a segment, from which the lens' blur and the ink's bleed are estimated (docs/thresholds.md)"""

TRACKED, SEARCHED, NOT_FOUND, LOST, DOUBLED, REPEATED, OTHER_PRINT, LATE = range(8)
"""status of a marker in a frame: tracked, found by a search, not found, lost while tracked, in view twice and left out, left out
as the frame repeats the picture before it, as another print of the marker may have been followed, and as the frame shows another
moment than its stamp says"""


@dataclass(frozen=True)
class TrackingOptions:
    """How corners are refined."""

    template: bool = False
    """whether by the template of all grey levels of a marker, else by the edges of its square"""
    exposure_s: float = 0.0
    """exposure time, with which the template knows the blur of motion"""


BY_EDGES = TrackingOptions()


@dataclass(frozen=True)
class TrackedFrame:
    """The markers in one frame, arrays (markers, ...)."""

    time: float
    corners: Array
    """(markers, 4, 2), px, NaN where not found"""
    covariance: NDArray[np.float32] | None
    """(markers, 8, 8), px^2, of x1, y1, x2, ..., NaN where not found; None where the edges alone were used"""
    status: NDArray[np.int8]
    """(markers,): TRACKED .. DOUBLED"""
    row_shift: NDArray[np.float32]
    """(markers,): how far odd rows are right of even ones around a marker, px; NaN where not found"""
    prints: Array
    """(n, 4) of the prints of markers that are DOUBLED: time (s), index of the marker, x and y of the print's middle (px)"""
    hidden: NDArray[np.float32]
    """(markers,): share of a marker that something covers, or that does not look like it"""
    clipped: NDArray[np.float32]
    """(markers,): share of its pixels that are black or white to the limit"""
    fell_back: NDArray[np.bool_]
    """(markers,): whether the grey levels could not be fitted, so that the corners are those of the edges"""
    foreign_ids: tuple[int, ...]
    """ids in view that are not on the arm"""


class MarkerTracker:
    """Tracks the arm's markers through one segment of a video."""

    def __init__(self, markers: Markers, options: TrackingOptions = BY_EDGES) -> None:
        self._detector = MarkerDetector(markers)
        self._ids = [marker.id for marker in markers.on_bars]
        self._cells = np.stack([marker_cells(markers.dictionary, i) for i in self._ids])
        self._past: list[tuple[float, Array]] = []
        self._since_search = self._since_small = 0
        self._lost_for = 0
        self._options = options
        self._optics = Optics()
        self._focus_is_known = self._tone_is_known = False
        self._optics_fits: list[MarkerFit] | None = []
        self._optics_frames = 0
        self._light = np.full((len(self._ids), 6), np.nan)

    def track(self, frame: Frame) -> TrackedFrame:
        """The markers in the next frame of the segment."""
        count = len(self._ids)
        corners, status = np.full((count, 4, 2), np.nan), np.full(count, NOT_FOUND, dtype=np.int8)
        fits: dict[int, MarkerFit] = {}
        predicted = self._predicted(frame.time)
        self._since_search += 1
        self._since_small += 1
        if self._past and self._since_search < SEARCH_PERIOD_FRAMES:
            fits = self._fit_at_prediction(frame, predicted)
            for k, fit in fits.items():
                corners[k], status[k] = fit.corners, TRACKED
            self._refine_predicted(frame.grey, predicted, corners, status)
        detected = self._search_if_due(frame.grey, corners, status)
        fits = {k: fit for k, fit in fits.items() if status[k] == TRACKED}
        self._refine_searched(frame.grey, corners, status)
        if self._options.template:
            rest = [k for k in np.flatnonzero(~np.isnan(corners[:, 0, 0])).tolist() if k not in fits]
            fits |= self._fit_templates(frame, corners, rest)
            if not self._focus_is_known:
                fits |= self._fits_by_focus(frame, corners, fits)
            if not self._tone_is_known:
                fits |= self._fits_by_tone(frame, corners, fits)
            lost = [k for k in fits if np.isnan(fits[k].corners).any()]
            corners[lost], status[lost] = np.nan, LOST
            fits = {k: fit for k, fit in fits.items() if k not in lost}
            self._learn(fits)
        covariance = np.full((count, 8, 8), np.nan, dtype=np.float32) if self._options.template else None
        hidden, clipped = np.zeros(count, dtype=np.float32), np.zeros(count, dtype=np.float32)
        fell_back = np.zeros(count, dtype=bool)
        for k, fit in fits.items():
            corners[k] = fit.corners
            if covariance is not None:
                covariance[k] = fit.covariance
            hidden[k], clipped[k], fell_back[k] = fit.hidden, fit.clipped, fit.fell_back
        self._past = [*self._past[-2:], (frame.time, corners)]
        return TrackedFrame(
            time=frame.time,
            corners=corners,
            covariance=covariance,
            status=status,
            hidden=hidden,
            clipped=clipped,
            fell_back=fell_back,
            row_shift=row_shift(frame.grey, corners).astype(np.float32),
            prints=self._prints(frame.time, detected),
            foreign_ids=detected.foreign_ids if detected else (),
        )

    def _refine_predicted(self, grey: Grey, predicted: Array, corners: Array, status: NDArray[np.int8]) -> None:
        """Fill in the corners and status of markers that are predicted and not known yet: by their edges, or by a search nearby."""
        wanted = np.flatnonzero(~np.isnan(predicted[:, 0, 0]) & (status != TRACKED))
        refined = refine_by_edges(grey, predicted[wanted], self._cells.shape[1])
        # what no edge confirms is no measurement, however well cells are read there: reading passes half a cell beside the marker
        readable = self._readable_share(grey, refined, wanted) >= MIN_CELL_SHARE
        corners[wanted[readable]] = refined[readable]
        status[wanted[readable]] = TRACKED
        status[wanted[~readable]] = LOST
        for k in wanted[~readable]:
            nearby = self._search_nearby(grey, predicted[k], self._ids[k])
            if nearby is not None:
                corners[k], status[k] = nearby, SEARCHED

    def _refine_searched(self, grey: Grey, corners: Array, status: NDArray[np.int8]) -> None:
        """Corners of markers that were searched, by their edges; where these fail, nothing but a start for the template."""
        searched = np.flatnonzero((status == SEARCHED) & ~np.isnan(corners[:, 0, 0]))
        refined = refine_by_edges(grey, corners[searched], self._cells.shape[1])
        failed = np.isnan(refined[:, 0, 0])
        corners[searched[~failed]] = refined[~failed]
        if not self._options.template:
            corners[searched[failed]], status[searched[failed]] = np.nan, LOST

    def _search_if_due(self, grey: Grey, corners: Array, status: NDArray[np.int8]) -> DetectedMarkers | None:
        """Search the whole picture where it is time to, and fill in corners and status; None where nothing was searched."""
        lost = bool(np.isnan(corners[:, 0, 0]).any())
        self._lost_for = self._lost_for + 1 if lost else 0
        period = SEARCH_PERIOD_FRAMES if not lost else RETRY_PERIOD_FRAMES if self._lost_for > PATIENCE_FRAMES else 1
        if self._past and self._since_search < period:
            return None
        self._since_search = 0
        small = not self._past or self._since_small >= SMALL_PERIOD_FRAMES
        if small:
            self._since_small = 0
        detected = self._detector.detect(grey, small)
        for k, i in enumerate(self._ids):
            if i in detected.prints:
                corners[k], status[k] = np.nan, DOUBLED
            elif i in detected.corners:
                corners[k], status[k] = detected.corners[i], SEARCHED
        return detected

    def _prints(self, time: float, detected: DetectedMarkers | None) -> Array:
        """The prints of markers that are in view more than once, (n, 4), as in `TrackedFrame`."""
        rows = [
            (time, k, *corners.mean(axis=0))
            for k, i in enumerate(self._ids)
            for corners in (detected.prints.get(i, ()) if detected else ())
        ]
        return np.array(rows, dtype=float).reshape(-1, 4)

    def _fit_at_prediction(self, frame: Frame, predicted: Array) -> dict[int, MarkerFit]:
        """Template fits from the prediction, of markers that three frames predict, whose light is known and cells are readable."""
        steady = ~np.isnan(self._light[:, 0])
        for _, corners in self._past:
            steady &= ~np.isnan(corners[:, 0, 0])
        wanted = np.flatnonzero(steady)
        if len(self._past) < 3 or not len(wanted):
            return {}
        readable = wanted[self._readable_share(frame.grey, predicted[wanted], wanted) >= MIN_CELL_SHARE]
        fits = self._fit_templates(frame, predicted, readable.tolist())
        return {k: fit for k, fit in fits.items() if not fit.fell_back}

    def _fit_templates(self, frame: Frame, corners: Array, indices: list[int]) -> dict[int, MarkerFit]:
        """Template fits of the markers with these indices, which are near `corners` (markers, 4, 2), px."""
        starts = self._starts(frame, corners, indices)
        return dict(zip(indices, fit_markers(frame.grey, starts, self._optics), strict=True))

    def _starts(self, frame: Frame, corners: Array, indices: list[int]) -> list[MarkerStart]:
        """Where the template fits of the markers with these indices begin."""
        motion = np.nan_to_num(self._velocity(frame.time, corners)) * self._options.exposure_s
        light = [None if np.isnan(self._light[k, 0]) else self._light[k] for k in indices]
        return [MarkerStart(corners[k], self._cells[k], motion[k], x) for k, x in zip(indices, light, strict=True)]

    def _fits_by_focus(self, frame: Frame, corners: Array, fits: dict[int, MarkerFit]) -> dict[int, MarkerFit]:
        """The markers fitted anew until the blur stays that the clear ones of these fits tell; none where none is clear.

        Fits are pulled to where they begin, in a picture out of focus by much more than their standard deviations."""
        for _ in range(MAX_FOCUS_ROUNDS):
            found = estimate_optics(self._optics, list(fits.values()))
            self._focus_is_known |= any(fit.is_clear for fit in fits.values())
            if abs(found.sigma - self._optics.sigma) <= self._optics.sigma_sd:
                break
            self._optics = replace(self._optics, sigma=found.sigma, bleed=found.bleed)
            fits = self._fit_templates(frame, corners, list(fits))
        return fits

    def _fits_by_tone(self, frame: Frame, corners: Array, fits: dict[int, MarkerFit]) -> dict[int, MarkerFit]:
        """The markers fitted anew by the camera's tone curve, which the clear ones of these fits tell; none where none is clear."""
        clear = [k for k, fit in fits.items() if fit.is_clear]
        tone = estimate_tone(frame.grey, self._starts(frame, corners, clear), self._optics)
        if tone is None:
            return {}
        self._tone_is_known, self._optics = True, replace(self._optics, tone=tone)
        return {} if tone == LINEAR else self._fit_templates(frame, corners, list(fits))

    def _learn(self, fits: dict[int, MarkerFit]) -> None:
        """Keep the light for the next frame, and estimate the optics from the first frames."""
        self._light = np.full_like(self._light, np.nan)
        for k, fit in fits.items():
            self._light[k] = fit.light
        if self._optics_fits is not None:
            self._optics_fits += fits.values()
            self._optics_frames += 1
            if self._optics_frames == LEARNING_FRAMES:
                self._optics, self._optics_fits = estimate_optics(self._optics, self._optics_fits), None

    def _velocity(self, time: float, corners: Array) -> Array:
        """Velocity of the corners at `time`, px/s, by the parabola through the last two frames and this one, or by a line."""
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
        """Corners at `time`, px, by the parabola through the last three frames, or by the line or point through fewer."""
        if not self._past:
            return np.full((len(self._ids), 4, 2), np.nan)
        predicted = self._past[-1][1]
        for count in (2, 3):
            if len(self._past) >= count:
                times = [t for t, _ in self._past[-count:]]
                weights = [prod((time - s) / (t - s) for s in times if s != t) for t in times]
                extrapolated = sum(w * c for w, (_, c) in zip(weights, self._past[-count:], strict=True))
                predicted = np.where(np.isnan(extrapolated), predicted, extrapolated)
        return predicted

    def _readable_share(self, grey: Grey, corners: Array, indices: NDArray[np.intp]) -> Array:
        """Share of the cells of the markers with these indices that are as dark or bright as they should be, (len(indices),)."""
        if not len(indices):
            return np.empty(0)
        read = read_cells(grey, corners, self._cells[indices])
        inside = np.all((corners > 0) & (corners < np.array(grey.shape[::-1]) - 1), axis=(1, 2))
        return np.where(inside & read.is_readable, read.right_share, 0.0)

    def _search_nearby(self, grey: Grey, predicted: Array, marker_id: int) -> Array | None:
        """Corners of the marker searched around its predicted place, (4, 2), px; None where it is not found exactly once."""
        side = float(np.max(np.ptp(predicted, axis=0)))
        low = np.floor(predicted.min(axis=0) - SEARCH_MARGIN_SIDES * side).astype(int)
        high = np.ceil(predicted.max(axis=0) + SEARCH_MARGIN_SIDES * side).astype(int)
        x0, y0 = np.clip(low, 0, None)
        x1, y1 = np.clip(high, 0, np.array(grey.shape[::-1]))
        if x1 - x0 < MIN_SEARCH_PX or y1 - y0 < MIN_SEARCH_PX:
            return None
        for search in (self._detector.detect_all, self._detector.detect_small):
            found = [c for i, c in search(grey[y0:y1, x0:x1]) if i == marker_id]
            if len(found) == 1:
                return found[0] + np.array([x0, y0], dtype=float)
        return None
