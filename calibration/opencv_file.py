"""A camera as cv2.FileStorage writes it: YAML, XML or JSON, under the names that OpenCV's own programs use."""

import re
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from calibration.camera import Camera, refuse_implausible
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import listed
from xneck_foundation.spelling import quoted

_MATRIX = ("camera_matrix", "cameramatrix", "intrinsic_matrix", "mtx", "k")
_DISTORTION = ("distortion_coefficients", "distcoeffs", "dist_coeffs", "distortion", "dist", "d")
_WIDTH = ("image_width", "imagewidth", "width")
_HEIGHT = ("image_height", "imageheight", "height")
_SIZE = ("image_size", "imagesize", "img_size", "size")
_COVARIANCE = "covariance"
_MAX_NESTED = 1000
"""most brackets, tags and dashes that may open a level: OpenCV reads level by level and ends the process where it has no more
memory for that, with 20,000 of them; a camera's file has some tens (docs/thresholds.md)"""
_MAX_ENTRIES = 1000
"""most names, and numbers of a matrix: OpenCV looks for each from the beginning; a covariance has 81 (docs/thresholds.md)"""
_OPENING = re.compile(r"[\[{<]|-(?=\s)")


def is_opencv(text: str) -> bool:
    """Is `text` one that cv2.FileStorage writes?"""
    start = text.lstrip("\ufeff \t\r\n")
    # its older `%YAML:1.0` is no YAML directive, its newer `%YAML 1.2` may head any YAML
    return start.startswith(("%YAML:", "<")) or "opencv-matrix" in text


def from_opencv(text: str, path: str | Path) -> Camera:
    """The camera in a FileStorage's text; `path` names it in a refusal.

    Names are taken whatever their capitals. Raises Refused where matrix, coefficients or picture size are missing, and
    for fisheye, rational, thin prism and tilted lens models.
    """
    if sum(1 for _ in _OPENING.finditer(text)) > _MAX_NESTED:
        raise Refused(path, f"opens more than {_MAX_NESTED} lists, tags or maps", "is this a camera's file?")
    try:
        storage = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
        opened = storage.isOpened()
    except (cv2.error, SystemError) as error:
        raise Refused(path, "is not what cv2.FileStorage writes", "is this a camera's file?") from error
    if not opened or not storage.root().isMap():
        raise Refused(path, "is not what cv2.FileStorage writes", "is this a camera's file?")
    names = storage.root().keys()
    if len(names) > _MAX_ENTRIES:
        raise Refused(path, f"has {len(names)} entries", "is this a camera's file?")
    nodes = {name.lower(): storage.getNode(name) for name in names}
    if {"m1", "d1", "m2", "d2"} <= set(nodes):
        raise Refused(path, "holds the two cameras of a stereo pair", "save the one that is meant as camera_matrix")
    fisheye = nodes.get("fisheye_model")
    model = nodes.get("distortion_model")
    word = model.string() if model is not None and model.isString() else "plumb_bob"
    if (fisheye is not None and fisheye.real() != 0) or word in ("fisheye", "equidistant", "omnidir"):
        raise Refused(path, "a fisheye model is not read", "calibrate without it; more than about 100 degrees need one")
    if word not in ("plumb_bob", "rational_polynomial"):
        raise Refused(path, f"distortion_model: unknown model {quoted(word)}", "expected plumb_bob")
    K = _matrix(path, nodes, _MATRIX)
    if K.shape != (3, 3) or np.any(np.array([K[0, 1], K[1, 0], K[2, 0], K[2, 1], K[2, 2] - 1])):
        raise Refused(path, "camera_matrix: expected [fx, 0, cx, 0, fy, cy, 0, 0, 1]", "a skewed camera is not read")
    coefficients = _matrix(path, nodes, _DISTORTION).ravel()
    if len(coefficients) not in (4, 5, 8, 12, 14):
        raise Refused(
            path, f"distortion_coefficients: expected 4 or 5 of them (k1 k2 p1 p2 k3), found {coefficients.size}"
        )
    if np.any(coefficients[5:]):
        names = ("k4", "k5", "k6", "s1", "s2", "s3", "s4", "tau_x", "tau_y")
        used = [name for name, value in zip(names, coefficients[5:], strict=False) if value]
        raise Refused(
            path, f"a lens model with {', '.join(used)} is not read", "calibrate with k1, k2, p1, p2, k3 only"
        )
    width, height = _size(path, nodes)
    covariance = None
    if _COVARIANCE in nodes:
        covariance = _matrix(path, nodes, (_COVARIANCE,))
        if covariance.shape != (9, 9) or not np.allclose(covariance, covariance.T, rtol=1e-6):
            raise Refused(path, "covariance: expected a symmetric 9 x 9 of fx, fy, cx, cy, k1, k2, p1, p2, k3")
    camera = Camera(
        width=width,
        height=height,
        K=K,
        distortion=np.array([*coefficients, 0.0][:5], float),
        covariance=covariance,
    )
    refuse_implausible(camera, path, ("camera_matrix[0]", "camera_matrix[4]", "camera_matrix[2]", "camera_matrix[5]"))
    return camera


