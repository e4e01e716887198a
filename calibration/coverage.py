"""What a set of views covers, and which picture to take next.

The next picture is the one that would reduce the projection's sigma over the picture most: many boards that could be held
are tried by adding their normal equations to those of the calibration. Nothing of it needs a picture.
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
_TILT = np.radians(35.0)  # of advised boards: more foreshortening costs corners, less tells little of the focal length
_FILLS = (0.35, 0.6, 0.85)  # of the picture's lesser side, spanned by the board's lesser side
_MARGIN = 0.02  # of the picture left around an advised board
_SIDES = ("right", "lower right", "lower", "lower left", "left", "upper left", "upper", "upper right")


@dataclass(frozen=True)
class Coverage:
    """Where corners were seen, and how the boards stood."""

    counts: np.ndarray  # corners in each cell of the picture, shape CELLS[::-1]
    share: float  # of the cells with a corner
    missing: tuple[str, ...]  # ninths of the picture without a corner
    tilts: np.ndarray  # of each board against the picture plane, rad
    distances: np.ndarray  # of each board's middle, m
    fills: np.ndarray  # lesser side of each view's corners over the picture's lesser side
    wants: tuple[str, ...]  # what is missing, in sentences; empty where nothing is


@dataclass(frozen=True)
class NextPicture:
    """A board held where it would tell most."""

    where: str  # ninth of the picture
    words: str  # a sentence for the person with the board
    R: np.ndarray  # p_camera = R p_board + t
    t: np.ndarray  # m
    outline: np.ndarray  # of the board's corners in the picture, shape (4, 2), px
    sigma_px: float  # of projection (rms over the picture) once this picture and those before it are added
    reduction: float  # of that sigma by this picture, as a share of it


def coverage_of(camera: Camera, views: Sequence[BoardView], poses: BoardPoses) -> Coverage:
    """What the views cover."""
    width, height = camera.size
    pixels = np.concatenate([view.image_points for view in views])
    edges = [np.linspace(-0.5, side - 0.5, cells + 1) for side, cells in ((height, COVERAGE_CELLS[1]), (width, COVERAGE_CELLS[0]))]
    counts, _, _ = np.histogram2d(pixels[:, 1], pixels[:, 0], bins=edges)
    missing = tuple(name for name, rows, columns in picture_ninths(*COVERAGE_CELLS) if not np.any(counts[rows, columns]))
    tilts = np.arccos(np.clip(np.abs(poses.R[:, 2, 2]), 0.0, 1.0))
    middles = np.stack([view.object_points.mean(axis=0) for view in views])
    distances = np.einsum("nj,nj->n", poses.R[:, 2], middles) + poses.t[:, 2]
    fills = np.array([np.ptp(view.image_points, axis=0).min() / min(width, height) for view in views])
    share = float(np.mean(counts > 0))
    return Coverage(counts, share, missing, tilts, distances, fills, _wants(share, missing, tilts, fills))


def _wants(share: float, missing: tuple[str, ...], tilts: np.ndarray, fills: np.ndarray) -> tuple[str, ...]:
    wants = []
    if missing:
        wants.append(f"{', '.join(missing)} missing: hold the board there")
    elif share < 0.6:
        wants.append(f"corners in {100 * share:.0f} % of the picture only: hold the board nearer its edges")
    steep = np.degrees(np.quantile(tilts, 0.75))
    if steep < 15:
        wants.append(
            f"tilt more: three of four boards are within {steep:.0f} degrees of the picture plane, take 20 to 40"
        )
    if np.median(fills) < 0.3:
        wants.append(
            f"nearer: half of the boards span less than {100 * np.median(fills):.0f} % of the picture's height"
        )
    return tuple(wants)


def next_pictures(calibration: Calibration, count: int = 3) -> tuple[NextPicture, ...]:
    """The `count` pictures that would help most, best first, each on top of those before it.

    Ninths of the picture without a corner come first: sigma takes the lens model for true there, and nothing has tested it.
    """
    camera = calibration.camera
    assert camera.covariance is not None
    free = np.array([lens.PARAMETER_NAMES.index(name) for name in calibration.free])
    at = np.ix_(free, free)
    # corners' noise and the spread between views keep their ratio: the jackknife's factor stays, the information grows
    sigma = calibration.sigma_least_squares[free]
    grow = np.sqrt(np.diag(camera.covariance))[free] / sigma
    scale = np.outer(sigma, sigma)
    known = np.linalg.inv(camera.covariance[at] / np.outer(grow, grow) / scale)
    corner_variance = calibration.rms_px**2 / 2
    feel = _feeling(camera)[at] * np.outer(grow, grow) * scale

    def sigma_px(normal: np.ndarray) -> float:
        return float(np.sqrt(np.trace(feel @ np.linalg.inv(normal))))

    board = np.unique(np.concatenate([view.object_points for view in calibration.views]), axis=0)
    candidates = _candidates(camera, board)
    worth = [board_information(camera, board @ R.T + t)[at] * scale / corner_variance for _, _, _, R, t in candidates]
    now = sigma_px(known)
    seen = coverage_of(camera, calibration.views, calibration.poses)
    out: list[NextPicture] = []
    while len(out) < count and candidates:
        untested = set(seen.missing) & {candidate[0] for candidate in candidates}
        after = [
            sigma_px(known + more) if not untested or candidate[0] in untested else np.inf
            for more, candidate in zip(worth, candidates, strict=True)
        ]
        best = int(np.argmin(after))
        where, side, fill, R, t = candidates[best]
        outline = _project(camera, _rectangle(board) @ R.T + t)
        words = _words(where, side, fill, seen)
        out.append(NextPicture(where, words, R, t, outline, after[best], 1 - after[best] / now))
        known, now = known + worth[best], after[best]
        # a second picture of the same place says less to a person than one elsewhere
        keep = [i for i, candidate in enumerate(candidates) if candidate[0] != where]
        candidates, worth = [candidates[i] for i in keep], [worth[i] for i in keep]
    return tuple(out)


def _feeling(camera: Camera) -> np.ndarray:
    """Q with trace(Q covariance) the mean square of the projection's sigma over the picture, shape (9, 9)."""
    u, v = (np.linspace(0, side - 1, n) for side, n in zip(camera.size, (16, 12), strict=True))
    rays = camera.rays(np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2))
    rays = rays[np.all(np.isfinite(rays), axis=1)]
    A = lens.parameter_jacobian(rays, camera.parameters).reshape(-1, 9)
    B = (lens.ray_jacobian(rays, camera.parameters) @ rays_by_rotation(rays)).reshape(-1, 3)
    left = A - B @ np.linalg.lstsq(B, A, rcond=None)[0]
    return left.T @ left / len(rays)


