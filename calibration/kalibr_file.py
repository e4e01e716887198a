"""A camera as Kalibr's camchain YAML has it: camera_model pinhole with distortion_model radtan."""

from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from calibration.camera import Camera, camera_from, refuse_implausible
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import listed
from xneck_foundation.spelling import quoted
from xneck_foundation.strict_yaml import Strict, validate_document
from xneck_foundation.yaml_text import flow

Side = Annotated[int, Field(ge=16, le=100_000)]


class _Cam(Strict):
    camera_model: str
    intrinsics: list[float]
    distortion_model: str
    distortion_coeffs: list[float]
    resolution: tuple[Side, Side]
    # what Kalibr also writes, about other sensors
    rostopic: str | None = None
    cam_overlaps: list[int] | None = None
    T_cn_cnm1: Any = None
    T_cam_imu: Any = None
    timeshift_cam_imu: float | None = None
    line_delay: float | None = None


def is_kalibr(document: Any) -> bool:
    """Has a loaded YAML document a camera the way Kalibr names it?"""
    return isinstance(document, dict) and "cam0" in document


def from_kalibr(document: Any, path: str | Path) -> Camera:
    """The one camera of a loaded camchain; `path` names it in a refusal.

    Raises Refused for more than one camera, and for models other than pinhole with radtan or no distortion.
    """
    others = sorted(set(document) - {"cam0"})
    if others:
        raise Refused(path, f"holds cam0 and {listed(others)}", "leave one camera in it, as cam0")
    cam = validate_document(document["cam0"], _Cam, f"{path}: cam0")
    if cam.camera_model != "pinhole":
        raise Refused(
            path, f"cam0.camera_model: {quoted(cam.camera_model)} is not read", "calibrate with pinhole-radtan"
        )
    if cam.distortion_model not in ("radtan", "none"):
        raise Refused(
            path, f"cam0.distortion_model: {quoted(cam.distortion_model)} is not read", "calibrate with pinhole-radtan"
        )
    count = 4 if cam.distortion_model == "radtan" else 0
    if len(cam.distortion_coeffs) != count:
        raise Refused(path, f"cam0.distortion_coeffs: expected {count}, found {len(cam.distortion_coeffs)}")
    if len(cam.intrinsics) != 4:
        raise Refused(path, f"cam0.intrinsics: expected 4 (fu, fv, pu, pv), found {len(cam.intrinsics)}")
    camera = camera_from(np.array([*cam.intrinsics, *cam.distortion_coeffs, *[0.0] * (5 - count)]), cam.resolution)
    refuse_implausible(camera, path, tuple(f"cam0.intrinsics[{i}]" for i in range(4)))  # type: ignore[arg-type]
    return camera


def kalibr_text(camera: Camera, path: str | Path) -> tuple[str, str]:
    """`camera` as a camchain of one, and what is lost, in words. Raises Refused for k3, which radtan does not have."""
    fx, fy, cx, cy, k1, k2, p1, p2, k3 = camera.parameters.tolist()
    if k3:
        raise Refused(
            path, f"not written: k3 = {k3:.3g} has no place in Kalibr's radtan", "export opencv, which has k3"
        )
    lines = [
        "cam0:",
        "  camera_model: pinhole",
        f"  intrinsics: {flow([fx, fy, cx, cy])}",
        "  distortion_model: radtan",
        f"  distortion_coeffs: {flow([k1, k2, p1, p2])}",
        f"  resolution: {flow([camera.width, camera.height])}",
        "  rostopic: /camera/image_raw",
    ]
    lost = "Kalibr's format has no place for the covariance" if camera.covariance is not None else ""
    return "\n".join(lines) + "\n", lost
