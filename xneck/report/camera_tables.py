"""Tables of a camera, the pictures that it was calibrated from, and the markers that it saw."""

import numpy as np

from calibration.camera import Camera
from calibration.estimation import Calibration
from calibration.lens import PARAMETER_NAMES
from vision.extract import Extraction
from xneck.report.number_text import number_text, with_sigma


def camera_rows(camera: Camera, calibration: Calibration | None) -> list[tuple[str, str, str]]:
    """Rows of the table of camera parameters: name, value with sigma, unit."""
    sigma = np.full(len(PARAMETER_NAMES), np.nan) if camera.covariance is None else np.sqrt(np.diag(camera.covariance))
    rows = []
    for name, value, s in zip(PARAMETER_NAMES, camera.parameters.tolist(), sigma.tolist(), strict=True):
        fixed = calibration is not None and name not in calibration.free
        text = (
            f"{number_text(value)} (held fixed)" if fixed else with_sigma(value, s) if s > 0 else number_text(value, 6)
        )
        rows.append((name, text, "px" if name in ("fx", "fy", "cx", "cy") else ""))
    return rows


def picture_rows(calibration: Calibration) -> list[tuple[str, str, str, str]]:
    """Rows of the table of pictures: name, error and held-out error, px, and why it was left out."""
    return [
        (
            picture.name,
            "–" if picture.rms_px is None else f"{picture.rms_px:.3f}",
            "–" if picture.held_out_rms_px is None else f"{picture.held_out_rms_px:.3f}",
            "used" if picture.used else f"left out: {picture.why}",
        )
        for picture in calibration.pictures
    ]


def marker_rows(extraction: Extraction) -> list[tuple[str, str, str]]:
    """Rows of the table of markers: id, share of frames in which it was found, frames in which it was found twice."""
    markers = extraction.angles.notes["markers"]
    return [(str(m["id"]), f"{100 * m['seen_share']:.1f} %", str(m["duplicates"])) for m in markers]
