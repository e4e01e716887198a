"""The picture that a camera takes of a marker: its cells, the ink's bleed, the lens' blur and the pixels' area.

In marker coordinates the picture is a sum over cells of products of two edges, each an error function. For each size and blur
it is computed once, with its derivatives, on a raster finer than the pixels, and interpolated from then on.

Marker coordinates: u to the right and v downwards in the upright marker, -1 .. 1 over the black square.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from vision.markers.tone_curve import LINEAR

Array = NDArray[np.float64]
Single = NDArray[np.float32]

PIXEL_VARIANCE = 1 / 12
"""px^2: what a square pixel's area adds to the blur along either axis"""
SAMPLES_PER_PX = 2.5
"""raster samples per pixel, before rounding to a power of RASTER_STEP"""
RASTER_STEP = 1.25
"""ratio of neighbouring raster sizes"""
MARGIN_CELLS = 1
"""cells of white around the black square"""
MIN_STEEPNESS = 0.2
"""share of an edge's full steepness above which a pixel is used: 99 % of the information of a straight edge (docs/thresholds.md)"""
RING_CELLS = 0.7
"""cells of the white ring that are used; further out the background may show"""
INSTANT_PX = 2.0
"""px of motion for each instant of the exposure over which the mean is taken; the lens' blur fills the gaps"""
MIN_MOTION_PX = 0.3
"""px: smaller motions during the exposure are neglected"""
BLEED_STEP_PX = 0.05
"""px: step of the finite difference by the bleed"""
BLUR_STEP = 0.06
"""relative step in which the blur is rounded, so that neighbouring frames share a raster"""


@dataclass(frozen=True)
class Optics:
    """Blur, ink bleed and tone curve of the whole recording, with standard deviations of the first two."""

    sigma: float = 0.85
    """standard deviation of the lens' blur, px; the pixels' area comes on top"""
    bleed: float = 0.0
    """by how much black has grown over white, px"""
    sigma_sd: float = 0.3
    """standard deviation of sigma, px"""
    bleed_sd: float = 0.3
    """standard deviation of bleed, px"""
    tone: float = LINEAR
    """exponent of the camera's tone curve"""


@dataclass(frozen=True)
class Texture:
    """A marker's picture on a raster: white is 1, black is 0."""

    channels: NDArray[np.float32]
    """(h, w, 5): value and its derivatives by u, by v, by the blur's variance (per px^2) and by the bleed (per px)"""
    cells: int
    """along a side, border included"""
    per_cell: int
    """raster samples along a cell's side"""
    variance: float
    """px^2: variance of the whole blur, the pixels' area included"""
    near_edges: NDArray[np.uint8]
    """(h, w): bit 0 where the picture is steep enough to tell the marker's place, bit 1 on the marker and its white ring"""
    shift: tuple[float, float] = (0.0, 0.0)
    """motion (u, v) during the exposure, marker coordinates"""
    instants: int = 1
    """instants of the exposure over which the mean is taken"""

    @property
    def to_raster(self) -> Array:
        """(3, 3): homogeneous marker coordinates to raster coordinates, sample centres at integers."""
        half = self.cells * self.per_cell / 2
        middle = half + MARGIN_CELLS * self.per_cell - 0.5
        return np.array([[half, 0.0, middle], [0.0, half, middle], [0.0, 0.0, 1.0]])


def marker_texture(cells: NDArray[np.bool_], blur_u: float, blur_v: float, bleed: float, sigma: float) -> Texture:
    """The texture of a marker at rest.

    cells: (n, n), True is black. blur_u, blur_v: standard deviation of the whole blur along u and v, cells. bleed: px. sigma:
    standard deviation of the whole blur, px.
    """
    rounded = [BLUR_STEP * round(float(np.log(b)) / BLUR_STEP) for b in (blur_u, blur_v)]
    wider = float(np.exp(np.mean(rounded))) / np.sqrt(blur_u * blur_v)
    made = _rounded_texture(cells.tobytes(), len(cells), *rounded, round(bleed / 0.01), round(sigma / 0.01))
    return replace(made, variance=(wider * sigma) ** 2)


@lru_cache(maxsize=256)
def _rounded_texture(bits: bytes, n: int, log_u: float, log_v: float, bleed_step: int, sigma_step: int) -> Texture:
    """The texture of cells given as bytes, of n cells a side, for a blur, a bleed and a sigma in steps of their rounding."""
    cells = np.frombuffer(bits, dtype=bool).reshape(n, n)
    sigma, bleed = 0.01 * sigma_step, 0.01 * bleed_step
    blur = np.exp([log_u, log_v])
    cell_px = sigma / blur  # side of a cell along u and v
    wanted = SAMPLES_PER_PX * float(cell_px.max())
    per_cell = int(np.clip(round(RASTER_STEP ** round(np.log(wanted) / np.log(RASTER_STEP))), 6, 48))
    # linear interpolation between samples blurs by a sixth of their squared distance, on the average
    inner = np.sqrt(np.maximum(blur**2 - 1 / (6 * per_cell**2), 0.25 * blur**2))
    value, by_u, by_v, by_uu, by_vv = _mixed(
        cells, cell_px, inner, per_cell, bleed, ((0, 0), (1, 0), (0, 1), (2, 0), (0, 2))
    )
    above, below = (
        _mixed(cells, cell_px, inner, per_cell, bleed + d, ((0, 0),))[0] for d in (BLEED_STEP_PX, -BLEED_STEP_PX)
    )
    by_variance = (by_uu / cell_px[0] ** 2 + by_vv / cell_px[1] ** 2) / 2
    by_bleed = (above - below) / (2 * BLEED_STEP_PX)
    channels = np.stack([value, by_u * n / 2, by_v * n / 2, by_variance, by_bleed], axis=-1).astype(np.float32)
    slope = np.hypot(by_u / cell_px[0], by_v / cell_px[1])  # per px
    near_edges = _near_edges(slope * sigma * np.sqrt(2 * np.pi) > MIN_STEEPNESS, n, per_cell)
    return Texture(channels=channels, cells=n, per_cell=per_cell, variance=sigma**2, near_edges=near_edges)


