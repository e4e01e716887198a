"""One picture of the arm: plates resampled on a raster FINE times as fine, spread by the lens, then what the sensor makes of it."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from samples.second_camera.arm import Links, links
from samples.second_camera.world import World

Array = NDArray[np.float64]
Single = NDArray[np.float32]

FINE = 4
"""samples of a pixel along either side"""
TEXELS = 24
"""of a cell along its side in the drawing of a marker"""
QUIET = 1.2
"""cells of paper around a marker"""
MARGIN = 8
"""px around a plate that are drawn finely"""

_LEVELS = np.arange(4096) / 4095
_TONE_CURVE = np.where(
    _LEVELS < 0.0031308, 12.92 * _LEVELS, 1.055 * np.maximum(_LEVELS, 1e-9) ** (1 / 2.4) - 0.055
).astype(np.float32)
"""sRGB's, of the sensor's 12 bits"""


class Studio:
    """What stays the same from picture to picture of a world."""

    def __init__(self, world: World) -> None:
        self.world = world
        w, h = world.lens.size
        v, u = np.mgrid[0:h, 0:w].astype(np.float32)
        at = np.stack([u.ravel(), v.ravel()], axis=-1)[:, None]
        stop = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-12)
        rays = cv2.undistortPoints(at.astype(float), world.lens.K, world.lens.distortion, criteria=stop)
        self._rays = rays.reshape(h, w, 2).astype(np.float32)
        self._prints = {
            m["id"]: _print(world.neck["markers"]["dictionary"], m["id"]) for m in world.neck["markers"]["on_bars"]
        }
        self._spread = _point_spread(world.optics.defocus, world.optics.aberration)
        rng = np.random.default_rng([78, world.seed])
        wall = sum(
            cv2.resize(rng.normal(0, a, (h // s + 2, w // s + 2)), (w, h), interpolation=cv2.INTER_CUBIC)
            for s, a in ((90, 0.05), (22, 0.03), (6, 0.015))
        )
        slope = world.optics.light_slope * ((u / w - 0.5) * rng.uniform(-1, 1) + (v / h - 0.5) * rng.uniform(-1, 1))
        self._wall = np.clip(0.33 + np.asarray(wall, np.float32), 0.03, 0.9)
        self._light = (1 + slope).astype(np.float32)
        self._noise = rng.standard_normal((2 * h, 2 * w), dtype=np.float32)
        self._rng = rng

    def picture(self, t: float) -> NDArray[np.uint8]:
        """(height, width, 3), blue, green, red, of the exposure whose middle row's middle is at `t`."""
        world, optics = self.world, self.world.optics
        moments = t + optics.exposure_s * ((np.arange(optics.instants) + 0.5) / optics.instants - 0.5)
        light = self._background(t)
        for marker in world.neck["markers"]["on_bars"]:
            self._lay(light, marker, t, moments)
        self._spoil(light, t)
        return self._developed(light * self._light, t)

    def _background(self, t: float) -> Single:
        """The wall and the bars, spread by the lens; people see them, nothing is measured by them."""
        canvas = self._wall.copy()
        pose = links(self.world.alpha_at(t), self.world.neck)
        for i in range(1, len(pose.turns)):
            for a, b in ((pose.ends[i - 1, 0], pose.ends[i, 1]), (pose.ends[i - 1, 1], pose.ends[i, 0])):
                self._bar(canvas, t, a, b, 0.55, 9)
        for left, right in pose.ends:
            self._bar(canvas, t, left, right, 0.12, 13)
        return np.asarray(cv2.GaussianBlur(canvas, (0, 0), 0.8), np.float32)

    def _bar(self, canvas: Single, t: float, a: Array, b: Array, level: float, wide: int) -> None:
        ends = self._pixels(np.array([[*a, -0.012], [*b, -0.012]]), t)
        first, last = np.rint(ends * 16).astype(int).tolist()
        cv2.line(canvas, first, last, level, wide, cv2.LINE_AA, 4)

    def _pixels(self, points: Array, t: float) -> Array:
        rvec, tvec = self.world.pose_at(t)
        lens = self.world.lens
        pixels = cv2.projectPoints(points, rvec, tvec, lens.K, lens.distortion)[0]
        return np.asarray(pixels, dtype=float).reshape(-1, 2)

    def _lay(self, light: Single, marker: dict[str, Any], t: float, moments: Array) -> None:
        """One marker's plate over the picture."""
        world, optics = self.world, self.world.optics
        size = float(world.neck["markers"]["size"])
        print_, cells = self._prints[marker["id"]]
        half = size / 2 * (1 + 2 * QUIET / cells)
        square = half * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0.0]])
        outlines = []
        for moment in (moments[0], moments[-1]):
            R, at = _mounted(links(world.alpha_at(moment), world.neck), marker)
            outlines.append(self._pixels(square @ R.T + at, moment))
        corners = np.concatenate(outlines)
        w, h = world.lens.size
        low = np.clip(np.floor(corners.min(axis=0)).astype(int) - MARGIN, 0, (w, h))
        high = np.clip(np.ceil(corners.max(axis=0)).astype(int) + MARGIN, 0, (w, h))
        if np.any(high - low < 2 * MARGIN + 2):
            return
        (x0, y0), (x1, y1) = low, high
        wide, tall = (x1 - x0) * FINE, (y1 - y0) * FINE
        u = ((np.arange(wide) + 0.5) / FINE - 0.5 + x0).astype(np.float32)
        v = ((np.arange(tall) + 0.5) / FINE - 0.5 + y0).astype(np.float32)
        U, V = np.meshgrid(u, v)
        rays = np.asarray(cv2.remap(self._rays, U, V, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE), np.float32)
        value, cover = np.zeros((tall, wide), np.float32), np.zeros((tall, wide), np.float32)
        rows = (v - (h - 1) / 2) * optics.row_s
        share = ((v - v[0]) / (v[-1] - v[0]))[:, None].astype(np.float32)
        for moment in moments:
            first = self._on_plate(rays, marker, moment + float(rows[0]))
            place = first
            if optics.row_s:
                last = self._on_plate(rays, marker, moment + float(rows[-1]))
                place = [a + share * (b - a) for a, b in zip(first, last, strict=True)]
            per_metre = TEXELS * cells / size
            middle = (len(print_) - 1) / 2
            x, y = place[0] * per_metre + middle, middle - place[1] * per_metre
            black = cv2.remap(print_, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
            inside = ((np.abs(place[0]) < half) & (np.abs(place[1]) < half)).astype(np.float32)
            value += inside * (optics.ink + (optics.paper - optics.ink) * np.asarray(black, np.float32))
            cover += inside
        value /= np.float32(len(moments))
        cover /= np.float32(len(moments))
        if optics.cable:
            self._cable(value, cover, marker, t, (x0, y0))
        both = cv2.filter2D(np.dstack([value, cover]), -1, self._spread)
        value, cover = np.moveaxis(cv2.resize(both, (x1 - x0, y1 - y0), interpolation=cv2.INTER_AREA), -1, 0)
        part = light[y0:y1, x0:x1]
        part += value - cover * part

    def _on_plate(self, rays: Single, marker: dict[str, Any], moment: float) -> list[Single]:
        """x and y, m, on a plate, of rays (h, w, 2) that meet it."""
        R, at = _mounted(links(self.world.alpha_at(moment), self.world.neck), marker)
        rvec, tvec = self.world.pose_at(moment)
        camera = cv2.Rodrigues(rvec)[0]
        H = np.linalg.inv(np.column_stack([camera @ R[:, 0], camera @ R[:, 1], camera @ at + tvec]))
        x, y = rays[..., 0].astype(float), rays[..., 1].astype(float)
        X, Y, W = (H[i, 0] * x + H[i, 1] * y + H[i, 2] for i in range(3))
        return [(X / W).astype(np.float32), (Y / W).astype(np.float32)]

    def _cable(self, value: Single, cover: Single, marker: dict[str, Any], t: float, origin: tuple[int, int]) -> None:
        middle, _ = links(self.world.alpha_at(t), self.world.neck).carrier(marker)
        size = float(self.world.neck["markers"]["size"])
        x = middle[0] + 0.35 * size * np.sin(1.7 * t + 2.1 * int(marker["id"]))
        ends = np.array([[x - 0.5 * size, middle[1] - 2 * size, 0.02], [x + 0.5 * size, middle[1] + 2 * size, 0.02]])
        pixels = (self._pixels(ends, t) - origin + 0.5) * FINE - 0.5
        across = self.world.optics.cable * self.world.lens.K[0, 0] / self.world.lens.tvec[2] * FINE
        first, last = np.rint(pixels * 16).astype(int).tolist()
        for canvas, level in ((value, 0.06), (cover, 1.0)):
            cv2.line(canvas, first, last, level, max(1, round(across)), cv2.LINE_AA, 4)

    def _spoil(self, light: Single, t: float) -> None:
        optics = self.world.optics
        if not (optics.glare or optics.shadow):
            return
        h, w = light.shape
        v, u = np.mgrid[0:h, 0:w].astype(np.float32)
        if optics.shadow:
            edge = w * (0.5 + 0.12 * np.sin(0.9 * t))
            light *= 1 - optics.shadow / (1 + np.exp(-(u - edge) / 3))
        if optics.glare:
            for marker in self.world.neck["markers"]["on_bars"][1:]:
                middle, _ = links(np.zeros(len(self.world.neck["mechanisms"])), self.world.neck).carrier(marker)
                x, y = self._pixels(np.array([[*middle, 0.0]]), t)[0] + 12 * np.array(
                    [np.sin(0.7 * t), np.cos(1.1 * t)]
                )
                light += optics.glare * np.exp(-((u - x) ** 2 + (v - y) ** 2) / (2 * 9.0**2))

    def _developed(self, light: Single, t: float) -> NDArray[np.uint8]:
        """The sensor's electrons, colours and what the camera makes of them."""
        optics = self.world.optics
        middle, swing = optics.gain
        signal = np.maximum(light, 0) * middle * (1 + swing * np.sin(0.8 * t))
        h, w = signal.shape
        y, x = self._rng.integers(0, (h, w))
        electrons = signal * optics.full_well
        noisy = (
            signal
            + self._noise[y : y + h, x : x + w] * np.sqrt(electrons + optics.read_electrons**2) / optics.full_well
        )
        raw = np.clip(noisy * 4095, 0, 4095).astype(np.uint16)
        if optics.coloured:
            raw = cv2.cvtColor(raw, cv2.COLOR_BayerRG2BGR)
        colour = _TONE_CURVE[raw] if optics.tone_curve else raw.astype(np.float32) / 4095
        if not optics.coloured:
            colour = np.repeat(colour[..., None], 3, axis=2)
        if optics.sharpening:
            colour = colour + optics.sharpening * (colour - cv2.GaussianBlur(colour, (0, 0), 1.0))
        return np.clip(np.rint(255 * colour), 0, 255).astype(np.uint8)


def _mounted(pose: Links, marker: dict[str, Any]) -> tuple[Array, Array]:
    """Rotation (3, 3) and middle (3,), m, of a marker's plate in the base frame: x to the right on it, y up."""
    middle, turn = pose.carrier(marker)
    c, s = np.cos(turn), np.sin(turn)
    at = middle + np.array([[c, -s], [s, c]]) @ np.asarray(marker.get("at", (0.0, 0.0)), dtype=float)
    whole = turn + float(marker.get("angle", 0.0))
    flat = np.array([[np.cos(whole), -np.sin(whole), 0], [np.sin(whole), np.cos(whole), 0], [0, 0, 1]])
    lean = np.asarray(cv2.Rodrigues(np.array([*marker.get("tilt", (0.0, 0.0)), 0.0]))[0], dtype=float)
    return flat @ lean, np.array([*at, float(marker.get("depth") or 0.0)])


def _print(dictionary: str, number: int) -> tuple[Single, int]:
    """A marker on its paper, 1 is paper, and how many cells it has along a side."""
    name = "DICT_" + dictionary.upper().removeprefix("ARUCO_")
    family = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))
    cells = family.markerSize + 2
    ink = cv2.aruco.generateImageMarker(family, number, cells)
    quiet = int(np.ceil(QUIET))
    sheet = np.pad(ink, quiet, constant_values=255)
    return np.kron(sheet / 255, np.ones((TEXELS, TEXELS))).astype(np.float32), cells


def _point_spread(defocus: float, aberration: float) -> Single:
    """The picture of a point on the fine raster."""
    reach = int(np.ceil((defocus + 4 * aberration) * FINE)) + 1
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1].astype(float)
    disc = np.clip(defocus * FINE - np.hypot(x, y) + 0.5, 0, 1)
    spread = cv2.GaussianBlur(disc, (0, 0), aberration * FINE, borderType=cv2.BORDER_CONSTANT)
    return (spread / spread.sum()).astype(np.float32)
