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
from xneck.report.number_text import number_text, with_sigma
from xneck.report.provenance_table import input_file_rows, version_text
from xneck.report.key_number import KeyNumber
from xneck.report.style import drawing
from xneck.report.template import render
from xneck_foundation.whole_file import write_text


@dataclass(frozen=True)
class CalibrationResult:
    """Everything that the page of a calibration shows."""

    name: str
    board: str
    """in words"""
    calibration: Calibration
    meaning: CalibrationQuality
    arm: ArmSigma | None
    provenance: Mapping[str, Any]


def write_calibration_report(result: CalibrationResult, path: Path) -> None:
    """The page with its figures' numbers beside it, whole or not at all; the same result gives the same bytes."""
    found, meaning = result.calibration, result.meaning
    with drawing():
        drawn = {
            "sigma_figure": figures.sigma_map(found, meaning, result.arm),
            "next_figure": figures.next_boards(found.camera, meaning),
            "coverage_figure": figures.coverage(found, meaning),
            "residual_figure": figures.residuals(found),
        }
    write_figures(drawn.values(), path)
    write_text(path, calibration_html(result, drawn))


def calibration_html(result: CalibrationResult, drawn: Mapping[str, FigureBlock]) -> str:
    """The HTML of a calibration."""
    found, meaning = result.calibration, result.meaning
    return render(
        "calibration.html.jinja",
        result=result,
        calibration=found,
        meaning=meaning,
        sentence=calibration_sentence(result),
        poor=bool(meaning.coverage.wants),
        head=calibration_key_numbers(result),
        parameters=parameter_rows(found),
        pictures=picture_rows(result),
        models=model_rows(found),
        board_shape=shape_in_words(found),
        arm_rows=arm_rows(result.arm) if result.arm else None,
        inputs=input_file_rows(result.provenance),
        versions=version_text(result.provenance),
        number=number_text,
        **drawn,
    )


def calibration_sentence(result: CalibrationResult) -> str:
    """How well the camera is known, from what, what that is at the arm, and what is missing."""
    found, projection = result.calibration, result.meaning.projection
    parts = [
        f"The camera is known to {number_text(projection.median, 2)} px over the picture (1 σ, {number_text(projection.worst, 2)} px in the "
        f"{projection.worst_place}) from {len(found.views)} of {len(found.pictures)} pictures",
        f"pictures held out are predicted to {found.held_out_rms_px:.3f} px",
    ]
    if result.arm is not None:
        worst = np.degrees(result.arm.worst_alpha)
        parts.append(
            f"joint angles seen through it are off by {number_text(float(worst), 2)} deg at most ({result.arm.name})"
        )
    wants = result.meaning.coverage.wants
    return "; ".join(parts) + "." + (f" To mend: {'; '.join(wants)}." if wants else "")


def calibration_key_numbers(result: CalibrationResult) -> list[KeyNumber]:
    """The head's numbers."""
    found, meaning = result.calibration, result.meaning
    camera = found.camera
    assert camera.covariance is not None
    focal, sigma = float(np.mean(camera.parameters[:2])), float(np.sqrt(np.diag(camera.covariance)[:2]).max())
    out = [
        KeyNumber("reprojection", f"{found.rms_px:.3f} px", f"{found.held_out_rms_px:.3f} px for pictures held out"),
        KeyNumber(
            "projection",
            f"± {number_text(meaning.projection.median, 2)} px",
            f"worst {number_text(meaning.projection.worst, 2)} px",
        ),
        KeyNumber("focal length", f"{with_sigma(focal, sigma)} px", f"± {number_text(100 * sigma / focal, 2)} %"),
        KeyNumber("coverage", f"{100 * meaning.coverage.share:.0f} %", "of the picture's cells hold corners"),
        KeyNumber("largest tilt", f"{np.degrees(found.tilt):.0f} deg", "between two boards"),
    ]
    if result.arm is not None:
        arm = result.arm
        angle = number_text(float(np.degrees(arm.worst_alpha)), 2)
        out.append(KeyNumber("joint angle", f"± {angle} deg", f"worst joint, arm {number_text(arm.distance, 2)} m away"))
    return out


def parameter_rows(found: Calibration) -> list[tuple[str, ...]]:
    """Name, value with the reported sigma, sigma of least squares, of the jackknife, OpenCV's value, unit."""
    assert found.camera.covariance is not None
    reported = np.sqrt(np.diag(found.camera.covariance))
    out = []
    for k, (name, value) in enumerate(zip(lens.PARAMETER_NAMES, found.camera.parameters.tolist(), strict=True)):
        unit = "px" if name in ("fx", "fy", "cx", "cy") else ""
        if name in found.free:
            text = with_sigma(value, float(reported[k]))
            sigmas = [number_text(float(s[k]), 2) for s in (found.sigma_least_squares, found.sigma_jackknife)]
        else:
            text, sigmas = f"{number_text(value)} (held fixed)", ["–", "–"]
        beside = "–" if found.cross_check is None else number_text(float(found.cross_check.parameters[k]))
        out.append((name, text, *sigmas, beside, unit))
    return out


def model_rows(found: Calibration) -> list[tuple[str, ...]]:
    """Lens, board, numbers estimated, focal length, errors, and whether it was taken; simplest first."""
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
        for c in found.candidates
    ]


def shape_in_words(found: Calibration) -> str:
    """What the chosen board's shape is."""
    if found.board.model.name == "rigid":
        return "The board is taken as flat and printed as described: nothing else predicts pictures held out better."
    bow = 1e3 * found.board.bow
    return (
        f"The board is estimated along with the camera ({found.board.model.name}): it bows by {number_text(float(bow[0]), 2)} mm "
        f"along x and {number_text(float(bow[1]), 2)} mm along y. Believed flat, it would have bent the lens."
    )


def picture_rows(result: CalibrationResult) -> list[tuple[str, ...]]:
    """Picture, its errors, how the board stood, and why it was left out."""
    found, covered = result.calibration, result.meaning.coverage
    at = {view.name: k for k, view in enumerate(found.views)}
    out = []
    for picture in found.pictures:
        k = at.get(picture.name)
        stood = (
            ("–", "–")
            if k is None
            else (f"{np.degrees(covered.tilts[k]):.0f}", f"{number_text(float(covered.distances[k]), 3)}")
        )
        rms = ["–" if value is None else f"{value:.3f}" for value in (picture.rms_px, picture.held_out_rms_px)]
        out.append((picture.name, *rms, *stood, "used" if picture.used else f"left out: {picture.why}"))
    return out


def arm_rows(arm: ArmSigma) -> list[tuple[str, ...]]:
    """Sigma of each joint's angle at 0 and at +-30 degrees, and of the motion from straight to there, deg."""
    return [
        (f"joint {i + 1}", *(number_text(float(s), 2) for s in np.degrees([*arm.alpha[:, i], *arm.bend[:, i]])))
        for i in range(arm.alpha.shape[1])
    ]