def with_motion(still: Texture, shift: Array, smear: float) -> Texture:
    """The texture over an exposure in which the marker moves uniformly by shift (2,), marker coordinates, or `smear` px."""
    if smear < MIN_MOTION_PX:
        return still
    return replace(still, shift=(float(shift[0]), float(shift[1])), instants=1 + int(np.ceil(smear / INSTANT_PX)))


def motion_kernel(motion: Array, instants: int) -> NDArray[np.uint8]:
    """Kernel with 1 at every pixel that a point meets while it moves by `motion` (2,), px, about the kernel's middle."""
    at = np.rint(_instants(instants)[0][:, None] * motion).astype(int)
    reach = int(np.abs(at).max())
    kernel = np.zeros((2 * reach + 1, 2 * reach + 1), dtype=np.uint8)
    kernel[reach + at[:, 1], reach + at[:, 0]] = 1
    kernel[reach, reach] = 1
    return kernel


@lru_cache(maxsize=64)
def _instants(n: int) -> tuple[Array, Array]:
    """Nodes and weights of Gauss-Legendre quadrature for a mean over -1/2 .. 1/2."""
    nodes, weights = np.polynomial.legendre.leggauss(n)
    return nodes / 2, weights / 2


def _near_edges(steep: NDArray[np.bool_], n: int, per_cell: int) -> NDArray[np.uint8]:
    """`Texture.near_edges` from where the picture is steep, (h, w)."""
    at = (np.arange(len(steep)) + 0.5) / per_cell - MARGIN_CELLS
    near = (at > -RING_CELLS) & (at < n + RING_CELLS)
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
    """Derivatives of the picture of these orders by u and v, in cells, each (h, w); blur: (2,), cells."""
    white, strip = _with_bleed(cells, bleed), np.clip(np.abs(bleed) / cell_px, 1e-6, 0.3)
    u, v = ([_edges(len(cells), per_cell, strip[k], blur[k], order) for order in range(3)] for k in range(2))
    return [v[j] @ white @ u[i].T for i, j in orders]


def _with_bleed(cells: NDArray[np.bool_], bleed: float) -> Array:
    """White (1) and black (0) with a ring of white around, (3 n + 6, 3 n + 6): each cell in three parts a side, the outer ones
    as wide as the bleed."""
    black = np.kron(np.pad(cells, MARGIN_CELLS), np.ones((3, 3))).astype(np.uint8)
    grow = cv2.dilate if bleed > 0 else cv2.erode
    grown = grow(black, np.ones((3, 3), np.uint8)) if bleed else black
    return 1.0 - np.asarray(grown, dtype=np.float64)


def _edges(n: int, per_cell: int, strip: float, blur: float, order: int) -> Array:
    """Share of each part of the cells in each raster sample, or its derivative of that order by the place in cells:
    (samples, parts)."""
    whole = np.arange(n + 2 * MARGIN_CELLS)
    bounds = np.column_stack([whole, whole + strip, whole + 1 - strip]).ravel()[1:] - MARGIN_CELLS
    at = (np.arange(per_cell * len(whole)) + 0.5) / per_cell - MARGIN_CELLS
    z = (at[:, None] - bounds) / blur
    bell = np.exp(-0.5 * z * z) / np.sqrt(2 * np.pi)
    step: Array = (np.asarray(ndtr(z), dtype=float), bell / blur, -z * bell / blur**2)[order]
    # the outermost parts reach to infinity: the ground is white as far as the picture is used
    first, last = np.full((len(at), 1), float(order == 0)), np.zeros((len(at), 1))
    steps: Array = np.hstack([first, step, last])
    return steps[:, :-1] - steps[:, 1:]


def sample_texture(texture: Texture, u: Single, v: Single) -> Single:
    """The channels at marker coordinates (n,), averaged over the exposure: (5, n)."""
    scale, _, shift = texture.to_raster[0].tolist()
    x, y = u * np.float32(scale) + np.float32(shift), v * np.float32(scale) + np.float32(shift)
    if texture.instants == 1:
        at = x[None], y[None]
        return cv2.remap(texture.channels, *at, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)[0].T
    nodes, weights = _instants(texture.instants)
    offset = (scale * nodes).astype(np.float32)[:, None]
    at = x - offset * np.float32(texture.shift[0]), y - offset * np.float32(texture.shift[1])
    values = cv2.remap(texture.channels, *at, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return (weights.astype(np.float32) @ values.reshape(len(weights), -1)).reshape(-1, 5).T
