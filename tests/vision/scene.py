"""Where the sample's camera sees the markers, by the generator's own linkage and camera model."""

import numpy as np

from mechanism.description import Neck
from samples.generator.camera import SAMPLE_CAMERA
from samples.generator.linkage import solve

NOISE_PX = 0.05


def corners(neck: Neck, alpha: np.ndarray, seed: int | None = None) -> np.ndarray:
    """Where the sample's camera sees the markers' corners, (F, markers, 4, 2), px, with noise of NOISE_PX."""
    assert neck.markers is not None
    m = neck.mechanisms
    bars = solve(alpha, np.array([x.L for x in m]), np.array([x.b for x in m]))
    h = neck.markers.size / 2
    square = np.array([complex(-h, h), complex(h, h), complex(h, -h), complex(-h, -h)])
    out = np.empty((len(alpha), len(neck.markers.on_bars), 4, 2))
    for k, marker in enumerate(neck.markers.on_bars):
        local = complex(*marker.at) + np.exp(1j * marker.angle) * square
        plane = bars.middle[:, marker.bar, None] + np.exp(1j * bars.orientation[:, marker.bar, None]) * local
        points = np.stack([plane.real, plane.imag, np.zeros(plane.shape)], axis=-1)
        out[:, k] = SAMPLE_CAMERA.project(points.reshape(-1, 3)).reshape(len(alpha), 4, 2)
    if seed is not None:
        out += np.random.default_rng(seed).normal(0, NOISE_PX, out.shape)
    return out