def opencv_text(camera: Camera, path: str | Path) -> tuple[str, str]:
    """`camera` as cv2.FileStorage's YAML, and what is lost: nothing, the covariance stands in a node of its own."""
    storage = cv2.FileStorage("camera.yaml", cv2.FILE_STORAGE_WRITE | cv2.FILE_STORAGE_MEMORY)
    storage.write("image_width", camera.width)
    storage.write("image_height", camera.height)
    storage.write("camera_matrix", np.asarray(camera.K, np.float64))
    storage.write("distortion_coefficients", np.asarray(camera.distortion, np.float64).reshape(5, 1))
    if isinstance(camera.info.get("rms_px"), float):
        storage.write("avg_reprojection_error", camera.info["rms_px"])
    if camera.covariance is not None:
        storage.writeComment("of fx, fy, cx, cy, k1, k2, p1, p2, k3; zero where fixed", False)
        storage.write(_COVARIANCE, np.asarray(camera.covariance, np.float64))
    return storage.releaseAndGetString(), ""


def _matrix(path: str | Path, nodes: dict[str, Any], names: tuple[str, ...]) -> np.ndarray:
    for name in names:
        node = nodes.get(name)
        if node is None:
            continue
        value = _numbers(node)
        if value is None or not np.all(np.isfinite(value)):
            raise Refused(path, f"{name}: expected a matrix of finite numbers")
        return np.asarray(value, np.float64)
    raise Refused(path, f"{names[0]}: missing", f"found: {listed(nodes) or 'nothing'}")


def _numbers(node: Any) -> np.ndarray | None:
    """A matrix, or a plain list, which is a matrix to people though not to OpenCV; None where it is neither.

    Number by number: FileNode.mat() writes past its memory where a matrix lacks its columns.
    """
    values = _listed(node)
    if values is not None or not node.isMap():
        return values
    sizes = _listed(node.getNode("sizes"))
    if sizes is None:
        rows, columns = node.getNode("rows"), node.getNode("cols")
        if not (rows.isInt() and columns.isInt()):
            return None
        sizes = np.array([rows.real(), columns.real()])
    values = _listed(node.getNode("data"))
    if values is None or len(sizes) not in (1, 2) or np.any(sizes < 1) or np.prod(sizes) != len(values):
        return None
    return values.reshape(sizes.astype(int))


def _listed(node: Any) -> np.ndarray | None:
    """A list of numbers; None where the node is something else."""
    entries = [node.at(i) for i in range(node.size())] if node.isSeq() and node.size() <= _MAX_ENTRIES else []
    if not entries or not all(entry.isInt() or entry.isReal() for entry in entries):
        return None
    return np.array([entry.real() for entry in entries])


def _size(path: str | Path, nodes: dict[str, Any]) -> tuple[int, int]:
    wide = next((nodes[name].real() for name in _WIDTH if name in nodes), None)
    high = next((nodes[name].real() for name in _HEIGHT if name in nodes), None)
    if wide is None and high is None and (found := [name for name in _SIZE if name in nodes]):
        pair = _matrix(path, nodes, tuple(found)).ravel()
        wide, high = pair.tolist() if len(pair) == 2 else (None, None)
    if wide is None or high is None:
        raise Refused(path, "image_width, image_height: missing", "add the size of the pictures it was calibrated with")
    if not (16 <= wide <= 100_000 and 16 <= high <= 100_000):
        raise Refused(path, f"image_width, image_height: {wide:g} x {high:g} is no picture's size")
    return int(wide), int(high)
