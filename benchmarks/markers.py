"""How near to the physical limit a marker's angle is measured, and how true the claimed uncertainty is.

Pictures come from `samples.generator.closeup`, which shares nothing with the fit. Error is the RMS of the in-plane angle over the
Cramér-Rao bound of the clean picture; `z` is error over claimed sigma. Ours start half a pixel (RMS) off, as a prediction does;
`edges` is what the fit falls back on. Blur and bleed are known as a recording's first frames would show them. Below each case
stands how many markers were not found, or fell back on edges.
"""

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.apriltag import apriltags
from benchmarks.marker_angle import angle_slopes, in_plane_angle
from benchmarks.table import Claim, Table
from calibration.dictionaries import marker_cells, opencv_dictionary
from samples.generator.closeup import Flaws, developed, light, picture, square
from vision.markers.edge_refinement import refine_by_edges
from vision.markers.optics_estimate import estimate_optics
from vision.markers.photometric import MarkerFit, MarkerStart, fit_markers
from vision.markers.template import Optics

Array = NDArray[np.float64]
Grey = NDArray[np.uint8]

FAMILY = "apriltag_36h11"
START_PX = 0.5
SEED = 7
COUNT = 200
"""markers a case"""
OURS = "photometric"
SEARCHED = ("SUBPIX", "pyapriltags")
"""of the peers, those that are named in the summary"""
BOUNDS = 8
"""of as many markers the bound is computed, and holds on the average for those that follow"""
CLEAN = Flaws()
CASES = {
    "ideal, 30 px": (30, CLEAN),
    "ideal, 60 px": (60, CLEAN),
    "ideal, 120 px": (120, CLEAN),
    "light slope": (60, replace(CLEAN, slope=(0.4, 0.25))),
    "sRGB gamma": (60, replace(CLEAN, gamma=True)),
    "ink bleed 0.25 px": (60, replace(CLEAN, bleed=0.25)),
    "JPEG 90": (60, replace(CLEAN, jpeg=90)),
    "JPEG 75": (60, replace(CLEAN, jpeg=75)),
    "motion 6 px": (60, replace(CLEAN, motion=(5.0, 3.3))),
    "cable across": (60, replace(CLEAN, cable=6.0)),
    "a quarter hidden": (60, replace(CLEAN, hidden=0.25)),
}


@dataclass(frozen=True)
class View:
    """A marker's picture and what is true of it."""

    grey: Grey
    cells: NDArray[np.bool_]
    corners: Array
    start: MarkerStart
    bound: float
    """rad"""


def views(side: int, flaws: Flaws, count: int, seed: int) -> Iterator[View]:
    """Markers of random ids, turned at random, a little tilted."""
    size = int(1.9 * side + 24)
    bounds: list[float] = []
    for k in range(count):
        rng = np.random.default_rng([seed, k])
        cells = marker_cells(FAMILY, int(rng.integers(0, 500)))
        middle = (size - 1) / 2 + rng.uniform(-0.5, 0.5, 2)
        corners = square(side, rng.uniform(-np.pi, np.pi), middle, tuple(rng.uniform(-0.02, 0.02, 2)))
        grey = developed(light(cells, corners, size, flaws), flaws, rng)
        start = MarkerStart(corners + rng.normal(0, START_PX, (4, 2)), cells, np.tile(flaws.motion, (4, 1)))
        if k < BOUNDS:
            bounds.append(bound(cells, corners, size, flaws))
        yield View(grey, cells, corners, start, float(np.mean(bounds)))


def bound(cells: NDArray[np.bool_], corners: Array, size: int, flaws: Flaws) -> float:
    """Cramér-Rao bound of the turn about the marker's middle, rad: from differences of rendered pictures, on white ground."""
    clean = replace(flaws, ground=flaws.white, cable=0.0, hidden=0.0)
    h = 0.3 / float(np.linalg.norm(corners[1] - corners[0]))
    slope = np.subtract(*(light(cells, _turned(corners, t), size, clean) for t in (h, -h))) / (2 * h)
    return float(flaws.noise / np.linalg.norm(slope))


