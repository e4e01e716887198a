"""What is behind the arm: the wall of a laboratory, out of focus, and the light of a window from the upper left."""

from functools import lru_cache

import cv2
import numpy as np

from samples.generator.camera import Camera
from samples.generator.sensor import FloatImage

WALL = (0.47, 0.49, 0.50)
"""reflectance, red, green, blue"""


@lru_cache(maxsize=4)
def wall(camera: Camera, seed: int) -> FloatImage:
    """Reflectance of the background, shape (h, w, 3): low contrast, with nothing that a marker could be taken for."""
    rng = np.random.default_rng([seed, 1])
    w, h = camera.size
    picture = np.empty((h, w, 3), np.float32)
    picture[:] = WALL
    _pinboard(picture, rng)
    _shelf(picture, rng)
    for x, sag in ((0.05, 0.10), (0.86, -0.06)):  # cables that hang on the wall
        y = np.linspace(0, 1, 40)
        line = np.stack([(x + sag * np.sin(2.2 * y)) * w, y * h], axis=-1)
        cv2.polylines(picture, [np.rint(line).astype(np.int32)], False, (0.38, 0.385, 0.40), max(2, w // 180))
    picture = cv2.GaussianBlur(picture, (0, 0), w / 210)
    picture *= _mottle(rng, h, w)[..., None]
    picture.flags.writeable = False
    return picture


@lru_cache(maxsize=4)
def light(camera: Camera) -> FloatImage:
    """Light on the scene, shape (h, w): brighter towards the upper left, with a soft pool around the arm."""
    w, h = camera.size
    v, u = np.mgrid[0:h, 0:w].astype(np.float32)
    x, y = u / w - 0.5, v / h - 0.5
    field = (0.99 - 0.17 * x - 0.12 * y - 0.10 * (x + 0.1) ** 2).astype(np.float32)
    field.flags.writeable = False
    return field


def _pinboard(picture: FloatImage, rng: np.random.Generator) -> None:
    h, w = picture.shape[:2]
    left, top, right, bottom = (np.array([0.66, 0.08, 0.97, 0.52]) * [w, h, w, h]).astype(int).tolist()
    cv2.rectangle(picture, (left, top), (right, bottom), (0.45, 0.42, 0.37), -1)
    for x in (0.05, 0.37, 0.68):
        for y in (0.10, 0.56):
            sheet = 0.52 + 0.05 * rng.random()
            a = int(left + x * (right - left)), int(top + y * (bottom - top))
            b = a[0] + int(0.25 * (right - left)), a[1] + int(0.34 * (bottom - top))
            cv2.rectangle(picture, a, b, (sheet, sheet, 0.96 * sheet), -1)


def _shelf(picture: FloatImage, rng: np.random.Generator) -> None:
    h, w = picture.shape[:2]
    board = int(0.60 * h)
    x = 0.02 * w
    while x < 0.30 * w:  # books and boxes
        wide, tall = (0.012 + 0.03 * rng.random()) * w, (0.10 + 0.16 * rng.random()) * h
        tint = (0.36 + 0.16 * rng.random(3)).tolist()
        cv2.rectangle(picture, (int(x), int(board - tall)), (int(x + wide), board), tint, -1)
        x += wide + 0.002 * w
    cv2.rectangle(picture, (0, board), (int(0.33 * w), board + h // 50), (0.40, 0.37, 0.34), -1)


def _mottle(rng: np.random.Generator, h: int, w: int) -> FloatImage:
    """Roughcast: smooth blotches of about 1.5 %, shape (h, w)."""
    coarse = rng.standard_normal((h // 12 + 2, w // 12 + 2)).astype(np.float32)
    return (1 + 0.015 * cv2.resize(coarse, (w, h), interpolation=cv2.INTER_CUBIC)).astype(np.float32)
