"""The report: everything in one page, nothing from outside, seen in a real browser."""

import base64
import re
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from playwright.sync_api import Page

from calibration.estimation import Calibration, calibrate
from calibration.observations import LeftOut, Observations
from identification.dataset.dataset import DataSet
from identification.dataset.series import Series, numbered_columns
from identification.estimates import LAWS_BY_ELASTIC_MODEL, estimate
from identification.fasquelle.method import fasquelle_identification
from identification.fasquelle.reconstruction import reconstruct
from identification.model_file import model_of
from identification.simulation.channels import Channel
from identification.simulation.simulated_recording import SimulatedRecording
from mechanism.description import read_neck
from synchronisation.angles import Angles, read_angles
from synchronisation.check.explained_elongation import explain
from synchronisation.encoder_log import read_log
from synchronisation.synchronise import synchronise
from tests.calibration.truth import synthetic_views
from tests.html_page import Elements, check_alone, check_figures, check_print, label_faults, look
from tests.paths import SAMPLES
from vision.extract import Extraction
from vision.linkage.linkage_fit import LinkageFit
from vision.shutter import Shutter
from xneck.recording.pipeline import RecordingResult
from xneck.recording.recording_folder import Recording
from xneck.report import fasquelle_published
from xneck.report.clock_alignment import clock_alignment
from xneck.report.recording_page import write_recording_report
from xneck.report.annotated_frames import frame_cuts
from xneck.report.style import decimated
from xneck.report.recording_tables import camera_rows, fasquelle_table
from xneck.report.number_text import number_text, file_size, with_sigma
from xneck.report.words import join_words
from xneck_foundation.provenance import provenance

SAMPLE = SAMPLES / "held_out"
SECONDS = 8.0
NASTY = "<script>alert(1)</script>"
SECTIONS = (
    "inputs", "camera", "frames", "angles", "clocks", "elongations", "parameters", "couples", "tensions", "simulation",
)  # fmt: skip
LIMIT_BYTES = 4_000_000


def sample_start(folder: Path) -> tuple[DataSet, Angles]:
    """The first seconds of the held-out sample, with a gap of ten frames and a file name that tries to be markup."""
    neck = read_neck(SAMPLE / "neck.yaml")
    angles = read_angles(SAMPLE / "angles.csv", neck.N)
    kept = angles.time < SECONDS
    alpha, sigma = angles.alpha[kept].copy(), angles.sigma[kept].copy()
    alpha[100:110] = sigma[100:110] = np.nan
    notes = {"markers": [{"id": 7, "seen_share": 0.9, "duplicates": 1}], "foreign_ids": [3]}
    angles = Angles(angles.time[kept], alpha, sigma, notes)
    # a slash cannot be in a file name, but it can be in the provenance of a data set that somebody else made
    (folder / "log").write_bytes(b"log")
    origin = provenance({"log": folder / "log"})
    origin["inputs"]["log"]["file"] = NASTY + ".mcap"
    yaml = (SAMPLE / "neck.yaml").read_text() + f"# {NASTY}\n"
    return synchronise(neck, yaml, angles, read_log(SAMPLE / "log.mcap", neck), origin), angles


def some_calibration() -> Calibration:
    x, y = np.meshgrid(np.arange(8) * 0.025, np.arange(5) * 0.025)
    corners = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    views = synthetic_views(np.random.default_rng(0), corners, count=8)
    return calibrate(Observations(tuple(views), (LeftOut(f"{NASTY}.png", "the board was not found"),), (1280, 720)))


