"""Pictures of the calibration board, held in front of the sample's camera in many ways."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from samples.generator import backdrop
from samples.generator.camera import Camera, meet_plane, pixel_directions, pose, rotation_matrix, rotation_vector
from samples.generator.printed import Pattern, charuco_pattern, seen
from samples.generator.sensor import expose

QUALITY = 89
"""of the JPEG files"""

# Where the board's middle is held, as shares of the picture's width and height: all of it, the corners too.
_PLACES = (
    *((0.50, 0.50), (0.30, 0.36), (0.70, 0.36), (0.30, 0.66), (0.70, 0.66)),
    *((0.22, 0.26), (0.78, 0.26), (0.22, 0.76), (0.78, 0.76), (0.50, 0.28)),
    *((0.50, 0.76), (0.20, 0.50), (0.80, 0.50), (0.16, 0.20), (0.84, 0.20)),
    *((0.16, 0.82), (0.84, 0.82), (0.42, 0.46), (0.58, 0.58), (0.50, 0.50)),
)


def render_board_pictures(
    folder: str | Path, board: dict[str, Any], camera: Camera, seed: int, count: int = 20
) -> list[dict[str, Any]]:
    """Write 01.jpg, 02.jpg, ... and return the truth: for each picture `file` and the pose of the board in the camera.

    `board`: the contents of board.yaml (kind charuco). The pose is `rotation` (rotation vector, rad) and `translation`
    (m) of OpenCV's board frame: origin at the top left corner of the squares, x right, y down, z away from the viewer.
    """
    if board["kind"] != "charuco":
        raise ValueError(f"board kind {board['kind']!r}: only charuco can be rendered")
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    pattern = charuco_pattern(board)
    truth = []
    for k, T_camera_board in enumerate(board_poses(pattern, camera, seed, count)):
        name = f"{k + 1:02d}.jpg"
        picture = render_board(pattern, T_camera_board, camera, np.random.default_rng([seed, 4, k]))
        written, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
        if not written:
            raise OSError(f"{folder / name}: the picture could not be encoded")
        (folder / name).write_bytes(data.tobytes())
        rotation = rotation_vector(T_camera_board[:3, :3])
        truth.append({"file": name, "rotation": list(rotation), "translation": T_camera_board[:3, 3].tolist()})
    return truth


def board_poses(pattern: Pattern, camera: Camera, seed: int, count: int) -> list[NDArray[np.float64]]:
    """T_camera_board, each of shape (4, 4), m: places all over the picture, tilts up to 40 degrees all round."""
    rng = np.random.default_rng([seed, 3])
    width, height = pattern.extent
    middle = np.array([width / 2, height / 2, 0.0])
    poses = []
    for k in range(count):
        place = (np.array(_PLACES[k % len(_PLACES)]) + rng.uniform(-0.02, 0.02, 2)) * camera.size
        direction = np.append(camera.directions(place), 1.0)
        # the golden angle goes round evenly for any count; a lens is known by tilted views, so only a few are square
        azimuth = k * np.pi * (3 - np.sqrt(5))
        tilt = np.radians(3.0 if k % 7 == 0 else rng.uniform(15, 40))
        roll = rng.normal(0, np.radians(12))
        R = rotation_matrix([tilt * np.cos(azimuth), tilt * np.sin(azimuth), 0]) @ rotation_matrix([0, 0, roll])
        share = rng.uniform(0.38, 0.66)  # of the picture's width that the board takes
        distance = camera.fx * width / (share * camera.width)
        poses.append(pose(rotation_vector(R), distance * direction - R @ middle))
    return poses


def render_board(
    pattern: Pattern, T_camera_board: NDArray[np.float64], camera: Camera, rng: np.random.Generator | None
) -> NDArray[np.uint8]:
    """One grey picture, shape (h, w), of a board held still at a pose, shape (4, 4), m."""
    wall = backdrop.wall(camera, 0).mean(axis=-1)
    value, cover = seen(pattern, meet_plane(pixel_directions(camera), T_camera_board))
    towards = T_camera_board[:3, :3] @ [0.0, 0.0, -1.0]  # the printed side's normal
    lamp = np.array([-0.4, -0.5, -0.77])  # the window: left, above, behind the camera
    shade = 0.62 + 0.40 * max(0.0, float(towards @ lamp))
    scene = wall + cover * (shade * value - wall)
    return expose((scene * backdrop.light(camera)).astype(np.float32), camera, rng)
