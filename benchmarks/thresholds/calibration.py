"""Calibrations of projected boards with known truth, once as they are and once with each threshold changed."""

import re
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.calibration import SIZE, SQUARE, TRUTH
from benchmarks.thresholds.outcome import Outcome
from benchmarks.thresholds.room import Room
from benchmarks.thresholds.threshold import Threshold, scaled
from calibration.camera_check import check_camera
from calibration.corner_detection import BoardView
from calibration.estimation import Calibration, calibrate
from calibration.observations import Observations
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

FIRST = 7600
GRID = np.stack(np.meshgrid(np.arange(8.0), np.arange(5.0)), axis=-1).reshape(-1, 2) * SQUARE
FLAT = np.column_stack([GRID, np.zeros(len(GRID))])
BOWED = np.column_stack([GRID, 5e-4 * (2 * GRID[:, 0] / np.ptp(GRID[:, 0]) - 1) ** 2])
FISHEYE = np.array([420.0, 420.0, 645.0, 352.0, 0.0, 0.0, 0.0, 0.0, 0.0])


def views(
    seed: int,
    count: int = 15,
    noise: float = 0.07,
    tilt_deg: float = 35.0,
    board: Array = FLAT,
    parameters: Array = TRUTH,
    bent_anew: float = 0.0,
    fisheye: bool = False,
) -> list[BoardView]:
    """Boards all over the picture. bent_anew: bow of another size in every view, m."""
    rng = np.random.default_rng([FIRST, seed])
    found: list[BoardView] = []
    while len(found) < count:
        about = rng.uniform(0, 2 * np.pi)
        R = cv2.Rodrigues(np.radians(tilt_deg) * np.array([np.cos(about), np.sin(about), 0.0]))[0]
        R = R @ cv2.Rodrigues(np.array([0.0, 0.0, rng.uniform(-0.4, 0.4)]))[0]
        bent = board + bent_anew * rng.normal() * (BOWED - FLAT) / 5e-4
        z = rng.uniform(0.25, 0.5) * parameters[0] / TRUTH[0]
        wide = z * TRUTH[0] / parameters[0]
        t = np.array([rng.uniform(-0.5, 0.5) * wide, rng.uniform(-0.3, 0.3) * wide, z]) - R @ bent.mean(axis=0)
        pixels = _project(bent @ R.T + t, parameters, fisheye)
        if np.all((pixels > 8) & (pixels < np.array(SIZE) - 9)):
            pixels = pixels + noise * rng.normal(size=pixels.shape)
            found.append(BoardView(f"view {len(found):02d}", pixels, FLAT, np.arange(len(FLAT))))
    return found


def _project(points: Array, p: Array, fisheye: bool) -> Array:
    if fisheye:  # equidistant
        radius = np.linalg.norm(points[:, :2], axis=1)
        angle = np.arctan2(radius, points[:, 2])
        return p[2:4] + p[:2] * points[:, :2] * (angle / np.maximum(radius, 1e-12))[:, None]
    K = np.array([[p[0], 0, p[2]], [0, p[1], p[3]], [0, 0, 1.0]])
    return np.asarray(cv2.projectPoints(points, np.zeros(3), np.zeros(3), K, p[4:])[0], float).reshape(-1, 2)


@dataclass(frozen=True)
class World:
    """Views, and what is right of them: a board of a shape, or a refusal."""

    name: str
    views: list[BoardView]
    board: str = "rigid"
    """how the right board model's name begins"""
    refusal: str = ""
    later: list[BoardView] | None = None
    """views of another day, against which the camera is held"""
    verdict: str = ""
    """what is right of these"""
    without: str = ""
    """a view that is to be left out"""


