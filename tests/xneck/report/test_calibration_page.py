"""The page of a calibration: whole, from nothing outside, readable on a phone, and saying what the numbers say."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Page

from calibration.board import Chessboard
from calibration.calibration_quality import assess_quality, corner_errors
from calibration.estimation import calibrate
from calibration.observations import LeftOut, Observations
from tests.calibration.truth import CAMERA, SIZE, project, synthetic_views
from tests.html_page import Elements, check_alone, check_figures, check_print, label_faults, look
from vision.linkage.arm_sigma import arm_sigma, two_link_arm
from xneck.report.calibration_page import CalibrationResult, calibration_sentence, write_calibration_report
from xneck_foundation.provenance import note_inputs, provenance

NASTY = "<script>alert(1)</script>"
SECTIONS = ("sigma", "next", "coverage", "residuals", "parameters", "models", "pictures", "inputs")
BOARD = Chessboard(kind="chessboard", columns=8, rows=6, square=0.025)


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> CalibrationResult:
    board = tmp_path_factory.mktemp("inputs") / "board.yaml"
    board.write_text("{}")
    views = synthetic_views(np.random.default_rng(0), BOARD.corners, count=40)
    away = [v for v in views if not np.any((v.image_points[:, 0] < 214) & (v.image_points[:, 1] < 161))][:10]
    left_out = (LeftOut(f"{NASTY}.png", "the board was not found"),)
    found = calibrate(Observations(tuple(away), left_out, SIZE))
    arm = arm_sigma(found.camera, two_link_arm(0.18), 0.5)
    return CalibrationResult(
        name=NASTY,
        board=BOARD.title,
        calibration=found,
        quality=assess_quality(found),
        arm=arm,
        provenance=provenance(note_inputs({"board": board})),
    )


@pytest.fixture(scope="module")
def report(result: CalibrationResult, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("report") / "a report.html"
    write_calibration_report(result, path)
    return path


@pytest.fixture(scope="module")
def elements(report: Path) -> Elements:
    return Elements(report.read_text(encoding="utf-8"))


def test_every_section_is_there_and_linked(elements: Elements) -> None:
    assert [attributes["id"] for tag, attributes in elements.tags if tag == "section"] == list(SECTIONS)
    assert [attributes["href"] for tag, attributes in elements.tags if tag == "a"] == [f"#{name}" for name in SECTIONS]
    assert sum(attributes.get("class") == "plot" for _, attributes in elements.tags) == 2 + 3 + 2 + 2


def test_nothing_refers_to_the_outside_and_ids_are_unique(report: Path, elements: Elements) -> None:
    check_alone(report, elements)
    assert report.stat().st_size < 2_000_000


def test_every_figure_is_there_as_numbers(report: Path, elements: Elements) -> None:
    panels = check_figures(report, elements)
    shades = next(
        mark for mark in panels["sigma of projection over the picture, px"][0]["marks"] if mark["kind"] == "shades"
    )
    assert np.array(shades["sigma"], dtype=float).shape == (len(shades["y"]), len(shades["x"]))
    over = next(axes for words, axes in panels.items() if words.startswith("errors of the corners over"))
    (arrows,) = [mark for mark in over[0]["marks"] if mark["kind"] == "arrows"]
    assert np.hypot(arrows["dx"], arrows["dy"]).max() < 1


def test_names_stay_text(report: Path, elements: Elements) -> None:
    assert NASTY not in report.read_text(encoding="utf-8")
    assert elements.text.count(NASTY) == 3  # title, heading, picture


def test_the_same_calibration_gives_the_same_bytes(result: CalibrationResult, report: Path, tmp_path: Path) -> None:
    write_calibration_report(result, tmp_path / "again.html")
    assert (tmp_path / "again.html").read_bytes() == report.read_bytes()


def test_what_is_missing_reaches_the_first_sentence_and_the_advice(
    result: CalibrationResult, elements: Elements
) -> None:
    assert "To mend: upper left missing" in calibration_sentence(result)
    assert ("p", {"class": "verdict inconsistent"}) in elements.tags
    assert "Hold the board in the upper left of the picture" in elements.text
    good = replace(result.quality, coverage=replace(result.quality.coverage, wants=()))
    assert "To mend" not in calibration_sentence(replace(result, quality=good))


def test_without_an_arm_it_says_how_to_name_one(result: CalibrationResult, tmp_path: Path) -> None:
    write_calibration_report(replace(result, arm=None), tmp_path / "less.html")
    page = Elements((tmp_path / "less.html").read_text(encoding="utf-8"))
    assert "--neck neck.yaml, or --link and --distance" in page.text
    assert "joint angle" not in calibration_sentence(replace(result, arm=None))


def test_errors_are_seen_less_predicted(result: CalibrationResult) -> None:
    """Predicted by the tests' own camera; true corners have noise of 0.1 px, and the fit leaves about that."""
    pixels, errors = corner_errors(result.calibration)
    view, poses = result.calibration.views[0], result.calibration.poses
    own = project(view.object_points, poses.R[0], poses.t[0], result.calibration.camera.parameters)
    np.testing.assert_allclose(errors[: len(own)], view.image_points - own, atol=1e-9)
    assert len(pixels) == result.calibration.corners
    assert np.sqrt(np.mean(np.sum(errors**2, axis=1))) == pytest.approx(result.calibration.rms_px)
    assert abs(result.calibration.camera.parameters[0] - CAMERA[0]) < 10


@pytest.mark.parametrize("width", [360, 1280])
def test_seen_in_chromium(report: Path, browser_page: Page, width: int) -> None:
    look(browser_page, report, width)
    assert browser_page.title() == f"{NASTY}: xneck calibration"


def test_no_label_leaves_its_figure(report: Path, browser_page: Page) -> None:
    faults = label_faults(browser_page, report)
    assert not faults, "\n".join(faults)


def test_printed_nothing_is_cut_off(report: Path, browser_page: Page) -> None:
    check_print(browser_page, report)
