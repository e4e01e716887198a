"""A close view of one printed marker with the flaws of print, light, lens, motion and file, for tests and benchmarks.

Every pixel is cut into ZOOM x ZOOM points, each of which is carried back onto the marker and is ink or paper there; ink
spreads, the lens blurs and the exposure averages on that fine raster before it is added up to pixels.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

ZOOM = 8
QUIET = 1.0
"""cells of white around the black square"""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Flaws:
    """What is between a marker and its file."""

    psf: float = 0.8
    """standard deviation of the lens' blur, px"""
    noise: float = 4.0
    """grey levels"""
    black: float = 40.0
    white: float = 190.0
    ground: float = 90.0
    """grey levels of ink, paper and what is around the plate"""
    slope: tuple[float, float] = (0.0, 0.0)
    """change of the light over 100 px to the right and downwards, as a share of it in the middle"""
    gamma: bool = False
    """the file holds sRGB values"""
    bleed: float = 0.0
    """px by which ink has spread"""
    motion: tuple[float, float] = (0.0, 0.0)
    """px during the exposure"""
    jpeg: int | None = None
    """quality"""
    cable: float = 0.0
    """width of a dark line across, px"""
    hidden: float = 0.0
    """share of the square that a grey thing covers, from the left"""


def square(side: float, angle: float, middle: Array, tilt: tuple[float, float] = (0.0, 0.0)) -> Array:
    """Corners (4, 2), px, of a marker turned by `angle`, rad; tilt: perspective terms along its own axes."""
    unit = np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]])
    depth = 1 + unit @ np.asarray(tilt)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return (side / 2 * unit / depth[:, None]) @ turn + middle


def light(cells: NDArray[np.bool_], corners: Array, size: int, flaws: Flaws) -> Array:
    """Grey levels without noise, (size, size)."""
    fine = size * ZOOM
    steps = max(1, int(np.ceil(2 * np.hypot(*flaws.motion))))
    total = np.zeros((fine, fine))
    for step in (np.arange(steps) + 0.5) / steps - 0.5:
        total += _ink(cells, corners + step * np.array(flaws.motion), fine, flaws)
    blurred = cv2.GaussianBlur(total / steps, (0, 0), flaws.psf * ZOOM, borderType=cv2.BORDER_REPLICATE)
    picture = cv2.resize(blurred, (size, size), interpolation=cv2.INTER_AREA)
    v, u = np.mgrid[:size, :size] - (size - 1) / 2
    picture = picture * (1 + (flaws.slope[0] * u + flaws.slope[1] * v) / 100)
    if flaws.gamma:
        x = np.clip(picture / 255, 0, 1)
        picture = 255 * np.where(x < 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-9) ** (1 / 2.4) - 0.055)
    return picture


def picture(
    cells: NDArray[np.bool_], corners: Array, size: int, flaws: Flaws, rng: np.random.Generator
) -> NDArray[np.uint8]:
    """What the file holds, (size, size)."""
    return developed(light(cells, corners, size, flaws), flaws, rng)


def developed(levels: Array, flaws: Flaws, rng: np.random.Generator) -> NDArray[np.uint8]:
    """Noise, rounding and compression upon `light`."""
    noisy = levels + flaws.noise * rng.standard_normal(levels.shape)
    grey = np.clip(np.rint(noisy), 0, 255).astype(np.uint8)
    if flaws.jpeg is None:
        return grey
    coded = cv2.imencode(".jpg", grey, [cv2.IMWRITE_JPEG_QUALITY, flaws.jpeg])[1]
    return np.asarray(cv2.imdecode(coded, cv2.IMREAD_GRAYSCALE), dtype=np.uint8)


def _ink(cells: NDArray[np.bool_], corners: Array, fine: int, flaws: Flaws) -> Array:
    n = len(cells)
    place = _onto_cells(corners, n)
    at = (np.arange(fine) + 0.5) / ZOOM - 0.5
    x, y = np.meshgrid(at, at)
    w = place[2, 0] * x + place[2, 1] * y + place[2, 2]
    u = (place[0, 0] * x + place[0, 1] * y + place[0, 2]) / w
    v = (place[1, 0] * x + place[1, 1] * y + place[1, 2]) / w
    plate = (np.abs(u - n / 2) < n / 2 + QUIET) & (np.abs(v - n / 2) < n / 2 + QUIET)
    column, row = (np.clip(np.floor(z), -1, n).astype(int) + 1 for z in (u, v))
    black = (np.pad(cells, 1)[row, column] & plate).astype(np.uint8)
    reach = round(abs(flaws.bleed) * ZOOM)
    if reach:
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
        black = (cv2.dilate if flaws.bleed > 0 else cv2.erode)(black, disc)
    level = np.where(plate, np.where(black > 0, flaws.black, flaws.white), flaws.ground)
    if flaws.hidden:
        level = np.where(u < n * flaws.hidden, 120.0, level)
    if flaws.cable:
        across = np.linalg.norm(corners[1] - corners[0]) / n
        level = np.where(np.abs(0.8 * (u - n / 2) + 0.6 * (v - n / 2)) * across < flaws.cable / 2, 25.0, level)
    return level


def _onto_cells(corners: Array, n: int) -> Array:
    """The homography of corners (4, 2) onto the square 0 .. n, (3, 3)."""
    target = np.array([[0.0, 0], [n, 0], [n, n], [0, n]])
    rows, right = [], []
    for (x, y), (u, v) in zip(corners, target, strict=True):
        rows += [[x, y, 1, 0, 0, 0, -u * x, -u * y], [0, 0, 0, x, y, 1, -v * x, -v * y]]
        right += [u, v]
    return np.append(np.linalg.solve(np.array(rows), np.array(right)), 1.0).reshape(3, 3)