def some_simulation(data: DataSet) -> SimulatedRecording:
    """As simulation gives it: windows of a second, that drift away from what was measured."""
    state, samples = data.state, 500
    kept = len(state) // samples * samples
    drift = 0.02 * np.tile(np.linspace(0, 1, samples), kept // samples)[:, None]
    columns: dict[str, np.ndarray] = {}
    for stem in ("alpha", "theta"):
        measured = state.matrix(stem)[:kept]
        columns |= numbered_columns(stem, measured + drift) | numbered_columns(stem, measured, "_measured")
    channels = tuple(Channel(name, 0.01, 0.005, "rad", 1.4) for name in columns if not name.endswith("_measured"))
    return SimulatedRecording(Series(state.time[:kept], columns), channels, 1.0, "f")


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> RecordingResult:
    folder = tmp_path_factory.mktemp("recording")
    data, angles = sample_start(folder)
    found = fasquelle_identification([data])
    calibration = some_calibration()
    frames, joints = angles.alpha.shape
    fit = LinkageFit(
        angles.alpha, np.zeros((frames, joints, joints)), np.zeros(3), np.zeros(3), np.zeros(6), 0.07, np.zeros(frames)
    )
    extraction = Extraction(angles, fit, np.zeros((frames, 4, 4, 2)), Series(angles.time, {}))
    rng = np.random.default_rng(1)
    picture = rng.integers(0, 255, (72, 128, 3), dtype=np.uint8).repeat(10, axis=0).repeat(10, axis=1)
    return RecordingResult(
        name=NASTY,
        recording=Recording(
            folder,
            folder / "recording.yaml",
            folder / "log",
            SAMPLE / "neck.yaml",
            None,
            None,
            None,
            (),
            None,
            Shutter(),
            None,
            False,
            None,
        ),
        camera=calibration.camera,
        calibration=calibration,
        extraction=extraction,
        pictures=((0, picture), (frames - 1, picture)),
        angles=angles,
        data=data,
        identification=found,
        estimates=estimate([data]),
        model=model_of(found.elastic[1].parameters, LAWS_BY_ELASTIC_MODEL[1], {}),
        simulated=some_simulation(data),
        simulation_refused=None,
    )


@pytest.fixture(scope="module")
def report(result: RecordingResult, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("report") / "a report ü.html"
    write_recording_report(result, path)
    return path


@pytest.fixture(scope="module")
def elements(report: Path) -> Elements:
    return Elements(report.read_text(encoding="utf-8"))


def test_every_section_is_there_and_linked(elements: Elements) -> None:
    ids = [attributes["id"] for tag, attributes in elements.tags if tag == "section"]
    links = [attributes["href"] for tag, attributes in elements.tags if tag == "a"]
    assert ids == list(SECTIONS)
    assert links == [f"#{name}" for name in SECTIONS]


def test_figures_are_inline_and_each_has_a_caption(elements: Elements) -> None:
    counts = Counter(tag for tag, _ in elements.tags)
    plots = sum(attributes.get("class") == "plot" for _, attributes in elements.tags)
    assert plots == 2 + 3 + 4 + 2 + 2 + 4 + 3 + 4 + 4 + 3
    assert counts["figcaption"] == counts["figure"] == 12
    assert counts["img"] == 2


def test_nothing_refers_to_the_outside_and_ids_are_unique(report: Path, elements: Elements) -> None:
    check_alone(report, elements)
    text = "".join(str(attributes.get("style", "")) for _, attributes in elements.tags) + elements.text
    assert not re.search(r"https?://|@import|url\((?!#)", text)


def test_every_figure_is_there_as_numbers(result: RecordingResult, report: Path, elements: Elements) -> None:
    """Drawn is what was computed: the state's angles to seven digits, the frames, the couples, the simulation with its breaks."""
    panels = check_figures(report, elements)
    above, below = panels["alpha of joint 2 over time"]
    marks = {mark["name"]: mark for mark in above["marks"]}
    state = result.data.state
    at = np.searchsorted(state.time, marks["state"]["x"])
    np.testing.assert_allclose(marks["state"]["x"], state.time[np.minimum(at, len(state) - 1)], atol=3e-3)
    alpha = np.degrees(np.interp(marks["state"]["x"], state.time, state.matrix("alpha")[:, 1]))
    np.testing.assert_allclose(marks["state"]["y"], alpha, atol=1e-4)
    assert (above["y"], below["y"], below["x"]) == ("alpha, deg", "frame − state", "time on the log's clock, s")
    assert {mark["name"] for mark in below["marks"]} == {"frame − state", "±2 σ of the state", "no angles"}
    found = reconstruct(result.data, result.identification)
    (couple,) = panels["couple on joint 1, measured and modelled"]
    measured = next(mark for mark in couple["marks"] if mark["name"] == "measured")
    np.testing.assert_allclose(measured["y"], found.couple_measured[:, 0], rtol=1e-6)
    simulated = panels["alpha of joint 1, simulated and measured"][1]["marks"][0]
    assert simulated["y"][0] == 0.0
    assert None in simulated["y"]


def test_names_stay_text(report: Path, elements: Elements) -> None:
    assert NASTY not in report.read_text(encoding="utf-8")
    assert elements.text.count(NASTY) == 5  # title, heading, file, neck.yaml, picture


def test_the_page_is_small(report: Path) -> None:
    assert report.stat().st_size < LIMIT_BYTES


def test_the_same_result_gives_the_same_bytes(result: RecordingResult, report: Path, tmp_path: Path) -> None:
    write_recording_report(result, tmp_path / "again.html")
    assert (tmp_path / "again.html").read_bytes() == report.read_bytes()


def test_what_does_not_apply_is_said(result: RecordingResult, tmp_path: Path) -> None:
    less = replace(
        result, camera=None, calibration=None, extraction=None, pictures=(), simulated=None, simulation_refused="no <b>"
    )
    write_recording_report(less, tmp_path / "less.html")
    page = Elements((tmp_path / "less.html").read_text(encoding="utf-8"))
    assert "No camera" in page.text
    assert "No video" in page.text
    assert "Not simulated: no <b>." in page.text


def test_frames_are_cut_to_where_the_markers_were(result: RecordingResult) -> None:
    assert result.extraction is not None
    corners = np.full(result.extraction.corners.shape, np.nan)
    corners[0, 0], corners[5, 1] = (300.0, 200.0), (500.0, 600.0)
    first, last = frame_cuts(replace(result, extraction=replace(result.extraction, corners=corners)))
    packed = np.frombuffer(base64.b64decode(first.uri.split(",")[1]), np.uint8)
    picture = cv2.imdecode(packed, cv2.IMREAD_COLOR)
    assert picture is not None
    assert picture.shape == (400 + 2 * 48, 200 + 2 * 48, 3)  # a margin of 0.12 of the longer side
    assert last.angles[0].startswith("alpha 1: ")
    assert last.angles[0].endswith(" deg")


def test_a_camera_that_was_read_is_told_from_one_that_was_calibrated(result: RecordingResult, tmp_path: Path) -> None:
    given = replace(result.recording, camera=tmp_path / "lab.yaml")
    write_recording_report(replace(result, calibration=None, recording=given), tmp_path / "read.html")
    text = Elements((tmp_path / "read.html").read_text(encoding="utf-8")).text
    assert result.calibration is not None
    held_out = f"{result.calibration.held_out_rms_px:.3f}"
    assert f"Read from lab.yaml: 1280 × 720 px, {held_out} px RMS for pictures held out" in text
    assert "Calibrated from" not in text


def test_the_seed_is_not_compared_with_another_arm(result: RecordingResult) -> None:
    fits = [result.identification.dry_and_viscous, result.identification.dry_only]
    assert len(fasquelle_table("", fits, fasquelle_published.TABLE_1, cables=4).rows[0][3]) == 2
    assert all(row[3] == () for row in fasquelle_table("", fits, fasquelle_published.TABLE_1, cables=3).rows)


def test_a_fault_reaches_the_first_sentence(result: RecordingResult, tmp_path: Path) -> None:
    fault = {"fault": "theta_sign", "where": "cable 2", "size": -1e-4, "unit": "m/N", "sigma": 1e-6}
    check: dict[str, Any] = {
        **result.data.check,
        "verdict": "inconsistent",
        "faults": [{**fault, "indistinguishable_from": ["swapped_cables"]}],
    }
    write_recording_report(replace(result, data=replace(result.data, check=check)), tmp_path / "fault.html")
    text = Elements((tmp_path / "fault.html").read_text(encoding="utf-8")).text
    assert "are inconsistent (theta sign at cable 2) over" in text
    assert "could as well be swapped_cables" in text


def test_couples_and_tensions_are_those_that_were_fitted(result: RecordingResult) -> None:
    """What the figures show leaves the residuals of the fits behind the tables, and the tensions of the identification."""
    found, identified = reconstruct(result.data, result.identification), result.identification
    for couple, fit in (
        (found.couple_dry, identified.dry_only),
        (found.couple_dry_and_viscous, identified.dry_and_viscous),
    ):
        np.testing.assert_allclose((found.couple_measured - couple).ravel(), fit.estimate.residuals, atol=1e-9)
    np.testing.assert_allclose(found.tension_from_force, identified.tension_from_force)
    for model, error in identified.tension_error.items():
        np.testing.assert_allclose(found.tension_error(model), error, atol=1e-9)


def test_the_clock_of_the_record_fits_best(result: RecordingResult) -> None:
    found = clock_alignment(result.data)
    best = found.shifts[np.argmin(np.sqrt(np.mean(found.rms**2, axis=1)))]
    assert abs(best) <= 0.003
    assert np.sqrt(np.mean(found.left**2)) < 1e-4


def test_elongations_are_explained_as_the_check_does(result: RecordingResult) -> None:
    found = explain(result.data.arm, result.data.state)
    rms = np.sqrt(np.mean((found.x - found.explained) ** 2, axis=0))
    np.testing.assert_allclose(rms, [cable["unexplained_rms"] for cable in result.data.check["cables"]], rtol=1e-6)


def test_decimation_keeps_every_peak() -> None:
    x = np.linspace(0, 1, 100_000)
    y = np.sin(40 * x)
    y[31_415] = 7.0
    thin_x, thin_y = decimated(x, y, points=1000)
    assert len(thin_x) <= 1002
    assert thin_y.max() == 7.0
    assert np.all(np.diff(thin_x) > 0)
    assert (thin_x[0], thin_x[-1]) == (0.0, 1.0)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (number_text(10454.2), "10\u2009454"),
        (number_text(-0.0468, 3), "−0.0468"),
        (number_text(1.5e-9, 2), "1.5 × 10⁻⁹"),
        (number_text(float("nan")), "not known"),
        (with_sigma(5.99954, 0.000177), "5.99954 ± 0.00018"),
        (with_sigma(812.3, 14.0), "812 ± 14"),
        (with_sigma(3.0, float("inf")), "3.000 ± not known"),
        (file_size(679310), "679 kB"),
        (join_words(["a", "b", "c"]), "a, b and c"),
    ],
)
def test_numbers_as_people_read_them(text: str, expected: str) -> None:
    assert text == expected


def test_a_lens_parameter_that_was_held_says_so(result: RecordingResult) -> None:
    assert result.calibration is not None
    rows = {name: value for name, value, _ in camera_rows(result.calibration.camera, result.calibration)}
    assert ("held fixed" in rows["k3"]) == ("k3" not in result.calibration.free)
    assert "±" in rows["fx"]


@pytest.mark.parametrize("width", [360, 1280])
def test_seen_in_chromium(report: Path, browser_page: Page, width: int) -> None:
    look(browser_page, report, width)
    assert browser_page.title() == f"{NASTY}: xneck report"
    assert browser_page.evaluate("[...document.images].map(i => i.complete && i.naturalWidth > 0)") == [True, True]


def test_no_label_leaves_its_figure(report: Path, browser_page: Page) -> None:
    faults = label_faults(browser_page, report)
    assert not faults, "\n".join(faults)


def test_printed_nothing_is_cut_off(report: Path, browser_page: Page) -> None:
    check_print(browser_page, report)
