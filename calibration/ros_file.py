"""camera.yaml: ROS camera_info with our additions under the key `xneck`."""

from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from calibration import lens
from calibration.camera import Camera, refuse_implausible
from xneck_foundation.errors import Refused
from xneck_foundation.spelling import quoted
from xneck_foundation.strict_yaml import Strict, validate_document
from xneck_foundation.whole_file import write_text
from xneck_foundation.yaml_text import flow


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


def from_ros(document: Any, path: str | Path) -> Camera:
    """A loaded ROS camera_info of the model plumb_bob as a camera; `path` names it in a refusal.

    Raises Refused with the place for a file of another kind or model, or with values that no camera has.
    """
    file = validate_document(document, _File, path)
    if file.distortion_model not in ("plumb_bob", "rational_polynomial", "equidistant"):
        raise Refused(path, f"distortion_model: unknown model {quoted(file.distortion_model)}", "expected plumb_bob")
    if file.distortion_model != "plumb_bob":
        raise Refused(path, f"distortion_model: {file.distortion_model} is not read", "calibrate with plumb_bob")
    K = _array(path, "camera_matrix", file.camera_matrix, (3, 3))
    count = len(file.distortion_coefficients.data)
    if count not in (4, 5):
        raise Refused(path, f"distortion_coefficients: expected 4 or 5 of them (k1 k2 p1 p2 k3), found {count}")
    width, height = file.image_width, file.image_height
    if np.any(np.array([K[0, 1], K[1, 0], K[2, 0], K[2, 1], K[2, 2] - 1])):
        raise Refused(path, "camera_matrix: expected [fx, 0, cx, 0, fy, cy, 0, 0, 1]", "a skewed camera is not read")
    distortion = np.array([*file.distortion_coefficients.data, 0.0][:5])
    added = file.xneck
    covariance = None
    if added is not None and added.covariance is not None:
        if len(added.covariance) != 9 or any(len(row) != 9 for row in added.covariance):
            raise Refused(path, "xneck.covariance: expected 9 rows of 9 numbers")
        covariance = np.array(added.covariance)
        if not np.allclose(covariance, covariance.T, rtol=1e-6) or np.any(np.diag(covariance) < 0):
            raise Refused(path, "xneck.covariance: expected a symmetric matrix with a positive diagonal")
    camera = Camera(
        width=width,
        height=height,
        K=K,
        distortion=distortion,
        covariance=covariance,
        name=file.camera_name,
        info=dict(added.info) if added else {},
    )
    data = "camera_matrix.data[{}]"
    refuse_implausible(camera, path, (data.format(0), data.format(4), data.format(2), data.format(5)))
    return camera


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
        lines.append(f"  # of {', '.join(lens.PARAMETER_NAMES)}; zero where fixed")
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