def _candidates(camera: Camera, board: np.ndarray) -> list[tuple[str, int, float, np.ndarray, np.ndarray]]:
    """Boards that could be held: ninth of the picture, side that is away (of _SIDES), fill, R, t; whole in the picture."""
    low, high = board.min(axis=0), board.max(axis=0)
    middle, extent = (low + high) / 2, (high - low)[:2]
    picture = np.array(camera.size, float)
    margin = _MARGIN * picture.min()
    names = [name for name, _, _ in picture_ninths(3, 3)]
    f = float(np.mean(camera.parameters[:2]))
    out = []
    for fill in _FILLS:
        distance = f * extent.min() / (fill * picture.min())
        for side in range(8):
            away = np.pi / 4 * side
            # the axis of the turn whose right-hand side goes away towards (cos away, sin away) of the picture
            R = Rotation.from_rotvec(_TILT * np.array([np.sin(away), -np.cos(away), 0.0])).as_matrix()
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
                    out.append((name, side, fill, R, centre - R @ middle))
    return out


def _rectangle(board: np.ndarray) -> np.ndarray:
    """Corners of the board's bounding rectangle, shape (4, 3), m."""
    (x0, y0), (x1, y1) = board.min(axis=0)[:2], board.max(axis=0)[:2]
    return np.array([[x0, y0, 0.0], [x1, y0, 0.0], [x1, y1, 0.0], [x0, y1, 0.0]])


def _project(camera: Camera, points: np.ndarray) -> np.ndarray:
    """Points of the camera frame to pixels, NaN where the lens model has turned back."""
    rays = points[:, :2] / points[:, 2:]
    pixels = lens.rays_to_pixels(rays, camera.parameters)
    pixels[(points[:, 2] <= 0) | ~lens.is_invertible(rays, camera.parameters)] = np.nan
    return pixels


def _words(where: str, side: int, fill: float, seen: Coverage) -> str:
    usual = float(np.median(seen.fills))
    near = "nearer than most so far" if fill > 1.25 * usual else "further away than most" if fill < 0.8 * usual else ""
    place = "in the middle of the picture" if where == "middle" else f"in the {where} of the picture"
    place = place.replace("upper middle", "middle of the upper edge").replace(
        "lower middle", "middle of the lower edge"
    )
    place = place.replace("middle left", "middle of the left edge").replace("middle right", "middle of the right edge")
    edge = f"{_SIDES[side]} {'edge' if ' ' not in _SIDES[side] else 'corner'}"
    return (
        f"hold the board {place}, tilted by {np.degrees(_TILT):.0f} degrees with its {edge} away from the camera, "
        f"spanning {100 * fill:.0f} % of the picture's lesser side" + (f" ({near})" if near else "")
    )
