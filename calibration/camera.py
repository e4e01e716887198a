"""A camera, and camera.yaml: ROS camera_info with our additions under the key `xneck`.

Pixels: integer coordinates are pixel centres, (0, 0) the centre of the upper left one, x right, y down (OpenCV's and
ROS's convention). Camera frame: x right, y down, z forward. `T_camera_board` is (rvec, tvec): p_camera = R p_board + t.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field
from scipy.spatial.transform import Rotation

from calibration import lens
from xneck.errors import Refused
from xneck.strict_yaml import Strict, load, validate
from xneck.whole_file import write_text
from xneck.yaml_text import flow


@dataclass(frozen=True)
class Camera:
    """A pinhole with the lens model plumb_bob, and how well it is known."""

    width: int  # px
    height: int  # px
    K: np.ndarray  # shape (3, 3), px
    distortion: np.ndarray  # k1, k2, p1, p2, k3, shape (5,)
    covariance: np.ndarray | None = None  # of lens.NAMES, shape (9, 9); rows of fixed parameters are zero
    name: str = "camera"
    info: dict[str, Any] = field(default_factory=dict)  # what else stands under `xneck` in the file

    @property
    def parameters(self) -> np.ndarray:
        """[fx, fy, cx, cy, k1, k2, p1, p2, k3], the order of lens.NAMES, shape (9,)."""
        return np.array([self.K[0, 0], self.K[1, 1], self.K[0, 2], self.K[1, 2], *self.distortion])

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, px."""
        return self.width, self.height

    def rays(self, pixels: np.ndarray) -> np.ndarray:
        """Pixels, shape (n, 2), to points on the plane z = 1 of the camera frame, shape (n, 2).

        NaN where the lens model has no inverse, far outside the calibrated picture.
        """
        return lens.undistort(pixels, self.parameters)

    def undistort(self, pixels: np.ndarray) -> np.ndarray:
        """Pixels, shape (n, 2), to where the same camera without distortion would see them, (n, 2), px."""
        return self.rays(pixels) * self.parameters[:2] + self.parameters[2:4]

    def project(self, points: np.ndarray, rvec: np.ndarray, tvec: np.ndarray) -> np.ndarray:
        """Points of a board's (any body's) frame, shape (n, 3), m, to pixels, shape (n, 2).

        rvec (rotation vector, rad) and tvec (m): p_camera = R p + t. NaN for points not in front of the camera.
        """
        seen = Rotation.from_rotvec(np.ravel(rvec)).apply(np.reshape(points, (-1, 3))) + np.ravel(tvec)
        depth = np.where(seen[:, 2] > 0, seen[:, 2], np.nan)
        return lens.distort(seen[:, :2] / depth[:, None], self.parameters)


def camera_from(parameters: np.ndarray, size: tuple[int, int], **more: Any) -> Camera:
    """A camera from its nine parameters (order of lens.NAMES) and its picture size, px."""
    fx, fy, cx, cy = parameters[:4]
    K = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
    return Camera(size[0], size[1], K, np.array(parameters[4:9], float), **more)


class _Matrix(Strict):
    rows: int
    cols: int
    data: list[float]


class _Added(Strict):
    format: Literal[1]
    covariance: list[list[float]] | None = None
    info: dict[str, Any] = Field(default_factory=dict)


class _File(Strict):
    image_width: Annotated[int, Field(ge=16, le=100_000)]
    image_height: Annotated[int, Field(ge=16, le=100_000)]
    camera_name: str = "camera"
    camera_matrix: _Matrix
    distortion_model: str
    distortion_coefficients: _Matrix
    rectification_matrix: _Matrix | None = None
    projection_matrix: _Matrix | None = None
    binning_x: Annotated[int, Field(ge=0, le=1)] = 0
    binning_y: Annotated[int, Field(ge=0, le=1)] = 0
    xneck: _Added | None = None


