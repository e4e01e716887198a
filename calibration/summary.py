"""A calibration as the machine-readable result that other programs read."""

from dataclasses import asdict
from typing import Any

import numpy as np

from calibration import board_shape, lens
from calibration.estimation import Calibration

_MAX_RELATIVE_SIGMA_PERCENT = 30.0
"""%: relative standard deviation from which on a parameter counts as not identified (docs/thresholds.md)"""


def calibration_json(calibration: Calibration) -> dict[str, Any]:
    """The result with JSON's types only. Parameters not estimated (k3, as a rule) have sigma null."""
    camera = calibration.camera
    assert camera.covariance is not None
    sigmas = np.sqrt(np.diag(camera.covariance))
    parameters: list[dict[str, Any]] = []
    for name, value, sigma in zip(lens.PARAMETER_NAMES, camera.parameters, sigmas, strict=True):
        free = name in calibration.free
        relative = 100 * float(sigma) / abs(float(value)) if free and value else None
        parameters.append(
            {
                "name": name,
                "index": None,
                "value": float(value),
                "unit": "px" if name in ("fx", "fy", "cx", "cy") else "1",
                "sigma": float(sigma) if free else None,
                "relative_sigma_percent": relative,
                "identified": relative is not None and relative < _MAX_RELATIVE_SIGMA_PERCENT,
            }
        )
    return {
        "rms_px": calibration.rms_px,
        "held_out_rms_px": calibration.held_out_rms_px,
        "parameters": parameters,
        "pictures": [
            {
                "file": picture.name,
                "used": picture.used,
                "why": picture.why,
                "rms_px": picture.rms_px,
                "held_out_rms_px": picture.held_out_rms_px,
            }
            for picture in calibration.pictures
        ],
        "image_width": camera.width,
        "image_height": camera.height,
        "corners": calibration.corners,
        "largest_tilt_rad": calibration.tilt,
        "sigma_least_squares": dict(
            zip(lens.PARAMETER_NAMES, map(float, calibration.sigma_least_squares), strict=True)
        ),
        "sigma_jackknife": dict(zip(lens.PARAMETER_NAMES, map(float, calibration.sigma_jackknife), strict=True)),
        "noise_px": calibration.noise_px,
        "corner_noise_px": calibration.corner_noise_px,
        "lens": calibration.lens,
        "board": _board(calibration),
        "candidates": [asdict(candidate) for candidate in calibration.candidates],
        "cross_check": _cross_check(calibration),
        "notes": list(calibration.notes),
    }


def _board(calibration: Calibration) -> dict[str, Any]:
    """The board's shape; sigma is null where the selected model holds a parameter fixed."""
    shape, free = calibration.board, calibration.board.model.free
    numbers = {
        name: {"value": float(value), "unit": unit, "sigma": float(sigma) if name in free else None}
        for name, value, sigma, unit in zip(
            board_shape.SHAPE_NAMES, shape.values, calibration.board_sigma, ("m", "m", "1"), strict=True
        )
    }
    offsets_rms = np.sqrt(np.mean(shape.offsets**2, axis=0))
    return {
        "model": shape.model.name,
        **numbers,
        "sagitta_m": [float(bow) for bow in shape.bow],
        "offsets_rms_m": [float(value) for value in offsets_rms],
    }


def _cross_check(calibration: Calibration) -> dict[str, Any] | None:
    """OpenCV's values, and by how many of our standard deviations ours are above them."""
    opencv = calibration.cross_check
    if opencv is None:
        return None
    return {
        "rms_px": opencv.rms_px,
        "parameters": dict(zip(lens.PARAMETER_NAMES, map(float, opencv.parameters), strict=True)),
        "differences_sigma": dict(zip(lens.PARAMETER_NAMES, map(float, opencv.differences), strict=True)),
    }
