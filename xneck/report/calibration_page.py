"""One calibration as one HTML page that needs nothing beside itself."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from calibration import lens
from calibration.calibration_quality import CalibrationQuality
from calibration.estimation import Calibration
from vision.linkage.arm_sigma import ArmSigma
from xneck.report import calibration_figures as figures
from xneck.report.figure_block import FigureBlock
from xneck.report.figures_file import write_figures
from xneck.report.key_number import KeyNumber
from xneck.report.number_text import number_text, with_sigma
from xneck.report.provenance_table import input_file_rows, version_text
from xneck.report.style import drawing
from xneck.report.template import render
from xneck_foundation.whole_file import write_text


@dataclass(frozen=True)
class CalibrationResult:
    """Everything that the page of a calibration shows."""

    name: str
    board: str
    """the board in words"""
    calibration: Calibration
    quality: CalibrationQuality
    arm: ArmSigma | None
    """sigma at the arm; None where no arm was named"""
    provenance: Mapping[str, Any]


def write_calibration_report(result: CalibrationResult, path: Path) -> None:
    """The page with its figures' numbers beside it, whole or not at all; the same result gives the same bytes."""
    calibration, quality = result.calibration, result.quality
    with drawing():
        drawn = {
            "sigma_figure": figures.sigma_figure(calibration, quality, result.arm),
            "next_figure": figures.next_board_figure(calibration.camera, quality),
            "coverage_figure": figures.coverage_figure(calibration, quality),
            "residual_figure": figures.residual_figure(calibration),
        }
    write_figures(drawn.values(), path)
    write_text(path, calibration_html(result, drawn))


def calibration_html(result: CalibrationResult, drawn: Mapping[str, FigureBlock]) -> str:
    """The HTML of a calibration's page."""
    calibration, quality = result.calibration, result.quality
    return render(
        "calibration.html.jinja",
        result=result,
        calibration=calibration,
        quality=quality,
        sentence=calibration_sentence(result),
        poor=bool(quality.coverage.wants),
        head=calibration_key_numbers(result),
        parameters=parameter_rows(calibration),
        pictures=picture_rows(result),
        models=model_rows(calibration),
        board_shape=board_shape_sentence(calibration),
        arm_rows=arm_rows(result.arm) if result.arm else None,
        inputs=input_file_rows(result.provenance),
        versions=version_text(result.provenance),
        number=number_text,
        **drawn,
    )


def calibration_sentence(result: CalibrationResult) -> str:
    """How well the camera is known, from how many pictures, what that means at the arm, and what is missing."""
    calibration, projection = result.calibration, result.quality.projection
    median, worst = number_text(projection.median, 2), number_text(projection.worst, 2)
    parts = [
        f"The camera is known to {median} px over the picture (1 σ, {worst} px in the {projection.worst_place}) "
        f"from {len(calibration.views)} of {len(calibration.pictures)} pictures",
        f"pictures held out are predicted to {calibration.held_out_rms_px:.3f} px",
    ]
    if result.arm is not None:
        worst_angle = float(np.degrees(result.arm.worst_alpha))
        parts.append(
            f"joint angles seen through it are off by {number_text(worst_angle, 2)} deg at most ({result.arm.name})"
        )
    wants = result.quality.coverage.wants
    return "; ".join(parts) + "." + (f" To mend: {'; '.join(wants)}." if wants else "")


def calibration_key_numbers(result: CalibrationResult) -> list[KeyNumber]:
    """The numbers below the sentence."""
    calibration, quality = result.calibration, result.quality
    camera = calibration.camera
    assert camera.covariance is not None
    focal, sigma = float(np.mean(camera.parameters[:2])), float(np.sqrt(np.diag(camera.covariance)[:2]).max())
    numbers = [
        KeyNumber(
            "reprojection",
            f"{calibration.rms_px:.3f} px",
            f"{calibration.held_out_rms_px:.3f} px for pictures held out",
        ),
        KeyNumber(
            "projection",
            f"± {number_text(quality.projection.median, 2)} px",
            f"worst {number_text(quality.projection.worst, 2)} px",
        ),
        KeyNumber("focal length", f"{with_sigma(focal, sigma)} px", f"± {number_text(100 * sigma / focal, 2)} %"),
        KeyNumber("coverage", f"{100 * quality.coverage.share:.0f} %", "of the picture's cells hold corners"),
        KeyNumber("largest tilt", f"{np.degrees(calibration.tilt):.0f} deg", "between two boards"),
    ]
    if result.arm is not None:
        arm = result.arm
        angle = number_text(float(np.degrees(arm.worst_alpha)), 2)
        numbers.append(
            KeyNumber("joint angle", f"± {angle} deg", f"worst joint, arm {number_text(arm.distance, 2)} m away")
        )
    return numbers


