"""Calibration beside OpenCV's, flat boards and boards bowed by 0.5 mm in all views: time, held-out error, and error of the camera.

20 views of 9 x 6 squares by a pinhole with distortion; corners are projected here, by nothing of the package, and have 0.07 px
of noise. Held out is what a camera leaves in 20 views more, of the same board, where only poses are fitted (by OpenCV, for
all). calibrateCameraRO ("release object") takes long: it runs once a board, all else is a median.
"""

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.table import Claim, Table
from calibration.bundle_adjustment import fit_bundle, initial_estimate
from calibration.corner_detection import BoardView
from calibration.estimation import calibrate
from calibration.observations import Observations
from calibration.stacked_views import stack_views

Array = NDArray[np.float64]

SIZE = (1280, 720)
TRUTH = np.array([905.0, 906.0, 645.0, 352.0, -0.21, 0.07, 0.0008, -0.0006, 0.0])
SQUARE = 0.025
CORNERS = 40
NOISE = 0.07
BOW = 0.0005
SEEDS = 4

Estimate = tuple[Array, Array]
"""the nine parameters, and the corners of the board, shape (c, 3), m"""


def measure() -> Table:
    """Over seeds: time over that of calibrateCamera, held-out error, and errors of f and of where pixels look."""
    cv2.setNumThreads(1)
    rows: list[tuple[str, tuple[float | None, ...]]] = []
    for board, bow in (("flat", 0.0), ("bowed", BOW)):
        taken: dict[str, list[float]] = {name: [] for name in JOBS}
        figures: dict[str, list[tuple[float, float, float]]] = {name: [] for name in JOBS}
        for seed in range(SEEDS):
            rng = np.random.default_rng(seed)
            views, unseen = _views(rng, 20, bow), _views(rng, 20, bow)
            for name, job in JOBS.items():  # side by side, so that a busy machine is busy for all
                if name.startswith("OpenCV RO") and seed:
                    continue
                before = time.perf_counter()
                found = job(views)
                taken[name].append(time.perf_counter() - before)
                figures[name].append((_held_out(found, unseen), abs(found[0][0] - TRUTH[0]), _looks(found[0])))
        base = float(np.median(taken[PEER]))
        for name in JOBS:
            held, focal, looks = (float(v) for v in np.sqrt(np.mean(np.square(figures[name]), axis=0)))
            t = float(np.median(taken[name]))
            rows.append((f"{board}: {name}", (1e3 * t, t / base, held, focal, looks)))
    title = f"Calibration, 20 views of {CORNERS} corners, {NOISE} px, {SEEDS} seeds"
    columns = ("time ms", "over OpenCV", "held out px", "fx error px", "projection px")
    table = Table(title, columns, tuple(rows))
    return replace(table, claims=tuple(_claims(table)))


def _claims(table: Table) -> Iterator[Claim]:
    for what, column, job in (
        ("time of one fit, ms", "time ms", "xneck, one fit"),
        ("time of all that calibrate does, ms", "time ms", "xneck, all of calibrate"),
        ("where pixels look, rms, px", "projection px", "xneck, all of calibrate"),
        ("error in views held out, rms, px", "held out px", "xneck, all of calibrate"),
    ):
        # two coordinates a corner, of which the view's pose fits six
        noise = NOISE * math.sqrt(2 * (1 - 6 / (2 * CORNERS)))
        limit = ("noise of the corners", noise) if column == "held out px" else None
        for board in ("flat", "bowed"):
            ours, peer = (table.at(f"{board}: {name}", column) for name in (job, PEER))
            yield Claim(what, f"20 views of a {board} board", ours, (PEER, peer), limit)


def _views(rng: np.random.Generator, count: int, bow: float) -> list[BoardView]:
    """Boards all over the picture, tilted by 35 degrees about axes all around."""
    grid = np.stack(np.meshgrid(np.arange(8.0), np.arange(5.0)), axis=-1).reshape(-1, 2) * SQUARE
    nominal = np.column_stack([grid, np.zeros(len(grid))])
    bent = nominal.copy()
    bent[:, 2] = bow * (2 * grid[:, 0] / np.ptp(grid[:, 0]) - 1) ** 2
    found: list[BoardView] = []
    while len(found) < count:
        about = rng.uniform(0, 2 * np.pi)
        R = cv2.Rodrigues(np.radians(35.0) * np.array([np.cos(about), np.sin(about), 0.0]))[0]
        R = R @ cv2.Rodrigues(np.array([0.0, 0.0, rng.uniform(-0.4, 0.4)]))[0]
        z = rng.uniform(0.25, 0.5)
        t = np.array([rng.uniform(-0.5, 0.5) * z, rng.uniform(-0.3, 0.3) * z, z]) - R @ bent.mean(axis=0)
        pixels = _project(bent @ R.T + t, TRUTH)
        if np.all((pixels > 8) & (pixels < np.array(SIZE) - 9)):
            pixels = pixels + NOISE * rng.normal(size=pixels.shape)
            found.append(BoardView(f"{len(found):02d}", pixels, nominal, np.arange(len(nominal))))
    return found


