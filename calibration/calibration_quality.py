"""The quality of a calibration: what it covers, how exact it is over the picture, and what to photograph next."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from calibration.coverage import Coverage, NextPicture, coverage_of, next_pictures
from calibration.estimation import Calibration
from calibration.projection_uncertainty import ProjectionSigma, projection_sigma


@dataclass(frozen=True)
class CalibrationQuality:
    """What a calibration covers, how exact it is, and how to improve it."""

    coverage: Coverage
    projection: ProjectionSigma
    next_pictures: tuple[NextPicture, ...]

    def as_json(self) -> dict[str, Any]:
        """The keys of --json that stand beside those of calibration/summary.py."""
        covered = self.coverage
        return {
            "coverage": {
                "share_of_cells": covered.share,
                "missing": list(covered.missing),
                "tilts_rad": covered.tilts.tolist(),
                "distances_m": covered.distances.tolist(),
                "wants": list(covered.wants),
            },
            "projection": {
                "median_px": self.projection.median,
                "worst_px": self.projection.worst,
                "worst_where": self.projection.worst_place,
            },
            "next_pictures": [
                {"where": p.where, "words": p.words, "sigma_px_after": p.sigma_px, "reduction": p.reduction}
                for p in self.next_pictures
            ],
        }


def assess_quality(calibration: Calibration) -> CalibrationQuality:
    """The quality of `calibration` from its covariance and views."""
    return CalibrationQuality(
        coverage_of(calibration.camera, calibration.views, calibration.poses),
        projection_sigma(calibration.camera),
        next_pictures(calibration),
    )


def corner_errors(calibration: Calibration) -> tuple[np.ndarray, np.ndarray]:
    """All corners used: where they were observed, and observed less predicted, both shape (n, 2), px."""
    pixels, errors = [], []
    for view, R, t in zip(calibration.views, calibration.poses.R, calibration.poses.t, strict=True):
        predicted = calibration.camera.project(
            calibration.board.of(view.corner_ids) @ R.T + t, np.zeros(3), np.zeros(3)
        )
        pixels.append(view.image_points)
        errors.append(view.image_points - predicted)
    return np.concatenate(pixels), np.concatenate(errors)
