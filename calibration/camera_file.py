"""Files that hold a camera: ROS camera_info (ours), OpenCV's FileStorage and Kalibr's camchain, told by their content."""

from pathlib import Path
from typing import Literal

from calibration.camera import Camera
from calibration.kalibr_file import from_kalibr, is_kalibr, kalibr_text
from calibration.opencv_file import from_opencv, is_opencv, opencv_text
from calibration.ros_file import from_ros, write_camera
from xneck_foundation.strict_yaml import parse_yaml, read_text
from xneck_foundation.whole_file import write_text

__all__ = ["FORMATS", "export_camera", "read_camera", "write_camera"]

FORMATS = ("opencv", "kalibr")


def read_camera(path: str | Path) -> Camera:
    """The camera in a ROS camera_info YAML, an OpenCV FileStorage (YAML, XML or JSON) or a Kalibr camchain YAML.

    Raises Refused with the place for a file of another kind, a lens model other than plumb_bob (radtan), or values that
    no camera has.
    """
    text = read_text(Path(path))
    if is_opencv(text):
        return from_opencv(text, path)
    document = parse_yaml(text, path)
    return from_kalibr(document, path) if is_kalibr(document) else from_ros(document, path)


def export_path(out: Path, kind: str) -> Path:
    """Where the camera goes for other tools: `<stem>.opencv.yaml` or `<stem>.kalibr.yaml` beside `out`."""
    return out.with_name(f"{out.stem}.{kind}.yaml")


def export_camera(camera: Camera, out: Path, kind: Literal["opencv", "kalibr"]) -> tuple[Path, str]:
    """Writes `camera` beside `out` for another tool; its path, and what the format lost, in words.

    Raises Refused where the format cannot carry the camera.
    """
    path = export_path(out, kind)
    text, lost = (opencv_text if kind == "opencv" else kalibr_text)(camera, path)
    write_text(path, text)
    return path, lost
