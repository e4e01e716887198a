"""The page of a recording: everything in one file, nothing from outside, seen in a real browser."""

import re
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from playwright.sync_api import Page

from identification.dataset.clock_record import log_time
from identification.fasquelle.reconstruction import reconstruct
from identification.simulation.channels import Channel
from tests.html_page import (
    ARRIVED,
    Elements,
    check_alone,
    check_figures,
    check_print,
    label_faults,
    look,
    tables_wider_than_a_phone,
)
from tests.xneck.report.sample_result import NASTY
from vision.overlay_video import MAX_FRAMES_PER_S
from xneck.recording.recording_result import RecordingResult
from xneck.report.recording_page import write_recording_report

SECTIONS = (
    "inputs", "camera", "frames", "angles", "clocks", "elongations", "parameters", "couples", "tensions", "simulation",
)  # fmt: skip
LIMIT_BYTES = 4_000_000


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
    found = reconstruct(result.data, result.fasquelle)
    (couple,) = panels["couple on joint 1, measured and modelled"]
    measured = next(mark for mark in couple["marks"] if mark["name"] == "measured")
    np.testing.assert_allclose(measured["y"], found.couple_measured[:, 0], rtol=1e-6)
    simulated = panels["alpha of joint 1, simulated and measured"][1]["marks"][0]
    assert simulated["y"][0] == 0.0
    assert None in simulated["y"]


def test_names_stay_text(report: Path, elements: Elements) -> None:
    assert NASTY not in report.read_text(encoding="utf-8")
    assert elements.text.count(NASTY) == 6  # title, heading, warning, file, neck.yaml, picture


def test_the_page_is_small(report: Path) -> None:
    assert report.stat().st_size < LIMIT_BYTES


def test_the_same_result_gives_the_same_bytes(result: RecordingResult, report: Path, tmp_path: Path) -> None:
    write_recording_report(result, tmp_path / "again.html")
    assert (tmp_path / "again.html").read_bytes() == report.read_bytes()


def test_what_does_not_apply_is_said(result: RecordingResult, tmp_path: Path) -> None:
    less = replace(result, video=None, drawn=None, simulated=None, simulation_refused="no <b>")
    write_recording_report(less, tmp_path / "less.html")
    page = Elements((tmp_path / "less.html").read_text(encoding="utf-8"))
    assert "No camera" in page.text
    assert "No video" in page.text
    assert "Not simulated: no <b>." in page.text


def test_a_camera_that_was_read_is_told_from_one_that_was_calibrated(result: RecordingResult, tmp_path: Path) -> None:
    assert result.video is not None
    assert result.video.calibration is not None
    recording = replace(result.recording, camera=tmp_path / "lab.yaml")
    video = replace(result.video, calibration=None)
    write_recording_report(replace(result, video=video, recording=recording), tmp_path / "read.html")
    text = Elements((tmp_path / "read.html").read_text(encoding="utf-8")).text
    held_out = f"{result.video.calibration.held_out_rms_px:.3f}"
    assert f"Read from lab.yaml: 1280 × 720 px, {held_out} px RMS for pictures held out" in text
    assert "Calibrated from" not in text


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


def test_a_model_that_does_not_explain_the_arm_is_said_first_with_what_to_type(
    result: RecordingResult, tmp_path: Path
) -> None:
    """At 101 times noise; at twice noise it is said to explain the arm, and nothing is to be typed."""
    assert result.simulated is not None
    for rms, explains in ((0.505, False), (0.01, True)):
        channels = (*result.simulated.channels[:-1], Channel("theta4", rms, 0.005, "rad", 1.7))
        page = tmp_path / "page.html"
        write_recording_report(replace(result, simulated=replace(result.simulated, channels=channels)), page)
        text = Elements(page.read_text(encoding="utf-8")).text
        assert ("The model does not explain this arm" in text) is not explains
        assert ("xneck diagnose dataset.mcap" in text) is not explains
        assert ("simulates the angle of motor 4 at 101 times noise" in text) is not explains
        assert ("The model explains this arm" in text) is explains


def test_of_several_recordings_the_page_leads_to_the_summary(result: RecordingResult, tmp_path: Path) -> None:
    write_recording_report(result, tmp_path / "page.html", "summary.html")
    links = [a["href"] for tag, a in Elements((tmp_path / "page.html").read_text(encoding="utf-8")).tags if tag == "a"]
    assert links[0] == "../summary.html"


@pytest.mark.parametrize("width", [360, 1280])
def test_seen_in_chromium(report: Path, browser_page: Page, width: int) -> None:
    look(browser_page, report, width)
    assert browser_page.title() == f"{NASTY}: xneck report"
    assert browser_page.evaluate("[...document.images].map(i => i.complete && i.naturalWidth > 0)") == [True, True]


@pytest.mark.parametrize(("motion", "way"), [("no-preference", "smooth"), ("reduce", "auto")])
def test_anchors_are_reached_smoothly_unless_less_motion_is_asked_for(
    report: Path, browser_page: Page, motion: Literal["no-preference", "reduce"], way: str
) -> None:
    browser_page.emulate_media(media="screen", reduced_motion=motion)
    browser_page.goto(report.as_uri())
    assert browser_page.evaluate("getComputedStyle(document.documentElement).scrollBehavior") == way
    link = browser_page.locator("nav a").last
    link.click()
    browser_page.wait_for_function(ARRIVED, arg=str(link.get_attribute("href")))


