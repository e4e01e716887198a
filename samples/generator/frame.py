"""One frame: the arm and its markers, averaged over the exposure, seen by the camera."""

from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from samples.generator import backdrop, linkage, scene, trouble
from samples.generator.camera import Camera, meet_plane, pixel_directions
from samples.generator.printed import Pattern, marker_pattern, seen
from samples.generator.sensor import FloatImage, expose

ZOOM = 2
"""The arm is painted on a raster finer by this and then averaged; markers need none of it."""


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
    `neck`: the contents of neck.yaml, with or without markers; the markers are where it says.
    `suffers`: what comes between the markers and the camera.
    """
    still = _still(camera, wall_seed, float(neck["mechanisms"][0]["b"]))
    light = cv2.resize(still, camera.size, interpolation=cv2.INTER_AREA).astype(np.float32)
    instants = np.atleast_2d(np.asarray(alpha, dtype=float))
    shapes = [scene.arm(a, neck, payload) for a in instants]
    laid = [plates(a, neck) for a in instants]
    sheets = [_outline(*plate) for instant in laid for plate in instant]
    left, top, right, bottom = scene.reach([*sheets, *(s for instant in shapes for s in instant)], camera)
    part = np.zeros((bottom - top, right - left, 3), np.float32)
    for instant, on_bars in zip(shapes, laid, strict=True):
        canvas = still[top * ZOOM : bottom * ZOOM, left * ZOOM : right * ZOOM].copy()
        scene.paint(canvas, instant, camera, (left, top), ZOOM)
        now = cv2.resize(canvas, (right - left, bottom - top), interpolation=cv2.INTER_AREA).astype(np.float32)
        for pattern, place, angle in on_bars:
            _lay(now, pattern, place, angle, camera, (left, top))
        part += now
    light[top:bottom, left:right] = part / len(instants)
    trouble.lay_in_front(light, suffers, camera)
    light *= backdrop.light(camera)[..., None] / np.float32(255)
    trouble.spoil(light, suffers, camera)
    return expose(light, camera, rng)


def plates(alpha: NDArray[np.float64], neck: dict[str, Any]) -> list[tuple[Pattern, complex, float]]:
    """The marker plates: what is printed, where its middle is (m, in the plane) and how its x axis is turned (rad)."""
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
        found.append((pattern, place, turn + on.get("angle", 0.0)))
    return found


def on_plane(pattern: Pattern, points: NDArray[np.float64], place: complex, angle: float) -> NDArray[np.float64]:
    """Points of a pattern, shape (..., 2), m, in the plane of motion, its middle at `place`, turned by `angle`."""
    w, h = pattern.extent
    z = place + np.exp(1j * angle) * (points[..., 0] - w / 2 + 1j * (h / 2 - points[..., 1]))
    return np.stack([z.real, z.imag], axis=-1)


def _outline(pattern: Pattern, place: complex, angle: float) -> scene.Shape:
    corners = on_plane(pattern, pattern.sheet(), place, angle)
    return scene.Shape(corners[:, 0] + 1j * corners[:, 1], (0.0, 0.0, 0.0))


def _lay(
    image: FloatImage, pattern: Pattern, place: complex, angle: float, camera: Camera, origin: tuple[int, int]
) -> None:
    """Lay a plate over `image`, shape (h, w, 3), levels of 0..255, whose first pixel is the camera's pixel `origin`."""
    corners = camera.project(on_plane(pattern, pattern.sheet(), place, angle)) - origin
    h, w = image.shape[:2]
    (x0, y0), (x1, y1) = np.floor(corners.min(axis=0)).astype(int) - 2, np.ceil(corners.max(axis=0)).astype(int) + 3
    x0, y0, x1, y1 = max(0, x0), max(0, y0), min(w, x1), min(h, y1)
    if x1 - x0 < 2 or y1 - y0 < 2:  # out of the picture
        return
    plane = _plane_map(camera)[y0 + origin[1] : y1 + origin[1], x0 + origin[0] : x1 + origin[0]]
    z = (plane[..., 0] + 1j * plane[..., 1] - place) * np.exp(-1j * angle)
    width, height = pattern.extent
    value, cover = seen(pattern, np.stack([z.real + width / 2, height / 2 - z.imag], axis=-1))
    patch = image[y0:y1, x0:x1]
    patch += (cover[..., None] * (255 * value[..., None] - patch)).astype(np.float32)


@lru_cache(maxsize=4)
def _plane_map(camera: Camera) -> NDArray[np.float64]:
    """Where each pixel's centre meets the plane of motion, shape (h, w, 2), m."""
    return meet_plane(pixel_directions(camera), camera.T_camera_base)


@lru_cache(maxsize=4)
def _still(camera: Camera, wall_seed: int, b: float) -> NDArray[np.uint8]:
    """What never moves, on the finer raster, shape (ZOOM h, ZOOM w, 3)."""
    wall = np.rint(255 * backdrop.wall(camera, wall_seed))
    fine = cv2.resize(wall, (camera.width * ZOOM, camera.height * ZOOM), interpolation=cv2.INTER_LINEAR)
    canvas = np.rint(fine).astype(np.uint8)
    scene.paint(canvas, scene.base(b), camera, (0, 0), ZOOM)
    canvas.flags.writeable = False
    return canvas
