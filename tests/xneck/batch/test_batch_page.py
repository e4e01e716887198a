"""The summary page of a batch says what summary.json says, and leads to the reports."""

import json
from pathlib import Path
from urllib.parse import unquote

import pytest
from playwright.sync_api import Page

from tests.command import Ran
from tests.html_page import Elements, check_print, look, watch
from tests.xneck.batch.recordings import NASTY
from xneck.report.number_text import number_text, with_sigma


def test_the_page_says_what_summary_json_says(batch: tuple[Path, Ran]) -> None:
    out, _ = batch
    text = (out / "summary.html").read_text(encoding="utf-8")
    assert NASTY not in text
    elements = Elements(text)
    links = [str(attributes["href"]) for tag, attributes in elements.tags if tag == "a"]
    ids = {attributes.get("id") for _, attributes in elements.tags}
    assert {link[1:] for link in links if link.startswith("#")} == {"recordings", "failed", "lost", "parameters"} <= ids
    reports = [link for link in links if not link.startswith("#")]
    assert [(out / unquote(link)).resolve() for link in reports] == [
        out / name / "report.html" for name in (NASTY, "cut")
    ]
    assert all((out / unquote(link)).is_file() for link in reports)
    assert NASTY in elements.text
    for name, row in json.loads((out / "summary.json").read_text())["recordings"].items():
        if row["failure"]:
            assert f"{name}: {row['failure']}" in elements.text
            continue
        assert f"{row['frames_used']} of {row['frames']}" in elements.text
        assert f"{number_text(row['offset_s'], 5)} s ± " in elements.text
        for p in row["parameters"]:
            assert not p["identified"] or with_sigma(p["value"], p["sigma"]) in elements.text


@pytest.mark.parametrize("width", [360, 1280])
def test_a_browser_shows_it(browser_page: Page, batch: tuple[Path, Ran], width: int) -> None:
    look(browser_page, batch[0] / "summary.html", width)


def test_printed_nothing_is_cut_off(browser_page: Page, batch: tuple[Path, Ran]) -> None:
    check_print(browser_page, batch[0] / "summary.html")


def test_from_the_summary_to_each_report_and_back(browser_page: Page, batch: tuple[Path, Ran]) -> None:
    summary, watched = batch[0] / "summary.html", watch(browser_page)
    reports = {name: batch[0] / name / "report.html" for name in (NASTY, "cut")}
    browser_page.goto(summary.as_uri())
    for name, report in reports.items():
        browser_page.get_by_role("link", name=name, exact=True).click()
        browser_page.wait_for_url(report.as_uri())
        assert browser_page.title() == f"{name}: xneck report"
        assert browser_page.locator("h1").inner_text() == name
        browser_page.go_back()
        browser_page.wait_for_url(summary.as_uri())
    watched.check([summary, *reports.values()])
