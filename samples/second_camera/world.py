"""An arm and a camera drawn at random, and what makes its pictures hard.

from samples.second_camera.world import drawn
world = drawn(neck, seed=3)
"""

from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Lens:
    """A camera that stands still; pixels as OpenCV counts them."""

    size: tuple[int, int]
    """width and height, px"""
    K: Array
    """(3, 3), px"""
    distortion: Array
    """(5,), in OpenCV's order"""
    rvec: Array
    """(3,), rad, of T_camera_base"""
    tvec: Array
    """(3,), m"""


@dataclass(frozen=True)
class Optics:
    """From light to grey levels."""

    defocus: float = 1.1
    """px: radius of the disc into which a point is spread"""
    aberration: float = 0.45
    """px: standard deviation of what else spreads it"""
    exposure_s: float = 0.004
    instants: int = 3
    """of an exposure"""
    row_s: float = 0.0
    """from a row to the row below"""
    full_well: float = 9000.0
    """electrons of white"""
    read_electrons: float = 12.0
    gain: tuple[float, float] = (1.0, 0.0)
    """its middle, and by how much of itself it swings"""
    paper: float = 0.8
    ink: float = 0.04
    """reflectances"""
    light_slope: float = 0.2
    """change of the light across the picture, of itself"""
    glare: float = 0.0
    """of a lamp that wanders over the markers, of white"""
    shadow: float = 0.0
    """share of the light that the soft edge of a moving shadow takes"""
    cable: float = 0.0
    """m: width of a dark cable before the markers, which sways"""
    tone_curve: bool = True
    """whether the camera writes sRGB levels"""
    sharpening: float = 0.3
    """of the camera's own sharpener"""
    coloured: bool = True
    """whether its pixels see one colour each"""


@dataclass(frozen=True)
class World:
    """One arm before one camera."""

    neck: dict[str, Any]
    """contents of neck.yaml; markers have their true `depth` and `tilt`"""
    lens: Lens
    optics: Optics
    swings: Array
    """(3, N, waves): amplitude (rad), angular frequency (rad/s), phase"""
    times: Array
    """(F,), s: middles of the exposure of the middle row"""
    seed: int
    knocks: tuple[tuple[float, Array], ...] = field(default_factory=tuple)
    """times (s), and changes (6,) of rvec and tvec from then on"""

    def alpha_at(self, t: float) -> Array:
        """Joint angles (N,), rad."""
        amplitude, frequency, phase = self.swings
        return np.sum(amplitude * np.sin(frequency * t + phase), axis=1)

    @property
    def truth(self) -> Array:
        """(F, N), rad."""
        return np.array([self.alpha_at(t) for t in self.times])

    @property
    def depth(self) -> Array:
        """(markers,), m."""
        return np.array([m["depth"] for m in self.neck["markers"]["on_bars"]])

    def pose_at(self, t: float) -> tuple[Array, Array]:
        """rvec and tvec of T_camera_base."""
        change = sum((change for moment, change in self.knocks if t >= moment), np.zeros(6))
        return self.lens.rvec + change[:3], self.lens.tvec + change[3:]


def drawn(
    neck: dict[str, Any],
    seed: int,
    *,
    seconds: float = 20.0,
    rate: float = 30.0,
    marker_px: float = 42.5,
    planes: float = 0.008,
    tilt_deg: float = 1.0,
    speed: float = 1.0,
    roll_deg: float = 3.0,
    focal_of_width: float = 1.0,
    size: tuple[int, int] = (928, 528),
    optics: Optics = Optics(),
) -> World:
    """Mounting, motion and the camera's place anew for each seed.

    focal_of_width: focal length over the picture's width; speed: factor on the frequencies of the motion.
    """
    rng = np.random.default_rng([77, seed])
    on_bars = [
        m | {"depth": float(rng.uniform(-planes, planes)), "tilt": np.radians(rng.normal(0, tilt_deg, 2)).tolist()}
        for m in neck["markers"]["on_bars"]
    ]
    joints = len(neck["mechanisms"])
    height = sum(float(np.sqrt(m["L"] ** 2 - m["b"] ** 2)) for m in neck["mechanisms"])
    f = focal_of_width * size[0]
    K = np.array(
        [[f, 0, size[0] / 2 + rng.uniform(-12, 12)], [0, f * 1.001, size[1] / 2 + rng.uniform(-12, 12)], [0, 0, 1]]
    )
    distortion = np.array([rng.uniform(-0.2, 0.05), rng.uniform(0, 0.1), *rng.uniform(-5e-4, 5e-4, 2), 0.0])
    pitch, yaw, roll = np.radians(rng.uniform((-8, -15, -roll_deg), (8, 15, roll_deg)))
    facing = np.diag([1.0, -1.0, -1.0])
    R = _about(2, roll) @ _about(0, pitch) @ _about(1, yaw) @ facing
    away = f * float(neck["markers"]["size"]) / marker_px
    aim = np.array([0.0, height / 2, 0.0])
    times = np.arange(round(seconds * rate), dtype=float) / rate
    swings = np.stack(
        [
            np.radians(rng.uniform(4, 12, (joints, 3))),
            2 * np.pi * speed * rng.uniform(0.1, 0.9, (joints, 3)),
            rng.uniform(0, 2 * np.pi, (joints, 3)),
        ]
    )
    return World(
        neck=neck | {"markers": neck["markers"] | {"on_bars": on_bars}},
        lens=Lens(
            size, K, distortion, np.asarray(cv2.Rodrigues(R)[0], dtype=float).ravel(), np.array([0, 0, away]) - R @ aim
        ),
        optics=optics,
        swings=swings,
        times=times,
        seed=seed,
    )


def _about(axis: int, angle: float) -> Array:
    vector = np.zeros(3)
    vector[axis] = angle
    return np.asarray(cv2.Rodrigues(vector)[0], dtype=float)
