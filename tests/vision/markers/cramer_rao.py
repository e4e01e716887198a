"""How well a marker can be measured at all: the Cramér-Rao bound, from the template's slopes and the noise of the pixels."""

import numpy as np
from numpy.typing import NDArray

from vision.markers.edge_pixels import select_pixels
from vision.markers.planar_motion import corner_slopes, homography
from vision.markers.template import Optics, sample_texture

Array = NDArray[np.float64]


def fisher_information(
    corners: Array, cells: NDArray[np.bool_], motion: Array, optics: Optics, contrast: float, noise: float
) -> Array:
    """Fisher information of the marker's eight motions (`planar_motion`), (8, 8), with light, blur and bleed known.

    corners and motion: (4, 2), px. contrast between black and white, and the noise's standard deviation: grey levels.
    """
    low = np.floor(corners.min(axis=0)) - 40
    near = corners - low
    width, height = (int(e) + 41 for e in near.max(axis=0))
    empty = np.full((height, width), 128, dtype=np.uint8)
    pixels = select_pixels(empty, [cells], near[None], homography(near[None]), motion[None], optics)
    u, v = (at[0] for at in pixels.marker_coordinates(np.linalg.inv(homography(near[None])).astype(float)))
    picture = sample_texture(pixels.textures[0], u, v)
    a, b = contrast * picture[1:3].astype(float) * pixels.used[0]
    J = np.stack([a, b, a * u, a * v, b * u, b * v, (a * u + b * v) * u, (a * u + b * v) * v])
    return J @ J.T / noise**2


def corner_bound(
    corners: Array, cells: NDArray[np.bool_], motion: Array, optics: Optics, contrast: float, noise: float
) -> Array:
    """Least covariance of the corners, (8, 8), px^2, nothing known of how they move together."""
    slopes = corner_slopes(homography(corners[None]))[0]
    return slopes @ np.linalg.inv(fisher_information(corners, cells, motion, optics, contrast, noise)) @ slopes.T


def angle_bound(
    corners: Array, cells: NDArray[np.bool_], motion: Array, optics: Optics, contrast: float, noise: float
) -> float:
    """Least standard deviation, rad, of the turn in the picture about the marker's middle, all else known."""
    H = homography(corners[None])
    arm = corners - corners.mean(axis=0)
    turned = np.column_stack([-arm[:, 1], arm[:, 0]]).ravel()
    xi = np.linalg.solve(corner_slopes(H)[0], turned)
    return float(1 / np.sqrt(xi @ fisher_information(corners, cells, motion, optics, contrast, noise) @ xi))