def _project(points: Array, p: Array) -> Array:
    K = np.array([[p[0], 0, p[2]], [0, p[1], p[3]], [0, 0, 1.0]])
    return np.asarray(cv2.projectPoints(points, np.zeros(3), np.zeros(3), K, p[4:])[0], float).reshape(-1, 2)


def _one_fit(views: list[BoardView]) -> Estimate:
    seen = stack_views(views)
    found = fit_bundle(seen, initial_estimate(seen, SIZE))
    return found.parameters, found.shape.points


def _whole(views: list[BoardView]) -> Estimate:
    found = calibrate(Observations(tuple(views), (), SIZE))
    return found.camera.parameters, found.board.points


def _opencv(views: list[BoardView]) -> Estimate:
    _, K, d, *_ = cv2.calibrateCamera(*_lists(views), SIZE, np.zeros((3, 3)), np.zeros(5), flags=cv2.CALIB_FIX_K3)
    return _nine(K, d), views[0].object_points


def _opencv_ro(views: list[BoardView]) -> Estimate:
    _, K, d, _, _, points, *_ = cv2.calibrateCameraRO(
        *_lists(views), SIZE, 7, np.zeros((3, 3)), np.zeros(5), flags=cv2.CALIB_FIX_K3
    )
    return _nine(K, d), np.asarray(points, float).reshape(-1, 3)


PEER = "OpenCV calibrateCamera"
JOBS: dict[str, Callable[[list[BoardView]], Estimate]] = {
    PEER: _opencv,
    "OpenCV RO calibrateCameraRO": _opencv_ro,
    "xneck, one fit": _one_fit,
    "xneck, all of calibrate": _whole,
}
"""`all of calibrate`: 15 candidates, each with ten folds, the jackknife, and OpenCV's own calibration beside"""


def _lists(views: list[BoardView]) -> tuple[list[NDArray[np.float32]], list[NDArray[np.float32]]]:
    return (
        [view.object_points.astype(np.float32) for view in views],
        [view.image_points.astype(np.float32).reshape(-1, 1, 2) for view in views],
    )


def _nine(K: NDArray[np.generic], d: NDArray[np.generic]) -> Array:
    return np.array([K[0, 0], K[1, 1], K[0, 2], K[1, 2], *np.ravel(d)[:5]], float)


def _held_out(found: Estimate, unseen: list[BoardView]) -> float:
    """RMS distance in views that no camera saw, px."""
    p, points = found
    K = np.array([[p[0], 0, p[2]], [0, p[1], p[3]], [0, 0, 1.0]])
    squares = []
    for view in (replace(view, object_points=points) for view in unseen):
        _, rvec, tvec = cv2.solvePnP(view.object_points, view.image_points, K, p[4:])
        predicted = cv2.projectPoints(view.object_points, rvec, tvec, K, p[4:])[0]
        squares.append(np.sum((np.reshape(predicted, (-1, 2)) - view.image_points) ** 2, axis=1))
    return float(np.sqrt(np.mean(squares)))


def _looks(p: Array) -> float:
    """RMS over the picture of what the camera's rays miss by, px, after the turn that is best (it is the pose's business)."""
    x, y = np.meshgrid(np.linspace(-0.6, 0.6, 13), np.linspace(-0.33, 0.33, 9))
    rays = np.column_stack([x.ravel(), y.ravel(), np.ones(x.size)])
    pixels = _project(rays, TRUTH)
    K = np.array([[p[0], 0, p[2]], [0, p[1], p[3]], [0, 0, 1.0]])
    turn, shift, left = np.zeros(3), np.zeros(3), np.zeros(2 * len(rays))
    for _ in range(10):
        predicted, J = cv2.projectPoints(rays, turn, shift, K, p[4:])
        left = (np.reshape(predicted, (-1, 2)) - pixels).ravel()
        turn = turn - np.linalg.lstsq(J[:, :3], left, rcond=None)[0]
    return float(np.sqrt(np.mean(np.sum(left.reshape(-1, 2) ** 2, axis=1))))
