"""Every number of a diagnosis's page is the record's."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from diagnosis import record
from diagnosis.cause_picture import cause_pictures
from diagnosis.diagnose import Diagnosis, diagnose
from samples.generator.hidden.experiment import hide
from tests.html_page import Elements, Tables, read_number
from tests.xneck.report.hidden_recordings import read_recordings
from xneck.report.diagnosis_page import DiagnosisResult, write_diagnosis_report
from xneck.report.figures_file import figures_beside
from xneck_foundation.json_text import json_text
from xneck_foundation.provenance import note_inputs, provenance

Record = dict[str, Any]


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Diagnosis:
    """A load at the tip, and motors that rub the faster they turn."""
    folder = tmp_path_factory.mktemp("hidden")
    hide(["tip_payload", "viscous_friction"], 7012, folder, seconds=(16.0, 10.0))
    fitted, held_out = read_recordings(folder)
    return diagnose([fitted], [held_out])


@pytest.fixture(scope="module")
def said(found: Diagnosis) -> Record:
    return json.loads(json_text(record.as_json(found)))


@pytest.fixture(scope="module")
def report(found: Diagnosis, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("inputs") / "monday.mcap"
    file.write_bytes(b"")
    path = tmp_path_factory.mktemp("report") / "diagnosis.html"
    write_diagnosis_report(DiagnosisResult("both", found, provenance(note_inputs({"dataset1": file}))), path)
    return path


@pytest.fixture(scope="module")
def page(report: Path) -> str:
    return report.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def tables(page: str) -> dict[str, list[list[str]]]:
    return {heading: rows[1:] for heading, rows in Tables(page).under.items()}


def columns(rows: list[list[str]], *places: int) -> np.ndarray:
    return np.array([[read_number(row[place]) for place in places] for row in rows])


def assert_shown(shown: np.ndarray, true: Any, digits: float = 6e-3) -> None:
    """To the digits that a page shows: three, or two places of a ratio."""
    np.testing.assert_allclose(shown, np.array(true, dtype=float), rtol=digits, atol=6e-3 * digits)


def test_equations(tables: dict[str, list[list[str]]], said: Record) -> None:
    rows, channels = tables["What is left in each equation, where it was fitted (RMS)"], said["channels"]
    assert [row[0] for row in rows] == [c["channel"] for c in channels]
    assert_shown(
        columns(rows, 2, 3, 4, 5, 6),
        [
            (
                c["noise_floor"],
                c["before"],
                c["before"] / c["noise_floor"],
                c["after"],
                c["after"] / c["noise_floor"],
            )
            for c in channels
        ],
    )


def test_the_numbers_below_the_sentence(page: str, said: Record) -> None:
    text = Elements(page).text
    worst = max(said["channels"], key=lambda c: c["before"] / c["noise_floor"])
    before, after = (worst[key] / worst["noise_floor"] for key in ("before", "after"))
    three = [f"{ratio:.{max(0, 2 - int(np.floor(np.log10(ratio))))}f}" for ratio in (before, after)]
    assert f"{three[0]} times noise, now {three[1]}" in text
    assert f"{100 * said['explained']:.0f} %" in text


def test_causes(tables: dict[str, list[list[str]]], said: Record) -> None:
    rows, causes = tables["The numbers"], said["causes"]
    assert said["verdict"] == "cause"
    assert {c["effect"] for c in causes} == {"tip_payload", "viscous_friction"}
    numbers = [(p["value"], c["probability"]) for c in causes for p in c["parameters"]]
    assert_shown(columns(rows, 3)[:, 0], [value for value, _ in numbers], digits=0.05)
    assert_shown(columns(rows, 6)[:, 0], [100 * probability for _, probability in numbers])
    shares = [c["share"] for c in causes]
    assert_shown(
        columns(tables["What each cause does (RMS, where it does most)"], 2, 3, 4),
        [(s["motor_equation"], 1e3 * s["arm_equation"], np.degrees(s["simulated_joint_angle"])) for s in shares],
    )


def test_the_simulated_angles_tell_what_a_load_does(said: Record) -> None:
    """It moves the arm within half a second by more than its angles' noise; nothing moves it by more than it moved."""
    share = {c["effect"]: c["share"]["simulated_joint_angle"] for c in said["causes"]}
    assert np.radians(0.1) < share["tip_payload"] < np.radians(40)
    assert np.radians(0.01) < share["viscous_friction"] < np.radians(40)


