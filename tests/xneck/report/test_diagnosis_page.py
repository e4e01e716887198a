"""The page of a diagnosis: whole, in the order in which a person asks, from nothing outside, and all of it in the record too."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Page

from diagnosis import record
from diagnosis.advice import advice
from diagnosis.diagnose import Diagnosis, diagnose
from diagnosis.look_alikes import Rival
from diagnosis.motion_questions import open_questions
from diagnosis.planned_motion import loss_alone
from samples.generator.hidden.experiment import hide
from tests.html_page import (
    Elements,
    check_alone,
    check_figures,
    check_print,
    label_faults,
    look,
    tables_wider_than_a_phone,
)
from tests.xneck.report.hidden_recordings import read_recordings
from xneck.report.diagnosis_page import DiagnosisResult, write_diagnosis_report
from xneck.report.diagnosis_text import diagnosis_sentence
from xneck_foundation.json_text import json_text
from xneck_foundation.provenance import note_inputs, provenance

NASTY = "<script>alert(1)</script>"
SECTIONS = ("picture", "numbers", "drawing", "else", "next", "details", "inputs")


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Diagnosis:
    """A load at the tip."""
    folder = tmp_path_factory.mktemp("hidden")
    hide(["tip_payload"], 7011, folder, seconds=(16.0, 10.0))
    fitted, held_out = read_recordings(folder)
    return diagnose([fitted], [held_out])


@pytest.fixture(scope="module")
def result(found: Diagnosis, tmp_path_factory: pytest.TempPathFactory) -> DiagnosisResult:
    file = tmp_path_factory.mktemp("inputs") / "monday.mcap"
    file.write_bytes(b"")
    return DiagnosisResult(NASTY, found, provenance(note_inputs({"dataset1": file})))


@pytest.fixture(scope="module")
def report(result: DiagnosisResult, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("report") / "a diagnosis.html"
    write_diagnosis_report(result, path)
    return path


@pytest.fixture(scope="module")
def elements(report: Path) -> Elements:
    return Elements(report.read_text(encoding="utf-8"))


def unnamed(found: Diagnosis, verdict: str, why: str) -> Diagnosis:
    """The same data with no cause named."""
    bare = replace(found.search, last=found.search.first, named=())
    return replace(found, verdict=verdict, why=why, search=bare, simulated_shares=())


def two_alike(found: Diagnosis) -> Diagnosis:
    """With actuator gain and offset beside the cause, as explaining as much."""
    ranked = {c.effect.name: c for c in found.search.ranking}
    (named,) = found.search.named
    alike = [ranked["actuator_gain"], ranked["actuator_offset"]]
    tied = (*named.tied[:1], *(Rival(c.effect, c.where, named.tied[0].surplus) for c in alike))
    search = replace(found.search, named=(replace(named, tied=tied),))
    return replace(found, verdict="ambiguous", why="several causes explain the data alike", search=search)


def test_sections_stand_in_the_order_in_which_a_person_asks(elements: Elements) -> None:
    assert [attributes["id"] for tag, attributes in elements.tags if tag == "section"] == list(SECTIONS)
    assert [attributes["href"] for tag, attributes in elements.tags if tag == "a"] == [f"#{name}" for name in SECTIONS]


def test_nothing_refers_to_the_outside_and_ids_are_unique(report: Path, elements: Elements) -> None:
    check_alone(report, elements)
    assert report.stat().st_size < 1_000_000


def test_every_figure_is_there_as_numbers(report: Path, elements: Elements) -> None:
    panels = check_figures(report, elements)
    (alike,) = panels["share of what each effect does that each other one could feign"][0]["marks"]
    assert np.array(alike["share"]).shape == (len(alike["y"]), len(alike["x"]))


def test_names_stay_text(report: Path, elements: Elements) -> None:
    assert NASTY not in report.read_text(encoding="utf-8")
    assert elements.text.count(NASTY) == 2  # title, heading


def test_the_same_diagnosis_gives_the_same_bytes(result: DiagnosisResult, report: Path, tmp_path: Path) -> None:
    write_diagnosis_report(result, tmp_path / "again.html")
    assert (tmp_path / "again.html").read_bytes() == report.read_bytes()


def test_the_sentence_says_what_where_how_much_and_what_it_gains(found: Diagnosis) -> None:
    assert found.verdict == "cause"
    assert re.match(
        r"The arm carries something at its tip \(m = [\d.]+ ± [\d.]+ kg\)\. On recordings that were not fitted, "
        r"the arm equations are off by [\d.]+ N m in place of [\d.]+ \(gain [\d.]+ ± [\d.]+; noise alone: [\d.]+\)\. "
        r"The simulated tip is off by [\d.]+ mm in place of [\d.]+\.$",
        diagnosis_sentence(found),
    )
    assert "none were given" in diagnosis_sentence(replace(found, gains=()))


def test_every_verdict_has_its_sentence_its_advice_and_its_page(
    found: Diagnosis, result: DiagnosisResult, tmp_path: Path
) -> None:
    unknown = unnamed(found, "unknown", "no cause that is known explains it")
    assert diagnosis_sentence(unknown).startswith("Something is wrong that no known cause explains: ")
    assert diagnosis_sentence(unnamed(found, "consistent", "")).startswith(
        "The simulation agrees with these recordings"
    )
    assert "cannot tell: too short" in diagnosis_sentence(unnamed(found, "insufficient", "too short"))
    alike = two_alike(found)
    assert "cannot tell which" in diagnosis_sentence(alike)
    commands = [step.command for step in advice(alike)]
    asked = "--for tip_payload --for actuator_gain --for actuator_offset"
    assert f"xneck design neck.yaml --model model.yaml {asked} --out motion.csv" in commands
    for d in (unknown, unnamed(found, "consistent", ""), unnamed(found, "insufficient", "too short"), alike):
        write_diagnosis_report(replace(result, diagnosis=d), tmp_path / "page.html")
        page = Elements((tmp_path / "page.html").read_text(encoding="utf-8"))
        assert ("extended model" in page.text) == bool(d.search.named)
        assert advice(d)


def test_what_a_diagnosis_leaves_open_is_asked_of_its_motion(found: Diagnosis) -> None:
    """Each of three that explain alike beside each other one, as large as the recordings show; nothing where it is settled."""
    assert not open_questions(found)
    asked = open_questions(two_alike(found))
    names = ("tip_payload", "actuator_gain", "actuator_offset")
    pairs = {(q.effect.name, q.beside.name) for q in asked if q.beside}
    assert pairs == {(a, b) for a in names for b in names if a != b}
    assert len(asked) == len(pairs)
    (named,) = found.search.named
    nothing_else = found.search.every_effect.with_zero_residual()
    for q in asked:
        (suspect,) = q.suspects
        if suspect.effect is not named.effect:
            assert loss_alone(nothing_else, suspect) == pytest.approx(named.gain, rel=0.1)
    untold = open_questions(unnamed(found, "insufficient", "too short"))
    assert {q.effect.name for q in untold} == set(found.detectability.invisible)


def test_what_figures_show_is_in_the_record(found: Diagnosis) -> None:
    said = json.loads(json_text(record.as_json(found)))
    signed, (course,) = said["signature"], found.signature.courses
    channels = {c["channel"]: c for c in said["channels"]}
    shown = [p for p in signed["patterns"] if p["channel"] == signed["picture"]["channel"]]
    assert signed["picture"]["against"] in {p["against"] for p in shown}
    for p in signed["patterns"]:
        assert len(p["at"]) == len(p["before"]) == len(p["after"]) == len(p["noise_rms"])
        # bins' RMS lie around their channel's, in which rows of jerked motors count for less: by a seventh at most
        rms = np.array([v for v in p["before_rms"] if v is not None])
        assert rms.min() <= 1.2 * channels[p["channel"]]["before"]
        assert channels[p["channel"]]["before"] <= 1.001 * rms.max()
    (over,) = signed["over_time"]
    assert len(over["from_s"]) == len(course.window_starts)
    assert np.array(said["isolability"]["feigned"]).shape == (len(said["isolability"]["effects"]),) * 2
    assert len(json_text(said)) < 400_000


@pytest.mark.parametrize("width", [360, 1280])
def test_seen_in_chromium(report: Path, browser_page: Page, width: int) -> None:
    look(browser_page, report, width)
    assert browser_page.title() == f"{NASTY}: xneck diagnosis"


def test_no_label_leaves_its_figure(report: Path, browser_page: Page) -> None:
    faults = label_faults(browser_page, report)
    assert not faults, "\n".join(faults)


def test_tables_fit_a_phone(report: Path, browser_page: Page) -> None:
    assert tables_wider_than_a_phone(browser_page, report) == []


def test_printed_nothing_is_cut_off(report: Path, browser_page: Page) -> None:
    check_print(browser_page, report)
