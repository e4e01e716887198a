"""An arm whose markers sit as a workshop mounts them, its bars beside each other: each in a plane of its own, none quite upright.

from samples.generator.mounted import mounted_arm
arm = mounted_arm(neck, seed=3); arm.render("arm.mp4")
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from samples.generator.camera import SAMPLE_CAMERA, Camera, facing, rotation_vector
from samples.generator.video import Look, render_video

Array = NDArray[np.float64]

FRAME_HZ = 30.0
PLANES = 0.008
"""m: how far before or behind the arm's plane a marker is at most"""
TILT = np.radians(1.0)
"""rad: standard deviation of a marker's tilt about either of its axes"""
MARKER_PX = 43.0
"""px: side of a marker in the picture"""
_DISTANCE = 0.65
"""m, from the camera to the arm"""


@dataclass(frozen=True)
class MountedArm:
    """One arm before a camera, and how it moves."""

    neck: dict[str, Any]
    """the contents of neck.yaml, with the true `depth` of each marker, and its `tilt`"""
    camera: Camera
    swings: Array
    """(3, N, waves): amplitude (rad), angular frequency (rad/s) and phase of what each joint's motion is the sum of"""
    seconds: float
    seed: int

    @property
    def times(self) -> Array:
        """Middles of the exposures, s."""
        return np.arange(round(self.seconds * FRAME_HZ)) / FRAME_HZ

    def alpha_at(self, t: float) -> Array:
        """Joint angles (N,), rad."""
        amplitude, frequency, phase = self.swings
        return np.sum(amplitude * np.sin(frequency * t + phase), axis=1)

    @property
    def truth(self) -> Array:
        """Joint angles of all frames, (F, N), rad."""
        return np.array([self.alpha_at(t) for t in self.times])

    def depth(self) -> Array:
        """Of each marker, (markers,), m."""
        return np.array([m["depth"] for m in self.neck["markers"]["on_bars"]])

    def render(self, path: str | Path, crf: float = 22.5, processes: int = 1) -> None:
        """Write the video; crf: x264's constant quality."""
        look = Look(instants=3, crf=crf)
        render_video(path, self.times, self.alpha_at, self.neck, self.camera, self.seed, look, processes)


def mounted_arm(
    neck: dict[str, Any], seed: int, seconds: float = 20.0, planes: float = PLANES, tilt: float = TILT
) -> MountedArm:
    """An arm with the same mechanisms and markers; mounting, motion and the camera's place are drawn anew for each seed."""
    rng = np.random.default_rng([2100, seed])
    on_bars = [
        m | {"depth": float(rng.uniform(-planes, planes)), "tilt": tuple(rng.normal(0, tilt, 2).tolist())}
        for m in neck["markers"]["on_bars"]
    ]
    yaw, pitch, roll = np.radians(rng.uniform((-15, -8, -3), (15, 8, 3))).tolist()
    T = facing(aim=(0.0, 0.125), distance=_DISTANCE, yaw=yaw, pitch=pitch, roll=roll)
    x, y, z = T[:3, 3].tolist()
    factor = MARKER_PX * _DISTANCE / (SAMPLE_CAMERA.fx * float(neck["markers"]["size"]))
    camera = replace(SAMPLE_CAMERA.scaled(factor), rotation=rotation_vector(T[:3, :3]), translation=(x, y, z))
    # even sizes: the colours of the video are of half the resolution
    camera = replace(camera, width=camera.width // 2 * 2, height=camera.height // 2 * 2)
    shape = (len(neck["mechanisms"]), 3)
    swings = np.stack(
        [
            np.radians(rng.uniform(4, 12, shape)),
            2 * np.pi * rng.uniform(0.1, 0.9, shape),
            rng.uniform(0, 2 * np.pi, shape),
        ]
    )
    return MountedArm(neck | {"markers": neck["markers"] | {"on_bars": on_bars}}, camera, swings, seconds, seed)