def test_a_click_zooms_and_a_cursor_stands_at_one_moment_in_all_figures_of_time(
    report: Path, browser_page: Page
) -> None:
    browser_page.goto(report.as_uri())
    first = browser_page.locator("svg.plot[data-time]").first
    first.hover()
    lines = browser_page.evaluate(
        """[...document.querySelectorAll('svg.plot[data-time]')].map(s => {
            const [l, r, t, b, begin, end] = s.dataset.time.split(' ').map(Number);
            const x = Number((s.querySelector('path.cursor').getAttribute('d') || 'MNaN').match(/M(\\S+)/)[1]);
            return begin + (x - l) / (r - l) * (end - begin); })"""
    )
    shown = float(browser_page.locator("output.cursor").inner_text().removesuffix(" s"))
    assert len(lines) > 10
    inside = [moment for moment in lines if moment is not None]
    np.testing.assert_allclose(inside, shown, atol=2e-3)
    whole = first.get_attribute("viewBox")
    first.click()
    assert first.get_attribute("viewBox") != whole
    browser_page.keyboard.press("Escape")
    assert first.get_attribute("viewBox") == whole


GREY = """() => { const v = document.querySelector('.film video'), c = document.createElement('canvas');
    c.width = v.videoWidth; c.height = v.videoHeight; const g = c.getContext('2d'); g.drawImage(v, 0, 0);
    return g.getImageData(c.width / 2, 4, 1, 1).data[0]; }"""
"""of the picture that the video shows, near its upper edge"""


def until(page: Page, holds: str) -> None:
    """Waits for it for at most 10 s; the page's policy forbids what a browser's own waiting needs."""
    for _ in range(200):
        if page.evaluate(holds):
            return
        page.wait_for_timeout(50)
    pytest.fail(f"never: {holds}")


def test_the_video_shows_the_moment_that_the_cursor_is_at(
    result: RecordingResult, report: Path, browser_page: Page
) -> None:
    """Frames of the made-up video grow brighter one by one: what is seen tells which one it is."""
    assert result.drawn is not None
    browser_page.set_viewport_size({"width": 1280, "height": 844})
    browser_page.goto(report.as_uri())
    frames = len(result.angles.time)
    time = log_time(result.data.clock, result.data.angles.time)
    plot = browser_page.locator("#angles svg.plot[data-time]").first
    plot.scroll_into_view_if_needed()
    for share in (0.3, 0.6, 0.9):
        box = plot.bounding_box()
        assert box is not None
        browser_page.mouse.move(box["x"] + share * box["width"], box["y"] + 40)
        until(browser_page, "!document.querySelector('.film video').seeking")
        shown = float(browser_page.locator("output.cursor").inner_text().removesuffix(" s"))
        browser_page.wait_for_timeout(200)
        seen = (browser_page.evaluate(GREY) - 16) * frames / 200
        number = np.searchsorted(time, shown)
        assert seen == pytest.approx(
            number, abs=8
        )  # what a browser makes of the encoder's colours is off by some levels
        at_s = time[0] + browser_page.evaluate("document.querySelector('.film video').currentTime")
        assert at_s == pytest.approx(shown, abs=1.5 / MAX_FRAMES_PER_S)


def test_the_video_comes_along_where_its_place_is_out_of_sight_and_goes_back(report: Path, browser_page: Page) -> None:
    browser_page.set_viewport_size({"width": 1280, "height": 844})
    browser_page.goto(report.as_uri())
    video = browser_page.locator(".film video")
    for section, docked in (("#simulation", True), ("#frames", False)):
        browser_page.locator(f"{section} svg.plot, {section} .film").first.scroll_into_view_if_needed()
        if docked:
            browser_page.locator(f"{section} svg.plot[data-time]").first.hover()
            box = video.bounding_box()
            assert box is not None
            assert box["y"] >= 0
            assert box["y"] + box["height"] <= 844
        else:
            browser_page.mouse.move(2, 2)
        assert ("docked" in (video.get_attribute("class") or "")) is docked


def test_while_the_video_plays_the_cursor_runs_along(report: Path, browser_page: Page) -> None:
    browser_page.goto(report.as_uri())
    browser_page.mouse.move(2, 2)
    browser_page.evaluate("document.querySelector('.film video').play()")
    moment = "parseFloat(document.querySelector('output.cursor').textContent) > "
    first = browser_page.locator(".film video").get_attribute("data-log-times")
    assert first is not None
    until(browser_page, moment + str(float(first.split()[0]) + 0.3))


def test_printed_or_without_a_camera_there_is_no_video(
    result: RecordingResult, report: Path, browser_page: Page, tmp_path: Path
) -> None:
    browser_page.emulate_media(media="print")
    browser_page.goto(report.as_uri())
    assert not browser_page.locator(".film").is_visible()
    browser_page.emulate_media(media="screen")
    write_recording_report(replace(result, video=None, drawn=None), tmp_path / "page.html")
    assert "<video" not in (tmp_path / "page.html").read_text(encoding="utf-8")


def test_no_label_leaves_its_figure(report: Path, browser_page: Page) -> None:
    faults = label_faults(browser_page, report)
    assert not faults, "\n".join(faults)


def test_tables_fit_a_phone(report: Path, browser_page: Page) -> None:
    assert tables_wider_than_a_phone(browser_page, report) == []


def test_printed_nothing_is_cut_off(report: Path, browser_page: Page) -> None:
    check_print(browser_page, report)