def read_camera(path: str | Path) -> Camera:
    """camera.yaml, or any ROS camera_info YAML of the model plumb_bob.

    Raises Refused with the place for a file of another kind or model, or with values that no camera has.
    """
    file = validate(load(path), _File, path)
    if file.distortion_model not in ("plumb_bob", "rational_polynomial", "equidistant"):
        raise Refused(path, f"distortion_model: unknown model {file.distortion_model!r}", "expected plumb_bob")
    if file.distortion_model != "plumb_bob":
        raise Refused(path, f"distortion_model: {file.distortion_model} is not read", "calibrate with plumb_bob")
    K = _array(path, "camera_matrix", file.camera_matrix, (3, 3))
    count = len(file.distortion_coefficients.data)
    if count not in (4, 5):
        raise Refused(path, f"distortion_coefficients: expected 4 or 5 of them (k1 k2 p1 p2 k3), found {count}")
    width, height = file.image_width, file.image_height
    if np.any(np.array([K[0, 1], K[1, 0], K[2, 0], K[2, 1], K[2, 2] - 1])):
        raise Refused(path, "camera_matrix: expected [fx, 0, cx, 0, fy, cy, 0, 0, 1]", "a skewed camera is not read")
    for place, focal in (("data[0]", K[0, 0]), ("data[4]", K[1, 1])):
        if not 0.05 * width <= focal <= 100 * width:
            raise Refused(path, f"camera_matrix.{place}: a focal length of {focal:g} px, expected pixels, not mm")
    for place, value, extent in (("data[2]", K[0, 2], width), ("data[5]", K[1, 2], height)):
        if not -extent <= value <= 2 * extent:
            raise Refused(path, f"camera_matrix.{place}: the optical axis at {value:g} px of {extent}")
    distortion = np.array([*file.distortion_coefficients.data, 0.0][:5])
    added = file.xneck
    covariance = None
    if added is not None and added.covariance is not None:
        if len(added.covariance) != 9 or any(len(row) != 9 for row in added.covariance):
            raise Refused(path, "xneck.covariance: expected 9 rows of 9 numbers")
        covariance = np.array(added.covariance)
        if not np.allclose(covariance, covariance.T, rtol=1e-6) or np.any(np.diag(covariance) < 0):
            raise Refused(path, "xneck.covariance: expected a symmetric matrix with a positive diagonal")
    return Camera(width, height, K, distortion, covariance, file.camera_name, dict(added.info) if added else {})


def write_camera(camera: Camera, path: str | Path) -> None:
    """Write camera.yaml, whole or not at all; ROS reads it, and OpenCV's FileStorage too."""
    K, d = camera.K, camera.distortion
    projection = np.column_stack([K, np.zeros(3)])
    lines = [
        f"image_width: {camera.width}",
        f"image_height: {camera.height}",
        f"camera_name: {flow(camera.name)}",
        *_matrix_lines("camera_matrix", K),
        "distortion_model: plumb_bob",
        *_matrix_lines("distortion_coefficients", d.reshape(1, -1)),
        *_matrix_lines("rectification_matrix", np.eye(3)),
        *_matrix_lines("projection_matrix", projection),
        "xneck:",
        "  format: 1",
    ]
    if camera.covariance is not None:
        lines.append(f"  # of {', '.join(lens.NAMES)}; zero where fixed")
        lines.append("  covariance:")
        lines += [f"    - {flow(row)}" for row in camera.covariance.tolist()]
    if camera.info:
        lines.append("  info:")
        for key, value in camera.info.items():
            if isinstance(value, list) and value and not isinstance(value[0], int | float):
                lines += [f"    {key}:", *(f"      - {flow(entry)}" for entry in value)]
            else:
                lines.append(f"    {key}: {flow(value)}")
    write_text(path, "\n".join(lines) + "\n")


def _matrix_lines(key: str, matrix: np.ndarray) -> list[str]:
    rows, cols = matrix.shape
    return [f"{key}:", f"  rows: {rows}", f"  cols: {cols}", f"  data: {flow(matrix.ravel().tolist())}"]


def _array(path: str | Path, key: str, matrix: _Matrix, shape: tuple[int, int]) -> np.ndarray:
    if (matrix.rows, matrix.cols) != shape or len(matrix.data) != shape[0] * shape[1]:
        raise Refused(
            path,
            f"{key}: expected {shape[0]} x {shape[1]}, found {matrix.rows} x {matrix.cols} with {len(matrix.data)}",
        )
    return np.array(matrix.data).reshape(shape)
