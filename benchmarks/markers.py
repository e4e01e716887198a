"""How near to the physical limit a marker's angle is measured, and how true the claimed uncertainty is.

    python -m benchmarks.markers [markers per case]

Pictures come from `samples.generator.closeup`, which shares nothing with the fit. Error is the RMS of the in-plane angle over the
Cramér-Rao bound of the clean picture; `z` is error over claimed sigma. Ours start half a pixel (RMS) off, as a prediction does;
`edges` is what the fit falls back on. Blur and bleed are known as a recording's first frames would show them.
"""

import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.dictionaries import dictionary, marker_cells
from samples.generator.closeup import Flaws, developed, light, picture, square
from vision.edges import refine
from vision.optics import pooled
from vision.photometric import MarkerFit, Start, fit_markers
from vision.planar_motion import angle_slopes, in_plane_angle
from vision.template import Optics

Array = NDArray[np.float64]
Grey = NDArray[np.uint8]

FAMILY = "apriltag_36h11"
START_PX = 0.5
SEED = 7
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
    start: Start
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
        start = Start(corners + rng.normal(0, START_PX, (4, 2)), cells, np.tile(flaws.motion, (4, 1)))
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
    return pooled(first, [fit_markers(v.grey, [v.start], first)[0] for v in views(side, at_rest, 8, seed=99)])


def opencv(method: int) -> Callable[[View], Array | None]:
    """Corners by OpenCV with one of its refinements."""
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = method
    detector = cv2.aruco.ArucoDetector(dictionary(FAMILY), parameters)

    def corners(view: View) -> Array | None:
        found = detector.detectMarkers(view.grey)[0]
        return np.asarray(found[0], dtype=float).reshape(4, 2) if len(found) == 1 else None

    return corners


def apriltags() -> Callable[[View], Array | None]:
    """Corners by pyapriltags (AprilTag 3.4) in the setting that is best for it."""
    import pyapriltags

    detector: Any = pyapriltags.Detector(families="tag36h11", quad_decimate=2.0, refine_edges=1)

    def corners(view: View) -> Array | None:
        found = detector.detect(view.grey)
        # its corners run the other way round
        return np.asarray(found[0].corners, dtype=float)[::-1] if len(found) == 1 else None

    return corners


def edges(view: View) -> Array | None:
    """Corners by `vision.edges`."""
    return refine(view.grey, view.start.corners[None], len(view.cells))[0]


def peers() -> dict[str, Callable[[View], Array | None]]:
    """What ours is compared with."""
    return {
        "NONE": opencv(cv2.aruco.CORNER_REFINE_NONE),
        "SUBPIX": opencv(cv2.aruco.CORNER_REFINE_SUBPIX),
        "CONTOUR": opencv(cv2.aruco.CORNER_REFINE_CONTOUR),
        "APRILTAG": opencv(cv2.aruco.CORNER_REFINE_APRILTAG),
        "pyapriltags": apriltags(),
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


def rms(values: list[float]) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values)))) if values else float("nan")


def times() -> dict[str, float]:
    """Milliseconds for a picture of 1280 x 720 with four markers of 60 px: medians of 30."""
    rng = np.random.default_rng(0)
    grey = np.full((720, 1280), 100, dtype=np.uint8)
    starts = []
    for k in range(4):
        cells, corner = marker_cells(FAMILY, k), np.array([100 + 200 * k, 200])
        corners = square(60, 0.3 * k, np.array([70.0, 70.0]), (0.01, 0.02))
        grey[200:340, corner[0] : corner[0] + 140] = picture(cells, corners, 140, CLEAN, rng)
        starts.append(Start(corners + corner + rng.normal(0, 0.2, (4, 2)), cells, np.zeros((4, 2))))
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    detector = cv2.aruco.ArucoDetector(dictionary(FAMILY), parameters)
    jobs: dict[str, Callable[[], object]] = {
        "OpenCV detection with SUBPIX": lambda: detector.detectMarkers(grey),
        "edges, four markers": lambda: refine(grey, np.stack([s.corners for s in starts]), 8),
        "photometric, four markers": lambda: fit_markers(grey, starts, Optics(0.8, 0.0, 0.05, 0.05)),
    }
    taken: dict[str, list[float]] = {name: [] for name in jobs}
    for _ in range(31):  # side by side, so that a busy machine is busy for all
        for name, job in jobs.items():
            before = time.perf_counter()
            job()
            taken[name].append(1e3 * (time.perf_counter() - before))
    return {name: float(np.median(t[1:])) for name, t in taken.items()}


def main(count: int = 200) -> None:
    """Prints one table."""
    cv2.setNumThreads(1)
    methods = peers()
    print("angle RMS error / bound; (n) of the markers were not found", f"{count} markers a case", sep="; ")
    print(
        f"{'':18}{'bound deg':>10}"
        + "".join(f"{m:>13}" for m in methods)
        + f"{'photometric':>13}{'z':>6}{'fell back':>11}"
    )
    for name, (side, flaws) in CASES.items():
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
            limit = view.bound
        cells = "".join(f"{rms(e):8.2f}{f'({count - len(e)})' if len(e) < count else '':5}" for e in errors.values())
        print(f"{name:18}{np.degrees(limit):10.4f}{cells}{rms(mine):13.2f}{rms(z):6.2f}{back:11}", flush=True)
    taken = times()
    base = taken["OpenCV detection with SUBPIX"]
    for name, t in taken.items():
        print(f"{name:32}{t:7.2f} ms{t / base:7.2f} of the detection")


if __name__ == "__main__":
    main(*(int(a) for a in sys.argv[1:]))