def test_gains(tables: dict[str, list[list[str]]], said: Record) -> None:
    rows, gains = tables["On recordings that were not fitted (RMS)"], said["gains"]
    assert [row[0] for row in rows] == [g["measure"] for g in gains]
    shown = [np.degrees(1.0) if g["measure"] == "simulated joint angles" else 1.0 for g in gains]
    assert [row[1] for row in rows] == [g["unit"] if k == 1 else "deg" for g, k in zip(gains, shown, strict=True)]
    assert_shown(
        columns(rows, 2, 3, 4),
        [(k * g["noise_floor"], k * g["before"], k * g["after"]) for g, k in zip(gains, shown, strict=True)],
    )
    for row, g, k in zip(rows, gains, shown, strict=True):
        assert abs(read_number(row[5]) - k * (g["before"] - g["after"])) <= 0.06 * k * g["gain_sigma"]
    held = max(gains, key=lambda g: g["before"] / g["noise_floor"])
    assert said["gain"] == held


def test_how_far_the_arm_is_off_is_drawn_beside_it(report: Path, said: Record) -> None:
    """At every joint in degrees and at the tip in mm; the joints' are those of the gain, and what was found takes most of it."""
    figures = json.loads(figures_beside(report).read_text(encoding="utf-8"))["figures"]
    (panel,) = (p for f in figures for p in f["panels"] if p["panel"].startswith("the arm, and how far it is off"))
    shown = {mark["name"]: mark["x"] for axes in panel["axes"] for mark in axes["marks"]}
    error = said["arm_error"]
    assert shown["tip, mm"] == pytest.approx([1e3 * error["tip"]["before_m"], 1e3 * error["tip"]["after_m"]])
    for k, joint in enumerate(error["joints"], start=1):
        expected = np.degrees([joint["before_rad"], joint["after_rad"]])
        assert shown[f"joint {k}, °"] == pytest.approx(expected.tolist())
    gain = {g["measure"]: g for g in said["gains"]}["simulated joint angles"]
    for key in ("before", "after", "noise_floor"):
        rms = np.sqrt(np.mean([joint[f"{key}_rad"] ** 2 for joint in error["joints"]]))
        assert rms == pytest.approx(gain[key])
    assert error["tip"]["after_m"] < error["tip"]["before_m"] / 3
    callouts = [name for name in shown if re.match(r"\d\u2002", name)]
    assert len(callouts) == len(said["causes"])


def test_the_drawing(tables: dict[str, list[list[str]]], said: Record) -> None:
    rows = tables.get("What the recordings say about the drawing", [])
    for row, number in zip(rows, said["drawing"], strict=False):
        scale = 1e3 if number["unit"] == "rad" else 100.0
        assert row[0] == number["number"]
        assert read_number(row[3]) == pytest.approx(scale * number["tolerance"], rel=0.06)
        assert read_number(row[4]) == pytest.approx(abs(number["value"]) / number["tolerance"], abs=0.051)


def test_what_else_it_could_be(tables: dict[str, list[list[str]]], said: Record) -> None:
    rows = tables["What else it could be"]
    assert_shown(columns(rows, 3)[:, 0] / 100, [c["explains"] for c in said["considered"][: len(rows)]], digits=0.09)


def test_conditions(tables: dict[str, list[list[str]]], said: Record) -> None:
    rows = tables["Of what stands above noise, how much each condition explains"]
    channels = [c["channel"] for c in said["channels"]]
    by_place = {(p["channel"], p["against"]): p["explains"] for p in said["signature"]["patterns"]}
    for row in rows:
        for channel, cell in zip(channels, row[1:], strict=True):
            assert (cell == "") == ((channel, row[0]) not in by_place)
            if cell:
                assert read_number(cell) == pytest.approx(100 * by_place[channel, row[0]], abs=0.51)


def test_every_cause_has_the_picture_that_the_record_names(page: str, said: Record) -> None:
    shown = re.findall(r'aria-label="what is left at ([^"]*) without the cause, against ([^"]*), and', page)
    assert shown[: len(said["causes"])] == [(c["picture"]["channel"], c["picture"]["against"]) for c in said["causes"]]
    against = {c["effect"]: c["picture"]["against"] for c in said["causes"]}
    assert against == {"tip_payload": "lean of the tip", "viscous_friction": "speed"}


def test_what_is_left_without_a_cause_is_what_it_does(found: Diagnosis) -> None:
    """In every picture the bins lie at the curve as fitted, far nearer than at nothing: other causes are out of it."""
    for picture in cause_pictures(found.search.last):
        assert np.max(np.abs(picture.done)) > 2 * np.median(picture.noise)
        assert np.std(picture.left - picture.done) < 0.3 * np.sqrt(np.mean(picture.done**2))
