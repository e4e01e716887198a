"""A camera: a pinhole with the lens model plumb_bob and the covariance of its parameters. Its files: calibration/camera_file.py.

Pixels: integer coordinates are pixel centres, (0, 0) the centre of the upper left one, x right, y down (OpenCV's and
ROS's convention). Camera frame: x right, y down, z forward. `T_camera_board` is (rvec, tvec): p_camera = R p_board + t.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from calibration import lens
from xneck_foundation.errors import Refused


@dataclass(frozen=True)
class Camera:
    """A pinhole with the lens model plumb_bob and the covariance of its parameters."""

    width: int  # px
    height: int  # px
    K: np.ndarray  # shape (3, 3), px
    distortion: np.ndarray  # k1, k2, p1, p2, k3, shape (5,)
    covariance: np.ndarray | None = None  # of lens.PARAMETER_NAMES, shape (9, 9); rows of fixed parameters are zero
    name: str = "camera"
    info: dict[str, Any] = field(default_factory=dict)  # further entries under the key `xneck` of the file

    @property
    def parameters(self) -> np.ndarray:
        """[fx, fy, cx, cy, k1, k2, p1, p2, k3], the order of lens.PARAMETER_NAMES, shape (9,)."""
        return np.array([self.K[0, 0], self.K[1, 1], self.K[0, 2], self.K[1, 2], *self.distortion])

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, px."""
        return self.width, self.height

    def rays(self, pixels: np.ndarray) -> np.ndarray:
        """Pixels, shape (n, 2), to points on the plane z = 1 of the camera frame, shape (n, 2).

        NaN where the lens model has no inverse, far outside the calibrated picture.
        """
        return lens.pixels_to_rays(pixels, self.parameters)

    def undistort(self, pixels: np.ndarray) -> np.ndarray:
        """Pixels, shape (n, 2), to where the same camera without distortion would see them, (n, 2), px."""
        return self.rays(pixels) * self.parameters[:2] + self.parameters[2:4]

    def project(self, points: np.ndarray, rvec: np.ndarray, tvec: np.ndarray) -> np.ndarray:
        """Points of a body's frame (a board's, for example), shape (n, 3), m, to pixels, shape (n, 2).

        rvec (rotation vector, rad) and tvec (m): p_camera = R p + t. NaN for points not in front of the camera.
        """
        p = Rotation.from_rotvec(np.ravel(rvec)).apply(np.reshape(points, (-1, 3))) + np.ravel(tvec)
        depth = np.where(p[:, 2] > 0, p[:, 2], np.nan)
        return lens.rays_to_pixels(p[:, :2] / depth[:, None], self.parameters)


def camera_from(parameters: np.ndarray, size: tuple[int, int], **fields: Any) -> Camera:
    """A camera from its nine parameters (order of lens.PARAMETER_NAMES) and its picture size, px."""
    fx, fy, cx, cy = parameters[:4]
    K = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
    return Camera(width=size[0], height=size[1], K=K, distortion=np.array(parameters[4:9], float), **fields)


def refuse_implausible(camera: Camera, where: str | Path, places: tuple[str, str, str, str]) -> None:
    """Raises Refused for a value that no camera has; `places`: where fx, fy, cx and cy stand in the file `where`."""
    fx, fy, cx, cy = camera.parameters[:4]
    for place, focal in zip(places[:2], (fx, fy), strict=True):
        if not 0.05 * camera.width <= focal <= 100 * camera.width:
            raise Refused(where, f"{place}: a focal length of {focal:g} px, expected pixels, not mm")
    for place, value, extent in zip(places[2:], (cx, cy), camera.size, strict=True):
        if not -extent <= value <= 2 * extent:
            raise Refused(where, f"{place}: the optical axis at {value:g} px of {extent}")
    if not np.all(np.isfinite(camera.parameters)):
        raise Refused(where, "distortion: expected finite numbers")