def parameter_rows(calibration: Calibration) -> list[tuple[str, ...]]:
    """Rows of the table of parameters: name, value with sigma, sigmas of least squares and jackknife, OpenCV's value, unit."""
    assert calibration.camera.covariance is not None
    reported = np.sqrt(np.diag(calibration.camera.covariance))
    rows = []
    for k, (name, value) in enumerate(zip(lens.PARAMETER_NAMES, calibration.camera.parameters.tolist(), strict=True)):
        unit = "px" if name in ("fx", "fy", "cx", "cy") else ""
        if name in calibration.free:
            text = with_sigma(value, float(reported[k]))
            sigmas = [
                number_text(float(s[k]), 2) for s in (calibration.sigma_least_squares, calibration.sigma_jackknife)
            ]
        else:
            text, sigmas = f"{number_text(value)} (held fixed)", ["–", "–"]
        beside = "–" if calibration.cross_check is None else number_text(float(calibration.cross_check.parameters[k]))
        rows.append((name, text, *sigmas, beside, unit))
    return rows


def model_rows(calibration: Calibration) -> list[tuple[str, ...]]:
    """Rows of the table of models, simplest first: lens, board, numbers estimated, focal length, errors, whether it was taken."""
    return [
        (
            c.lens,
            c.board,
            str(c.free),
            f"{(c.fx + c.fy) / 2:.2f}",
            f"{c.rms_px:.3f}",
            f"{c.held_out_rms_px:.3f}",
            "taken" if c.chosen else "as good" if c.excess <= c.excess_error else "",
        )
        for c in calibration.candidates
    ]


def board_shape_sentence(calibration: Calibration) -> str:
    """The board's shape as estimated, in a sentence."""
    if calibration.board.model.name == "rigid":
        return "The board is taken as flat and printed as described: nothing else predicts pictures held out better."
    bow_x, bow_y = (number_text(float(bow), 2) for bow in 1e3 * calibration.board.bow)
    return (
        f"The board is estimated along with the camera ({calibration.board.model.name}): it bows by {bow_x} mm "
        f"along x and {bow_y} mm along y. Believed flat, it would have bent the lens."
    )


def picture_rows(result: CalibrationResult) -> list[tuple[str, ...]]:
    """Rows of the table of pictures: name, errors, tilt and distance of the board, and why it was left out."""
    calibration, coverage = result.calibration, result.quality.coverage
    view_index = {view.name: k for k, view in enumerate(calibration.views)}
    rows = []
    for picture in calibration.pictures:
        k = view_index.get(picture.name)
        pose = (
            ("–", "–")
            if k is None
            else (f"{np.degrees(coverage.tilts[k]):.0f}", f"{number_text(float(coverage.distances[k]), 3)}")
        )
        rms = ["–" if value is None else f"{value:.3f}" for value in (picture.rms_px, picture.held_out_rms_px)]
        rows.append((picture.name, *rms, *pose, "used" if picture.used else f"left out: {picture.why}"))
    return rows


def arm_rows(arm: ArmSigma) -> list[tuple[str, ...]]:
    """Rows of the table of joints: sigma of the angle at 0 and at +-30 degrees, and of the motion between them, deg."""
    return [
        (f"joint {i + 1}", *(number_text(float(s), 2) for s in np.degrees([*arm.alpha[:, i], *arm.bend[:, i]])))
        for i in range(arm.alpha.shape[1])
    ]
