"""What a set of views covers, and which picture to take next.

The next picture is the one that would reduce the projection's standard deviation over the picture most. Many poses of the board
are tried by adding their normal equations to those of the calibration; that needs no picture.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from calibration import lens
from calibration.board_poses import BoardPoses
from calibration.camera import Camera
from calibration.corner_detection import BoardView
from calibration.estimation import Calibration
from calibration.projection_uncertainty import board_information, picture_ninths, rays_by_rotation

COVERAGE_CELLS = (12, 9)
"""columns and rows of the cells in which corners are counted"""
_TILT_RAD = np.radians(35.0)
"""tilt of advised boards: more foreshortening costs corners, less says little of the focal length (docs/thresholds.md)"""
_FILLS = (0.35, 0.6, 0.85)
"""shares of the picture's lesser side that the lesser side of advised boards spans (docs/thresholds.md)"""
_MARGIN = 0.02
"""share of the picture's lesser side that stays free around an advised board"""
_MIN_SHARE = 0.6
"""share of the cells with corners, below which corners nearer the picture's edges are advised (docs/thresholds.md)"""
_MIN_TILT_DEG = 15
"""deg: upper quartile of the tilts, below which more tilt is advised (docs/thresholds.md)"""
_MIN_FILL = 0.3
"""median fill, below which nearer boards are advised (docs/thresholds.md)"""
_SIDES = ("right", "lower right", "lower", "lower left", "left", "upper left", "upper", "upper right")


@dataclass(frozen=True)
class Coverage:
    """Where in the picture corners lie, and how the boards were held."""

    counts: np.ndarray  # corners in each cell of the picture, shape CELLS[::-1]
    share: float  # of the cells with a corner
    missing: tuple[str, ...]  # names of the ninths of the picture without a corner
    tilts: np.ndarray  # of each board against the picture plane, rad
    distances: np.ndarray  # of each board's middle, m
    fills: np.ndarray  # lesser side of each view's corners over the picture's lesser side
    wants: tuple[str, ...]  # what should be added, in sentences; empty where nothing should


@dataclass(frozen=True)
class NextPicture:
    """The pose of a board that would improve the calibration most."""

    where: str  # ninth of the picture
    words: str  # how to hold the board, in a sentence
    R: np.ndarray  # p_camera = R p_board + t
    t: np.ndarray  # m
    outline: np.ndarray  # of the board's corners in the picture, shape (4, 2), px
    sigma_px: (
        float  # standard deviation of projection (rms over the picture) with this picture and those before it added
    )
    reduction: float  # by which this picture reduces it, as a share


def coverage_of(camera: Camera, views: Sequence[BoardView], poses: BoardPoses) -> Coverage:
    """What the views of a camera, with the board's poses in them, cover."""
    width, height = camera.size
    pixels = np.concatenate([view.image_points for view in views])
    edges = [
        np.linspace(-0.5, side - 0.5, cells + 1)
        for side, cells in ((height, COVERAGE_CELLS[1]), (width, COVERAGE_CELLS[0]))
    ]
    counts, _, _ = np.histogram2d(pixels[:, 1], pixels[:, 0], bins=edges)
    missing = tuple(
        name for name, rows, columns in picture_ninths(*COVERAGE_CELLS) if not np.any(counts[rows, columns])
    )
    tilts = np.arccos(np.clip(np.abs(poses.R[:, 2, 2]), 0.0, 1.0))
    middles = np.stack([view.object_points.mean(axis=0) for view in views])
    distances = np.einsum("nj,nj->n", poses.R[:, 2], middles) + poses.t[:, 2]
    fills = np.array([np.ptp(view.image_points, axis=0).min() / min(width, height) for view in views])
    share = float(np.mean(counts > 0))
    return Coverage(
        counts=counts,
        share=share,
        missing=missing,
        tilts=tilts,
        distances=distances,
        fills=fills,
        wants=_wants(share, missing, tilts, fills),
    )


