"""Known cameras looking at known boards: the projection, the pictures and the drawings are the tests' own."""

import re
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import cv2
import numpy as np

from calibration.corner_detection import BoardView
from calibration.pictures import Picture
from tests.paths import SHARED

DATA = SHARED / "calibration"
CAMERA = np.array([620.0, 622.0, 325.0, 236.0, -0.21, 0.07, 0.0008, -0.0006, 0.0])  # of a picture of 640 x 480
SIZE = (640, 480)


def project(points: np.ndarray, R: np.ndarray, t: np.ndarray, p: np.ndarray = CAMERA) -> np.ndarray:
    """Points (n, 3) of the board to pixels (n, 2), written out from ROS's definition of plumb_bob."""
    out = []
    for X, Y, Z in np.asarray(points) @ R.T + t:
        a, b = X / Z, Y / Z
        s = a**2 + b**2
        radial = 1 + p[4] * s + p[5] * s**2 + p[8] * s**3
        out.append(
            (
                p[0] * (a * radial + 2 * p[6] * a * b + p[7] * (s + 2 * a**2)) + p[2],
                p[1] * (b * radial + p[6] * (s + 2 * b**2) + 2 * p[7] * a * b) + p[3],
            )
        )
    return np.array(out)


def poses(
    rng: np.random.Generator,
    count: int,
    size_m: tuple[float, float],
    tilt_deg: float = 35.0,
    parameters: np.ndarray = CAMERA,
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Boards all over the picture: tilted by `tilt_deg` about axes all around, at distances that show them whole."""
    found: list[tuple[np.ndarray, np.ndarray]] = []
    w, h = size_m
    outline = np.array([[0, 0, 0], [w, 0, 0], [w, h, 0], [0, h, 0]])
    while len(found) < count:
        axis = rng.uniform(0, 2 * np.pi)
        turn = np.radians(tilt_deg) * np.array([np.cos(axis), np.sin(axis), 0.0])
        R = cv2.Rodrigues(turn)[0] @ cv2.Rodrigues(np.array([0.0, 0.0, rng.uniform(-0.4, 0.4)]))[0]
        z = rng.uniform(1.3, 2.4) * max(w, h) * parameters[0] / CAMERA[0]
        wide = z * CAMERA[0] / parameters[0]
        middle = np.array([rng.uniform(-0.3, 0.3) * wide, rng.uniform(-0.22, 0.22) * wide, z])
        t = middle - R @ np.array([w / 2, h / 2, 0.0])
        pixels = project(outline, R, t, parameters)
        if np.all((pixels > 6) & (pixels < np.array(SIZE) - 7)):
            found.append((R, t))
    return found


def synthetic_views(
    rng: np.random.Generator,
    corners: np.ndarray,
    count: int = 15,
    noise_px: float = 0.1,
    tilt_deg: float = 35.0,
    bow_m: float = 0.0,
    parameters: np.ndarray = CAMERA,
    common_px: float = 0.0,
    shape: np.ndarray | None = None,
) -> list[BoardView]:
    """Views without pictures: projected corners and noise; each board bowed by its own amount of about `bow_m`.

    `common_px` more noise is alike for neighbours on the board (a Gaussian process of two squares' reach, anew for each
    view and direction), as light and blur make it. `shape`, (n, 3), m, is where the corners really are in all views.
    """
    low, high = corners.min(axis=0), corners.max(axis=0)
    margin = corners[1, 0] - corners[0, 0]
    apart = np.linalg.norm(corners[:, None] - corners[None], axis=2) / (2 * margin)
    alike = np.linalg.cholesky(np.exp(-0.5 * apart**2) + 1e-9 * np.eye(len(corners)))
    views = []
    everywhere = poses(rng, count, (float(high[0] + margin), float(high[1] + margin)), tilt_deg, parameters)
    for index, (R, t) in enumerate(everywhere):
        unit = 2 * (corners - low)[:, :2] / (high - low)[:2] - 1
        bent = (corners if shape is None else shape).copy()
        if bow_m:
            bent[:, 2] += bow_m * (rng.normal() * unit[:, 0] ** 2 + rng.normal() * unit[:, 1] ** 2)
        pixels = project(bent, R, t, parameters) + noise_px * rng.normal(size=(len(corners), 2))
        if common_px:
            pixels += common_px * alike @ rng.normal(size=(len(corners), 2))
        views.append(BoardView(f"view {index:02d}", pixels, corners.copy(), np.arange(len(corners))))
    return views


def bowed(corners: np.ndarray, x_m: float, y_m: float = 0.0) -> np.ndarray:
    """A sheet whose rim lies `x_m` behind the middle along x and `y_m` along y: parabolas, middle at nought."""
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
    half = np.ptp(corners, axis=0)[:2] / 2
    bent = corners.copy()
    bent[:, 2] = x_m * ((corners - middle)[:, 0] / half[0]) ** 2 + y_m * ((corners - middle)[:, 1] / half[1]) ** 2
    return bent


def svg_blacks(path: Path) -> tuple[tuple[float, float], list[list[np.ndarray]]]:
    """Size of the sheet, mm, and every black filled path of an SVG as closed loops (n, 2), mm from the upper left."""
    root = ElementTree.parse(path).getroot()
    size = [root.attrib[key] for key in ("width", "height")]
    box = [float(v) for v in root.attrib["viewBox"].split()]
    assert all(s.endswith("pt") for s in size)
    mm = [float(s.removesuffix("pt")) * 25.4 / 72 for s in size]  # CSS: 72 pt = 25.4 mm
    scale = np.array([mm[0] / box[2], mm[1] / box[3]])
    shapes = []
    for element in root.iter("{http://www.w3.org/2000/svg}path"):
        # SVG fills black unless told otherwise; lettering stands in <defs> or under text groups with curves
        style, data = element.attrib.get("style", ""), element.attrib.get("d", "")
        if "fill" in style or "stroke" in style or re.search("[QCqc]", data) or "transform" in element.attrib:
            continue
        loops = [
            np.array([[float(v) for v in pair] for pair in re.findall(r"([-\d.]+) ([-\d.]+)", part)])
            for part in data.split("z")
        ]
        shapes.append([loop * scale for loop in loops if len(loop)])
    return (mm[0], mm[1]), shapes


def raster(size_mm: tuple[float, float], shapes: list[list[np.ndarray]], per_mm: int = 8) -> np.ndarray:
    """Rectilinear shapes as a picture, white 255 and black 0: every upright edge toggles all that is right of it."""
    black = np.zeros((round(size_mm[1] * per_mm), round(size_mm[0] * per_mm)), bool)
    for loops in shapes:
        for loop in loops:
            for (x0, y0), (x1, y1) in zip(loop, np.roll(loop, -1, axis=0), strict=True):
                assert abs(x0 - x1) < 1e-4 or abs(y0 - y1) < 1e-4
                if abs(x0 - x1) < 1e-4:
                    low, high = sorted((round(y0 * per_mm), round(y1 * per_mm)))
                    black[low:high, round(x0 * per_mm) :] ^= True
    return np.where(black, 0, 255).astype(np.uint8)


def picture(
    texture: np.ndarray,
    per_mm: float,
    origin_mm: tuple[float, float],
    R: np.ndarray,
    t: np.ndarray,
    rng: np.random.Generator,
    name: str = "rendered",
    bow: tuple[float, float, float, float] | None = None,
) -> Picture:
    """What CAMERA sees of a sheet: 3 x 3 rays a pixel, a point spread of 0.7 px, noise of 2 grey levels.

    `origin_mm` is where the board frame's origin lies on the sheet, from its upper left. With a `bow` of (sagitta, x of
    the middle, y of the middle, half the extent along x), m, the sheet is the parabola `bowed` along x.
    """
    rays, shape = _rays()
    # the ray d = (a, b, 1) meets the board where (R' (z d - t))_3 = 0
    d = np.column_stack([rays, np.ones(len(rays))]) @ R
    at = t @ R
    depth = at[2] / d[:, 2]
    if bow is not None:
        for _ in range(6):  # the depth at which the ray meets the parabola: a contraction by the bow's slope
            depth = (at[2] + bow[0] * (((depth * d[:, 0] - at[0]) - bow[1]) / bow[3]) ** 2) / d[:, 2]
    on_board = depth[:, None] * d - at
    x = (1e3 * on_board[:, 0] + origin_mm[0]) * per_mm - 0.5
    y = (1e3 * on_board[:, 1] + origin_mm[1]) * per_mm - 0.5
    seen = cv2.remap(
        texture,
        x.reshape(shape).astype(np.float32),
        y.reshape(shape).astype(np.float32),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=200.0,  # type: ignore[arg-type]
    )
    seen = cv2.resize(seen.astype(np.float32), SIZE, interpolation=cv2.INTER_AREA)
    seen = cv2.GaussianBlur(30 + 0.75 * seen, (0, 0), 0.7) + rng.normal(scale=2.0, size=seen.shape)
    return Picture(name, np.clip(np.round(seen), 0, 255).astype(np.uint8))


@cache
def _rays() -> tuple[np.ndarray, tuple[int, int]]:
    """The rays (x, y) of CAMERA through 3 x 3 points a pixel, row by row, and the shape of that finer picture."""
    fine = 3
    u, v = np.meshgrid(np.arange(SIZE[0] * fine), np.arange(SIZE[1] * fine))
    wanted = np.column_stack([((u.ravel() + 0.5) / fine - 0.5), ((v.ravel() + 0.5) / fine - 0.5)])
    ideal = (wanted - CAMERA[2:4]) / CAMERA[:2]
    rays = ideal
    k1, k2, p1, p2 = CAMERA[4:8]
    for _ in range(25):
        a, b = rays.T
        s = a * a + b * b
        tangential = np.column_stack([2 * p1 * a * b + p2 * (s + 2 * a * a), p1 * (s + 2 * b * b) + 2 * p2 * a * b])
        rays = (ideal - tangential) / (1 + k1 * s + k2 * s * s)[:, None]
    return rays, (SIZE[1] * fine, SIZE[0] * fine)