def _turned(corners: Array, angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return (corners - corners.mean(axis=0)) @ np.array([[c, s], [-s, c]]) + corners.mean(axis=0)


def optics_of(side: int, flaws: Flaws) -> Optics:
    """Blur and bleed from eight sharp, whole markers under the same light, as a recording's first frames give them."""
    at_rest = replace(flaws, motion=(0.0, 0.0), cable=0.0, hidden=0.0)
    first = Optics()
    return estimate_optics(first, [fit_markers(v.grey, [v.start], first)[0] for v in views(side, at_rest, 8, seed=99)])


def opencv(method: int) -> Callable[[View], Array | None]:
    """Corners by OpenCV with one of its refinements."""
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = method
    detector = cv2.aruco.ArucoDetector(opencv_dictionary(FAMILY), parameters)

    def corners(view: View) -> Array | None:
        found = detector.detectMarkers(view.grey)[0]
        return np.asarray(found[0], dtype=float).reshape(4, 2) if len(found) == 1 else None

    return corners


def pyapriltags() -> Callable[[View], Array | None]:
    """Corners by AprilTag 3.4 in the setting that is best for it."""
    find = apriltags(FAMILY, decimate=2.0)

    def corners(view: View) -> Array | None:
        found = find(view.grey)
        return found[0][1] if len(found) == 1 else None

    return corners


def edges(view: View) -> Array | None:
    """Corners by `vision.markers.edge_refinement`."""
    return refine_by_edges(view.grey, view.start.corners[None], len(view.cells))[0]


def peers() -> dict[str, Callable[[View], Array | None]]:
    """What ours is compared with."""
    return {
        "NONE": opencv(cv2.aruco.CORNER_REFINE_NONE),
        "SUBPIX": opencv(cv2.aruco.CORNER_REFINE_SUBPIX),
        "CONTOUR": opencv(cv2.aruco.CORNER_REFINE_CONTOUR),
        "APRILTAG": opencv(cv2.aruco.CORNER_REFINE_APRILTAG),
        "pyapriltags": pyapriltags(),
        "edges": edges,
    }


def error(view: View, corners: Array) -> float:
    """Of the angle, rad; quarter turns do not count, since libraries begin at different corners."""
    d = float(in_plane_angle(corners) - in_plane_angle(view.corners))
    return (d + np.pi / 4) % (np.pi / 2) - np.pi / 4


def ours(view: View, optics: Optics) -> tuple[float, float, MarkerFit]:
    """Error over bound, error over sigma, and the fit."""
    fit = fit_markers(view.grey, [view.start], optics)[0]
    slopes = angle_slopes(fit.corners)
    d = error(view, fit.corners)
    return d / view.bound, d / float(np.sqrt(slopes @ fit.covariance @ slopes)), fit


def rms(values: list[float]) -> float | None:
    """Root of the mean square; None of nothing."""
    return float(np.sqrt(np.mean(np.square(values)))) if values else None


def times(repeats: int = 30) -> dict[str, float]:
    """Milliseconds for a picture of 1280 x 720 with four markers of 60 px: medians. Peers search, ours know where to look."""
    rng = np.random.default_rng(0)
    grey = np.full((720, 1280), 100, dtype=np.uint8)
    starts = []
    for k in range(4):
        cells, corner = marker_cells(FAMILY, k), np.array([100 + 200 * k, 200])
        corners = square(60, 0.3 * k, np.array([70.0, 70.0]), (0.01, 0.02))
        grey[200:340, corner[0] : corner[0] + 140] = picture(cells, corners, 140, CLEAN, rng)
        starts.append(MarkerStart(corners + corner + rng.normal(0, 0.2, (4, 2)), cells, np.zeros((4, 2))))
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    detector = cv2.aruco.ArucoDetector(opencv_dictionary(FAMILY), parameters)
    theirs = apriltags(FAMILY, decimate=2.0)
    jobs: dict[str, Callable[[], object]] = {
        "SUBPIX": lambda: detector.detectMarkers(grey),
        "pyapriltags": lambda: theirs(grey),
        "edges": lambda: refine_by_edges(grey, np.stack([s.corners for s in starts]), 8),
        OURS: lambda: fit_markers(grey, starts, Optics(0.8, 0.0, 0.05, 0.05)),
    }
    taken: dict[str, list[float]] = {name: [] for name in jobs}
    for _ in range(repeats + 1):  # side by side, so that a busy machine is busy for all
        for name, job in jobs.items():
            before = time.perf_counter()
            job()
            taken[name].append(1e3 * (time.perf_counter() - before))
    return {name: float(np.median(t[1:])) for name, t in taken.items()}


def measure(count: int = COUNT, cases: Mapping[str, tuple[int, Flaws]] = CASES) -> Table:
    """RMS error of the angle over its bound, by method; the bound itself; ours: error over sigma."""
    cv2.setNumThreads(1)
    methods = peers()
    columns = ("bound deg", *methods, OURS, "z")
    rows: list[tuple[str, tuple[float | None, ...]]] = []
    claims: list[Claim] = []
    for name, (side, flaws) in cases.items():
        optics = optics_of(side, flaws)
        errors: dict[str, list[float]] = {m: [] for m in methods}
        mine, z, back, limit = [], [], 0, 0.0
        for view in views(side, flaws, count, seed=SEED):
            for method, corners in methods.items():
                found = corners(view)
                if found is not None:
                    errors[method].append(error(view, found) / view.bound)
            a, b, fit = ours(view, optics)
            mine.append(a)
            z.append(b)
            back += fit.fell_back
            limit = float(np.degrees(view.bound))
        theirs = {method: rms(e) for method, e in errors.items()}
        rows.append((name, (limit, *theirs.values(), rms(mine), rms(z))))
        rows.append(("  not found", (None, *(count - len(e) for e in errors.values()), back, None)))
        claims += [
            Claim(
                "error of a marker's angle, rms, in bounds", name, rms(mine), (peer, theirs[peer]), ("Cramér-Rao", 1.0)
            )
            for peer in SEARCHED
        ]
    taken = times()
    rows.append(("four markers, ms", tuple(taken.get(column) for column in columns)))
    return Table(
        f"Markers, {count} a case: error of the angle over its Cramér-Rao bound", columns, tuple(rows), tuple(claims)
    )