def _wants(share: float, missing: tuple[str, ...], tilts: np.ndarray, fills: np.ndarray) -> tuple[str, ...]:
    """What should be added, in sentences."""
    wants = []
    if missing:
        wants.append(f"{', '.join(missing)} missing: hold the board there")
    elif share < _MIN_SHARE:
        wants.append(f"corners in {100 * share:.0f} % of the picture only: hold the board nearer its edges")
    steep = np.degrees(np.quantile(tilts, 0.75))
    if steep < _MIN_TILT_DEG:
        wants.append(
            f"tilt more: three of four boards are within {steep:.0f} degrees of the picture plane, take 20 to 40"
        )
    if np.median(fills) < _MIN_FILL:
        wants.append(
            f"nearer: half of the boards span less than {100 * np.median(fills):.0f} % of the picture's height"
        )
    return tuple(wants)


def next_pictures(calibration: Calibration, count: int = 3) -> tuple[NextPicture, ...]:
    """The `count` pictures that would improve the calibration most, best first, each in addition to those before it.

    Ninths of the picture without a corner come first: the standard deviation assumes the lens model there, untested.
    """
    camera = calibration.camera
    assert camera.covariance is not None
    free = np.array([lens.PARAMETER_NAMES.index(name) for name in calibration.free])
    at = np.ix_(free, free)
    # the jackknife's factor on sigma is kept, since corner noise and scatter between views keep their ratio
    sigma = calibration.sigma_least_squares[free]
    inflation = np.sqrt(np.diag(camera.covariance))[free] / sigma
    scale = np.outer(sigma, sigma)
    known = np.linalg.inv(camera.covariance[at] / np.outer(inflation, inflation) / scale)
    corner_variance = calibration.rms_px**2 / 2
    weight = _sigma_weight(camera)[at] * np.outer(inflation, inflation) * scale

    def sigma_px(normal: np.ndarray) -> float:
        return float(np.sqrt(np.trace(weight @ np.linalg.inv(normal))))

    board = np.unique(np.concatenate([view.object_points for view in calibration.views]), axis=0)
    candidates = _candidates(camera, board)
    gains = [board_information(camera, board @ R.T + t)[at] * scale / corner_variance for _, _, _, R, t in candidates]
    sigma_now = sigma_px(known)
    covered = coverage_of(camera, calibration.views, calibration.poses)
    chosen: list[NextPicture] = []
    while len(chosen) < count and candidates:
        untested = set(covered.missing) & {candidate[0] for candidate in candidates}
        after = [
            sigma_px(known + gain) if not untested or candidate[0] in untested else np.inf
            for gain, candidate in zip(gains, candidates, strict=True)
        ]
        best = int(np.argmin(after))
        where, side, fill, R, t = candidates[best]
        outline = _project(camera, _rectangle(board) @ R.T + t)
        words = _words(where, side, fill, covered)
        chosen.append(
            NextPicture(
                where=where,
                words=words,
                R=R,
                t=t,
                outline=outline,
                sigma_px=after[best],
                reduction=1 - after[best] / sigma_now,
            )
        )
        known, sigma_now = known + gains[best], after[best]
        # a person takes a second picture of the same place for a repetition
        keep = [i for i, candidate in enumerate(candidates) if candidate[0] != where]
        candidates, gains = [candidates[i] for i in keep], [gains[i] for i in keep]
    return tuple(chosen)


def _sigma_weight(camera: Camera) -> np.ndarray:
    """Q, shape (9, 9), such that trace(Q covariance) is the mean square of the projection's sigma over the picture."""
    u, v = (np.linspace(0, side - 1, n) for side, n in zip(camera.size, (16, 12), strict=True))
    rays = camera.rays(np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2))
    rays = rays[np.all(np.isfinite(rays), axis=1)]
    A = lens.parameter_jacobian(rays, camera.parameters).reshape(-1, 9)
    B = (lens.ray_jacobian(rays, camera.parameters) @ rays_by_rotation(rays)).reshape(-1, 3)
    residual = A - B @ np.linalg.lstsq(B, A, rcond=None)[0]
    return residual.T @ residual / len(rays)


