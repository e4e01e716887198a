"""One frame: the arm and its markers, averaged over the exposure, seen by the camera."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from samples.generator import backdrop, linkage, scene, trouble
from samples.generator.camera import Camera, meet_plane, pixel_directions, rotation_matrix
from samples.generator.printed import Pattern, marker_pattern, seen
from samples.generator.sensor import FloatImage, expose

ZOOM = 2
"""The arm is painted on a raster finer by this and then averaged; markers need none of it."""


@dataclass(frozen=True)
class Plate:
    """A marker that is mounted on its bar."""

    pattern: Pattern
    place: complex
    """of its middle, along the plane of motion, m"""
    angle: float
    """by which its x axis is turned in that plane, rad"""
    depth: float = 0.0
    """of its middle before that plane, m"""
    tilt: tuple[float, float] = (0.0, 0.0)
    """out of that plane, a rotation vector along its own x and y, rad"""

    @property
    def T_base_plate(self) -> NDArray[np.float64]:
        """Its pose, (4, 4): x right and y up on the pattern, from its middle."""
        T = np.eye(4)
        T[:3, :3] = rotation_matrix((0.0, 0.0, self.angle)) @ rotation_matrix((*self.tilt, 0.0))
        T[:3, 3] = self.place.real, self.place.imag, self.depth
        return T

    def points(self, on_pattern: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points of the base frame, (n, 3), m, of points of the pattern, (n, 2), m."""
        w, h = self.pattern.extent
        flat = np.stack([on_pattern[:, 0] - w / 2, h / 2 - on_pattern[:, 1], np.zeros(len(on_pattern))])
        return (self.T_base_plate[:3, :3] @ flat).T + self.T_base_plate[:3, 3]


def render_frame(
    alpha: NDArray[np.float64],
    neck: dict[str, Any],
    camera: Camera,
    rng: np.random.Generator | None = None,
    *,
    payload: bool = True,
    wall_seed: int = 0,
    suffers: trouble.Trouble = trouble.NONE,
) -> NDArray[np.uint8]:
    """A colour picture (red, green, blue), shape (h, w, 3).

    `alpha`, shape (S, N), rad: the joint angles in the middle of S equal parts of the exposure; (N,) for one at rest.
    `neck`: the contents of neck.yaml, with or without markers; the markers are where it says, and tilted by their `tilt` where
    they have one.
    `suffers`: what comes between the markers and the camera.
    """
    still = _still(camera, wall_seed, float(neck["mechanisms"][0]["b"]))
    light = cv2.resize(still, camera.size, interpolation=cv2.INTER_AREA).astype(np.float32)
    instants = np.atleast_2d(np.asarray(alpha, dtype=float))
    shapes = [scene.arm(a, neck, payload) for a in instants]
    laid = [plates(a, neck) for a in instants]
    sheets = [_outline(plate) for instant in laid for plate in instant]
    left, top, right, bottom = scene.reach([*sheets, *(s for instant in shapes for s in instant)], camera)
    part = np.zeros((bottom - top, right - left, 3), np.float32)
    for instant, on_bars in zip(shapes, laid, strict=True):
        canvas = still[top * ZOOM : bottom * ZOOM, left * ZOOM : right * ZOOM].copy()
        scene.paint(canvas, instant, camera, (left, top), ZOOM)
        now = cv2.resize(canvas, (right - left, bottom - top), interpolation=cv2.INTER_AREA).astype(np.float32)
        for plate in on_bars:
            _lay(now, plate, camera, (left, top))
        part += now
    light[top:bottom, left:right] = part / len(instants)
    trouble.lay_in_front(light, suffers, camera)
    light *= backdrop.light(camera)[..., None] / np.float32(255)
    trouble.spoil(light, suffers, camera)
    return expose(light, camera, rng)


def plates(alpha: NDArray[np.float64], neck: dict[str, Any]) -> list[Plate]:
    """The markers on their bars at joint angles `alpha`, (N,), rad."""
    markers = neck.get("markers")
    if not markers:
        return []
    L, b = (np.array([float(m[key]) for m in neck["mechanisms"]]) for key in ("L", "b"))
    bars = linkage.solve(alpha, L, b)
    found = []
    for on in markers["on_bars"]:
        if on.get("diagonal"):
            middle, turn = linkage.diagonal(bars, b, on["diagonal"])
        else:
            middle, turn = bars.middle[on["bar"]], float(bars.orientation[on["bar"]])
        place = middle + complex(*on.get("at", (0.0, 0.0))) * np.exp(1j * turn)
        pattern = marker_pattern(markers["dictionary"], on["id"], float(on.get("size", markers["size"])))
        depth, tilt = float(on.get("depth") or 0.0), on.get("tilt", (0.0, 0.0))
        found.append(Plate(pattern, place, turn + on.get("angle", 0.0), depth, (tilt[0], tilt[1])))
    return found


def _outline(plate: Plate) -> scene.Shape:
    corners = plate.points(plate.pattern.sheet())
    return scene.Shape(corners[:, 0] + 1j * corners[:, 1], (0.0, 0.0, 0.0), depth=-plate.depth)


def _lay(image: FloatImage, plate: Plate, camera: Camera, origin: tuple[int, int]) -> None:
    """Lay a plate over `image`, shape (h, w, 3), levels of 0..255, whose first pixel is the camera's pixel `origin`."""
    pattern = plate.pattern
    corners = camera.project(plate.points(pattern.sheet())) - origin
    h, w = image.shape[:2]
    (x0, y0), (x1, y1) = np.floor(corners.min(axis=0)).astype(int) - 2, np.ceil(corners.max(axis=0)).astype(int) + 3
    x0, y0, x1, y1 = max(0, x0), max(0, y0), min(w, x1), min(h, y1)
    if x1 - x0 < 2 or y1 - y0 < 2:  # out of the picture
        return
    directions = pixel_directions(camera)[y0 + origin[1] : y1 + origin[1], x0 + origin[0] : x1 + origin[0]]
    x, y = np.moveaxis(meet_plane(directions, camera.T_camera_base @ plate.T_base_plate), -1, 0)
    width, height = pattern.extent
    value, cover = seen(pattern, np.stack([x + width / 2, height / 2 - y], axis=-1))
    patch = image[y0:y1, x0:x1]
    patch += (cover[..., None] * (255 * value[..., None] - patch)).astype(np.float32)


@lru_cache(maxsize=4)
def _still(camera: Camera, wall_seed: int, b: float) -> NDArray[np.uint8]:
    """What never moves, on the finer raster, shape (ZOOM h, ZOOM w, 3)."""
    wall = np.rint(255 * backdrop.wall(camera, wall_seed))
    fine = cv2.resize(wall, (camera.width * ZOOM, camera.height * ZOOM), interpolation=cv2.INTER_LINEAR)
    canvas = np.rint(fine).astype(np.uint8)
    scene.paint(canvas, scene.base(b), camera, (0, 0), ZOOM)
    canvas.flags.writeable = False
    return canvas