def worlds(folder: Path) -> list[World]:
    """All of them; nothing is kept in the folder."""
    spoiled = views(7)
    spoiled[3] = replace(spoiled[3], image_points=spoiled[3].image_points + 3.0 * np.sin(np.arange(80)).reshape(-1, 2))
    zoomed = TRUTH * np.where(np.arange(9) < 2, 1.01, 1.0)
    zoomed_far = TRUTH * np.where(np.arange(9) < 2, 1.2, 1.0)
    mixed = [*views(8, 8), *(replace(v, name=f"zoomed {v.name}") for v in views(9, 7, parameters=zoomed_far))]
    wide = np.array([600.0, 600.0, 645.0, 352.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    return [
        *(World(f"flat board {k}", views(k)) for k in range(3)),
        *(World(f"bowed board {k}", views(10 + k, 20, 0.05, board=BOWED), board="bowed") for k in range(3)),
        World("one view that disagrees", spoiled, without="view 03"),
        World("bent by 0.1 mm anew in every view", views(4, bent_anew=1e-4), board=""),
        World("6 views tilted by 7 deg, 0.5 px", views(20, 6, 0.5, 7.0), refusal="focal length is known|tilted alike"),
        World("a lens of 600 px an angle, equidistant", views(21, parameters=wide, fisheye=True), refusal="fisheye"),
        World("5 views and each of them again", _again(views(22, 5)), refusal="distinct views"),
        World("bent by 0.5 mm anew in every view", views(23, bent_anew=5e-4), board=""),
        World("5 views", views(5, 5), refusal="distinct views"),
        World("tilted by 2 deg", views(6, tilt_deg=2.0), refusal="tilted alike|focal length is known"),
        World("tilted by 12 deg", views(6, tilt_deg=12.0)),
        World("zoomed by 20 % on the way", mixed, refusal="no camera|keeps changing|disagree"),
        World("a fisheye", views(11, 15, parameters=FISHEYE, fisheye=True), refusal="fisheye"),
        World("the same camera later", views(12), later=views(13, 10), verdict="holds"),
        World("the same camera, 4 views later", views(14), later=views(15, 4), verdict="holds"),
        World("zoomed by 1 % later", views(16), later=views(17, 10, parameters=zoomed), verdict="does not hold"),
        World("the same camera, later flat on", views(18), later=views(19, 4, 0.3, 1.0), verdict="cannot tell"),
    ]


def _again(once: list[BoardView]) -> list[BoardView]:
    return once + [replace(view, name=f"again {view.name}", image_points=view.image_points + 0.05) for view in once]


def judged(world: World) -> Outcome:
    """The calibration as it is now against the truth."""
    try:
        found = calibrate(Observations(tuple(world.views), (), SIZE))
    except Refused as refusal:
        right = bool(world.refusal and re.search(world.refusal, str(refusal)))
        return Outcome(right, not world.refusal, str(refusal)[:160])
    if world.refusal:
        return Outcome(False, True, f"accepted, f {found.camera.parameters[0]:.1f}")
    if world.later is not None:
        verdict = check_camera(found.camera, Observations(tuple(world.later), (), SIZE)).verdict
        return Outcome(verdict == world.verdict, verdict not in (world.verdict, "cannot tell"), verdict)
    return _of_camera(found, world)


def _of_camera(found: Calibration, world: World) -> Outcome:
    error = found.camera.parameters[:2] - TRUTH[:2]
    z = float(np.max(np.abs(error) / np.sqrt(np.diag(np.asarray(found.camera.covariance))[:2])))
    out = [picture.name for picture in found.pictures if not picture.used]
    shaped = found.board.model.name.startswith(world.board)
    said = f"{found.lens}, {found.board.model.name}, z of f {z:.1f}" + (f", left out {', '.join(out)}" if out else "")
    wanted = [world.without] if world.without else []
    return Outcome(z < 3 and shaped and out == wanted, z >= 3 or not shaped, said)


def _thresholds() -> list[Threshold]:
    def of(module: str, *names: str) -> list[Threshold]:
        return scaled(f"calibration.{module}", *names)

    return [
        *of("refusals", "MIN_VIEWS", "_MIN_TILT_RAD", "_MAX_FOCAL_SIGMA", "_MAX_ERROR_OVER_NOISE"),
        *of("refusals", "_MAX_RADIAL_F", "_MAX_RADIAL_OVER_NOISE"),
        *of("view_selection", "_MAX_RMS_RATIO", "_OUTLIER_SIGMA"),
        *of("model_selection", "FOLDS"),
        *of("board_shape", "OFFSET_SIGMA", "SHAPE_SIGMA"),
        *of("bundle_problem", "HUBER_KNEE_SIGMA"),
        *of("camera_check", "_FALSE_ALARM_RATE", "_MAX_FOCAL_CHANGE", "_MAX_RMS_SHARE", "_MAX_RMS_RATIO", "MIN_VIEWS"),
        *of("calibration_notes", "_MAX_SIGMA_RATIO"),
        *of("cross_check", "_MAX_DIFFERENCE_SIGMA"),
        *of("corner_noise", "_MIN_REDUNDANCY"),
    ]


ROOM = Room("calibration", worlds, judged, _thresholds)
