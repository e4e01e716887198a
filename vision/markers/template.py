"""What a camera sees of a marker: its cells, the ink's bleed, the lens' blur and the pixels' area, without any raster's error.

In the marker's own coordinates the picture is a sum over cells of products of two edges, each an error function. It is
written down once for a size and a blur on a raster finer than the pixels, with its derivatives, and looked up from then on.

Marker coordinates: u to the right and v downwards in the upright marker, -1 .. 1 over the black square.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

Array = NDArray[np.float64]
Single = NDArray[np.float32]

PIXEL_VARIANCE = 1 / 12
"""px^2: what a square pixel's area adds to the blur along either axis"""
PER_PIXEL = 2.5
"""raster samples to a pixel, before rounding to a step of STEP"""
STEP = 1.25
MARGIN = 1
"""cells of white around the black square"""
STEEP = 0.2
"""share of an edge's full steepness, above which a pixel is taken: 99 % of what a straight edge tells"""
OUTSIDE = 0.7
"""cells of the white ring that are looked at; further out the ground may shine in"""
INSTANT = 2.0
"""px of motion to an instant of the exposure; the lens' blur fills the gaps"""
STILL = 0.3
"""px; a motion below this is no blur"""
BLEED_STEP = 0.05
"""px, of the difference that shows what bleed does"""
BLUR_STEP = 0.06
"""relative steps in which the blur is rounded, so that neighbouring frames share a raster"""


@dataclass(frozen=True)
class Optics:
    """Blur and ink as the whole recording shares them, with how well they are known."""

    sigma: float = 0.85
    """standard deviation of the lens' blur, px; the pixels' area comes on top"""
    bleed: float = 0.0
    """by how much black has grown over white, px"""
    sigma_sd: float = 0.3
    """px"""
    bleed_sd: float = 0.3
    """px"""


@dataclass(frozen=True)
class Texture:
    """A marker's picture on a raster: white is 1, black is 0."""

    channels: NDArray[np.float32]
    """(h, w, 5): value, its slopes by u and by v, by the blur's variance (per px^2), by the bleed (per px)"""
    cells: int
    """along a side, border included"""
    per_cell: int
    """raster samples"""
    variance: float
    """px^2: of the whole blur, pixels' area included"""
    near_edges: NDArray[np.uint8]
    """(h, w): bit 0 where a pixel tells about the marker's place, bit 1 where the marker and its white ring are"""
    shift: tuple[float, float] = (0.0, 0.0)
    """motion during the exposure, marker coordinates"""
    instants: int = 1
    """of the exposure, over which the mean is taken"""

    @property
    def to_raster(self) -> Array:
        """(3, 3): homogeneous marker coordinates to raster coordinates, sample centres at integers."""
        half = self.cells * self.per_cell / 2
        middle = half + MARGIN * self.per_cell - 0.5
        return np.array([[half, 0.0, middle], [0.0, half, middle], [0.0, 0.0, 1.0]])


def texture(cells: NDArray[np.bool_], blur_u: float, blur_v: float, bleed: float, sigma: float) -> Texture:
    """The raster of a marker.

    cells: (n, n), True is black. blur_u, blur_v: standard deviation of the whole blur along u and v, in cells.
    bleed and sigma (of the whole blur): px.
    """
    rounded = [BLUR_STEP * round(np.log(b) / BLUR_STEP) for b in (blur_u, blur_v)]
    wider = float(np.exp(np.mean(rounded))) / np.sqrt(blur_u * blur_v)
    made = _texture(cells.tobytes(), len(cells), *rounded, round(bleed / 0.01), round(sigma / 0.01))
    return replace(made, variance=(wider * sigma) ** 2)


@lru_cache(maxsize=256)
def _texture(bits: bytes, n: int, log_u: float, log_v: float, bleed_step: int, sigma_step: int) -> Texture:
    cells = np.frombuffer(bits, dtype=bool).reshape(n, n)
    sigma, bleed = 0.01 * sigma_step, 0.01 * bleed_step
    blur = np.exp([log_u, log_v])
    cell_px = sigma / blur  # of a cell's side along u and v
    wanted = PER_PIXEL * float(cell_px.max())
    per_cell = int(np.clip(round(STEP ** round(np.log(wanted) / np.log(STEP))), 6, 48))
    # linear interpolation between samples blurs by a sixth of their squared distance, on the average
    inner = np.sqrt(np.maximum(blur**2 - 1 / (6 * per_cell**2), 0.25 * blur**2))
    value, by_u, by_v, by_uu, by_vv = _mixed(
        cells, cell_px, inner, per_cell, bleed, ((0, 0), (1, 0), (0, 1), (2, 0), (0, 2))
    )
    more, less = (_mixed(cells, cell_px, inner, per_cell, bleed + d, ((0, 0),))[0] for d in (BLEED_STEP, -BLEED_STEP))
    heat = (by_uu / cell_px[0] ** 2 + by_vv / cell_px[1] ** 2) / 2
    ink = (more - less) / (2 * BLEED_STEP)
    channels = np.stack([value, by_u * n / 2, by_v * n / 2, heat, ink], axis=-1).astype(np.float32)
    slope = np.hypot(by_u / cell_px[0], by_v / cell_px[1])  # per px
    return Texture(
        channels, n, per_cell, sigma**2, _near_edges(slope * sigma * np.sqrt(2 * np.pi) > STEEP, n, per_cell)
    )


