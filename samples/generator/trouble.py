"""What comes between the markers and the camera: things in front of the arm, hard shadows, glare.

All of it stands still during one exposure; the arm moves behind it.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from samples.generator import scene
from samples.generator.camera import Camera
from samples.generator.sensor import FloatImage

ZOOM = 4
"""outlines are painted on a raster finer by this and then averaged"""


@dataclass(frozen=True)
class Glare:
    """A lamp mirrored in the picture: light added in a round spot."""

    place: complex
    """its middle in the plane of motion, m"""
    radius: float
    """standard deviation of its light, m"""
    strength: float
    """light in its middle, as a share of what makes white"""


@dataclass(frozen=True)
class Trouble:
    """What one frame suffers from."""

    in_front: tuple[scene.Shape, ...] = ()
    """before the arm and its markers"""
    shadows: tuple[scene.Shape, ...] = ()
    """their colour is the share of the light that is left"""
    glare: tuple[Glare, ...] = ()


NONE = Trouble()


def lay_in_front(light: FloatImage, trouble: Trouble, camera: Camera) -> None:
    """Put the things in front into a picture of reflectances, 0 .. 255, shape (h, w, 3)."""
    for shape in trouble.in_front:
        (rows, columns), cover = _cover(shape, camera)
        part = light[rows, columns]
        part += cover * (255 * np.array(shape.colour, np.float32) - part)


def spoil(light: FloatImage, trouble: Trouble, camera: Camera) -> None:
    """Cast the shadows and add the glare to the light that reaches the camera, shape (h, w, 3), 1 is white."""
    for shape in trouble.shadows:
        (rows, columns), cover = _cover(shape, camera)
        light[rows, columns] *= 1 - cover * (1 - np.array(shape.colour, np.float32))
    v, u = np.mgrid[: camera.height, : camera.width]
    for spot in trouble.glare:
        x, y = camera.project(np.array([spot.place.real, spot.place.imag]))
        wide = spot.radius * camera.fx / camera.translation[2]
        light += (spot.strength * np.exp(-((u - x) ** 2 + (v - y) ** 2) / (2 * wide**2)))[..., None].astype(np.float32)


def _cover(shape: scene.Shape, camera: Camera) -> tuple[tuple[slice, slice], FloatImage]:
    """The rows and columns that a shape may touch, and the share of each pixel there that it covers, shape (h, w, 1)."""
    left, top, right, bottom = scene.reach([shape], camera)
    right, bottom = max(left, right), max(top, bottom)
    place = slice(top, bottom), slice(left, right)
    if right == left or bottom == top:
        return place, np.zeros((bottom - top, right - left, 1), np.float32)
    canvas = np.zeros(((bottom - top) * ZOOM, (right - left) * ZOOM, 3), np.uint8)
    white = scene.Shape(shape.points, (1.0, 1.0, 1.0), shape.stroke, shape.depth)
    scene.paint(canvas, [white], camera, (left, top), ZOOM)
    share = cv2.resize(canvas[..., 0].astype(np.float32), (right - left, bottom - top), interpolation=cv2.INTER_AREA)
    return place, share[..., None] / np.float32(255)