def _candidates(camera: Camera, board: np.ndarray) -> list[tuple[str, int, float, np.ndarray, np.ndarray]]:
    """Poses with the whole board in the picture: ninth of the picture, far side (index of _SIDES), fill, R, t."""
    low, high = board.min(axis=0), board.max(axis=0)
    middle, extent = (low + high) / 2, (high - low)[:2]
    picture = np.array(camera.size, float)
    margin = _MARGIN * picture.min()
    names = [name for name, _, _ in picture_ninths(3, 3)]
    f = float(np.mean(camera.parameters[:2]))
    candidates = []
    for fill in _FILLS:
        distance = f * extent.min() / (fill * picture.min())
        for side in range(8):
            direction = np.pi / 4 * side
            # the axis of the rotation that takes the side at (cos, sin) of the picture away from the camera
            R = Rotation.from_rotvec(_TILT_RAD * np.array([np.sin(direction), -np.cos(direction), 0.0])).as_matrix()
            spread = (board - middle) @ R.T
            for k, name in enumerate(names):
                place = np.array([k % 3, k // 3]) / 2  # 0: at the left or upper edge, 1: at the right or lower one
                centre, room = np.array([0.0, 0.0, distance]), np.zeros(2)
                for _ in range(6):
                    pixels = _project(camera, spread + centre)
                    if not np.all(np.isfinite(pixels)):
                        break
                    first, last = pixels.min(axis=0), pixels.max(axis=0)
                    room = picture - 1 - 2 * margin - (last - first)
                    centre[:2] += (margin + place * room - first) * distance / f
                pixels = _project(camera, spread + centre)
                inside = np.all((pixels > margin / 2) & (pixels < picture - 1 - margin / 2))
                if inside and np.all(room > -margin):
                    candidates.append((name, side, fill, R, centre - R @ middle))
    return candidates


def _rectangle(board: np.ndarray) -> np.ndarray:
    """Corners of the board's bounding rectangle, shape (4, 3), m."""
    (x0, y0), (x1, y1) = board.min(axis=0)[:2], board.max(axis=0)[:2]
    return np.array([[x0, y0, 0.0], [x1, y0, 0.0], [x1, y1, 0.0], [x0, y1, 0.0]])


def _project(camera: Camera, points: np.ndarray) -> np.ndarray:
    """Points (n, 3) of the camera frame, m, to pixels (n, 2), NaN where the lens model has no inverse."""
    rays = points[:, :2] / points[:, 2:]
    pixels = lens.rays_to_pixels(rays, camera.parameters)
    pixels[(points[:, 2] <= 0) | ~lens.is_invertible(rays, camera.parameters)] = np.nan
    return pixels


def _words(where: str, side: int, fill: float, covered: Coverage) -> str:
    """The advice to hold the board so, in a sentence."""
    usual = float(np.median(covered.fills))
    near = "nearer than most so far" if fill > 1.25 * usual else "further away than most" if fill < 0.8 * usual else ""
    place = "in the middle of the picture" if where == "middle" else f"in the {where} of the picture"
    place = place.replace("upper middle", "middle of the upper edge").replace(
        "lower middle", "middle of the lower edge"
    )
    place = place.replace("middle left", "middle of the left edge").replace("middle right", "middle of the right edge")
    edge = f"{_SIDES[side]} {'edge' if ' ' not in _SIDES[side] else 'corner'}"
    return (
        f"hold the board {place}, tilted by {np.degrees(_TILT_RAD):.0f} degrees with its {edge} away from the camera, "
        f"spanning {100 * fill:.0f} % of the picture's lesser side" + (f" ({near})" if near else "")
    )