def moving(still: Texture, shift: Array, smear: float) -> Texture:
    """Seen over an exposure in which the marker moves uniformly by shift (2,), marker coordinates, or `smear` px."""
    if smear < STILL:
        return still
    return replace(still, shift=(float(shift[0]), float(shift[1])), instants=1 + int(np.ceil(smear / INSTANT)))


def way_of(motion: Array, instants: int) -> NDArray[np.uint8]:
    """A kernel that has 1 where something is that moves by (2,) px about its middle."""
    at = np.rint(_instants(instants)[0][:, None] * motion).astype(int)
    reach = int(np.abs(at).max())
    kernel = np.zeros((2 * reach + 1, 2 * reach + 1), dtype=np.uint8)
    kernel[reach + at[:, 1], reach + at[:, 0]] = 1
    kernel[reach, reach] = 1
    return kernel


@lru_cache(maxsize=64)
def _instants(n: int) -> tuple[Array, Array]:
    """Gauss's nodes and weights for a mean over -1/2 .. 1/2."""
    places, shares = np.polynomial.legendre.leggauss(n)
    return places / 2, shares / 2


def _near_edges(steep: NDArray[np.bool_], n: int, per_cell: int) -> NDArray[np.uint8]:
    at = (np.arange(len(steep)) + 0.5) / per_cell - MARGIN
    near = (at > -OUTSIDE) & (at < n + OUTSIDE)
    ring = near & near[:, None]
    return ring.astype(np.uint8) * 2 + (steep & ring)


def _mixed(
    cells: NDArray[np.bool_],
    cell_px: Array,
    blur: Array,
    per_cell: int,
    bleed: float,
    orders: tuple[tuple[int, int], ...],
) -> list[Array]:
    """Derivatives, per cell, of these orders by u and v."""
    white, strip = _with_bleed(cells, bleed), np.clip(np.abs(bleed) / cell_px, 1e-6, 0.3)
    u, v = ([_edges(len(cells), per_cell, strip[k], blur[k], order) for order in range(3)] for k in range(2))
    return [v[j] @ white @ u[i].T for i, j in orders]


def _with_bleed(cells: NDArray[np.bool_], bleed: float) -> Array:
    """White (1) and black (0) with a ring of white around; each cell in three parts, the outer ones as wide as the bleed."""
    black = np.kron(np.pad(cells, MARGIN), np.ones((3, 3))).astype(np.uint8)
    grow = cv2.dilate if bleed > 0 else cv2.erode
    grown = grow(black, np.ones((3, 3), np.uint8)) if bleed else black
    return 1.0 - np.asarray(grown, dtype=np.float64)


def _edges(n: int, per_cell: int, strip: float, blur: float, order: int) -> Array:
    """Each part's share in each raster sample, or its derivative by the place (cells) of that order: (samples, parts)."""
    whole = np.arange(n + 2 * MARGIN)
    bounds = np.column_stack([whole, whole + strip, whole + 1 - strip]).ravel()[1:] - MARGIN
    at = (np.arange(per_cell * len(whole)) + 0.5) / per_cell - MARGIN
    z = (at[:, None] - bounds) / blur
    bell = np.exp(-0.5 * z * z) / np.sqrt(2 * np.pi)
    step: Array = (np.asarray(ndtr(z), dtype=float), bell / blur, -z * bell / blur**2)[order]
    # the outermost parts reach to infinity: the ground is white as far as the picture is looked at
    first, last = np.full((len(at), 1), float(order == 0)), np.zeros((len(at), 1))
    steps: Array = np.hstack([first, step, last])
    return steps[:, :-1] - steps[:, 1:]


def look_up(texture: Texture, u: Single, v: Single) -> Single:
    """The channels at marker coordinates of shape (n,), the mean over the exposure: (5, n)."""
    scale, _, shift = texture.to_raster[0].tolist()
    x, y = u * np.float32(scale) + np.float32(shift), v * np.float32(scale) + np.float32(shift)
    if texture.instants == 1:
        at = x[None], y[None]
        return cv2.remap(texture.channels, *at, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)[0].T
    places, shares = _instants(texture.instants)
    away = (scale * places).astype(np.float32)[:, None]
    at = x - away * np.float32(texture.shift[0]), y - away * np.float32(texture.shift[1])
    seen = cv2.remap(texture.channels, *at, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return (shares.astype(np.float32) @ seen.reshape(len(shares), -1)).reshape(-1, 5).T
