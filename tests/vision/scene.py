"""Where the sample's camera sees the markers, by the generator's own linkage and camera model."""

from collections.abc import Callable

import cv2
import numpy as np

from mechanism.description import Neck
from mechanism.printed_markers import BarMarker
from samples.generator.camera import SAMPLE_CAMERA
from samples.generator.linkage import Bars, solve

NOISE_PX = 0.05


def carrier(marker: BarMarker, bars: Bars, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Middle and direction (complex, of length one) of a marker's bar, (F,) each; a diagonal joins two bar ends."""
    if marker.bar is not None:
        return bars.middle[:, marker.bar], np.exp(1j * bars.orientation[:, marker.bar])
    assert marker.diagonal is not None
    i = int(marker.diagonal[1:])
    half = b[i - 1] / 2 * np.exp(1j * bars.orientation)
    side = 1 if marker.diagonal[0] == "A" else -1
    lower, upper = bars.middle[:, i - 1] - side * half[:, i - 1], bars.middle[:, i] + side * half[:, i]
    return (lower + upper) / 2, (upper - lower) / np.abs(upper - lower)


def corners(
    neck: Neck,
    alpha: np.ndarray,
    seed: int | None = None,
    noise: float = NOISE_PX,
    depth: np.ndarray | None = None,
    tilt: np.ndarray | None = None,
) -> np.ndarray:
    """Where the sample's camera sees the markers' corners, (F, markers, 4, 2), px, with `noise` px where seeded.

    depth: of each marker, m before the plane of motion; tilt: out of it, a rotation vector along the marker's own
    x and y, rad.
    """
    assert neck.markers is not None
    m = neck.mechanisms
    bars = solve(alpha, np.array([x.L for x in m]), np.array([x.b for x in m]))
    h = neck.markers.size / 2
    square = h * np.array([[-1.0, 1, 1, -1], [1, 1, -1, -1], [0, 0, 0, 0]])
    out = np.empty((len(alpha), len(neck.markers.on_bars), 4, 2))
    for k, marker in enumerate(neck.markers.on_bars):
        turned, _ = cv2.Rodrigues(np.append((0.0, 0.0) if tilt is None else tilt[k], 0.0))
        x, y, z = turned @ square
        local = complex(*marker.at) + np.exp(1j * marker.angle) * (x + 1j * y)
        height = z + (0.0 if depth is None else depth[k])
        middle, turn = carrier(marker, bars, np.array([x.b for x in m]))
        plane = middle[:, None] + turn[:, None] * local
        points = np.stack([plane.real, plane.imag, np.broadcast_to(height, plane.shape)], axis=-1)
        out[:, k] = SAMPLE_CAMERA.project(points.reshape(-1, 3)).reshape(len(alpha), 4, 2)
    if seed is not None:
        out += np.random.default_rng(seed).normal(0, noise, out.shape)
    return out


def rolled(
    neck: Neck,
    time: np.ndarray,
    alpha_at: Callable[[np.ndarray], np.ndarray],
    row_s: float,
    depth: np.ndarray | None = None,
) -> np.ndarray:
    """Each corner where it was when its own row was exposed: t = stamp + (row(t) - middle row) row_s, by iteration."""
    seen = corners(neck, alpha_at(time), depth=depth)
    for _ in range(6):
        late = (seen[..., 1] - (SAMPLE_CAMERA.height - 1) / 2) * row_s
        for k in range(seen.shape[1]):
            for c in range(4):
                seen[:, k, c] = corners(neck, alpha_at(time + late[:, k, c]), depth=depth)[:, k, c]
    return seen
