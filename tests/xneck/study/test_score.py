"""A diagnosis against the truth: each rule on records made by hand."""

from dataclasses import replace
from typing import Any

import pytest

from samples.generator.hidden.experiment import CATALOGUE
from xneck.study.expected import expected
from xneck.study.score import Score, score_case
from xneck.study.summary import summary_tables

TRUTH: dict[str, Any] = {"k": [10e3, 9e3, 8e3, 5e3]}
DRUM = {"effect": "drum_radius", "where": "motor 3", "parameters": {"factor": 1.04}}
TILT = {"effect": "base_tilt", "where": "all", "parameters": {"tilt": 0.05}}
COGGING = {"effect": "cogging", "where": "all", "parameters": {"force1": 2.0}}


def cause(
    effect: str, where: str = "all", *parameters: tuple[str, int | None, float, float], alike: Any = ()
) -> dict[str, Any]:
    numbers = [{"name": n, "index": i, "value": v, "sigma": s} for n, i, v, s in parameters]
    return {"effect": effect, "where": where, "parameters": numbers, "indistinguishable_from": list(alike)}


def scored(
    hidden: list[dict[str, Any]], verdict: str, *causes: dict[str, Any], size: float = 1.0, name: str = "a"
) -> Score:
    gains = [
        {"unit": "N", "before": 4.0, "after": 1.5, "noise_floor": 1.0},
        {"unit": "N m", "before": 6.0, "after": 2.4, "noise_floor": 2.0},
        {"unit": "rad", "before": 9.0, "after": 9.0, "noise_floor": 1.0},  # simulated angles are no equation
    ]
    return score_case(
        {
            "name": name,
            "case": {"manner": "rich", "size": size},
            "truth": TRUTH | {"hidden": hidden},
            "diagnosis": {"verdict": verdict, "causes": list(causes), "gains": gains},
        }
    )


FOUND = cause("drum_radius", "motor 3", ("rd", 3, 0.043, 0.002))


def test_what_was_hidden_and_named_is_right() -> None:
    s = scored([DRUM], "cause", FOUND)
    (seen,) = s.sightings
    assert (s.said, s.right, s.detected, s.false) == ("drum_radius", True, True, ())
    assert (seen.first, seen.named, seen.listed, seen.alone, seen.place) == (True, True, True, True, True)
    assert seen.numbers[0].z == pytest.approx(1.5)
    assert seen.numbers[0].within
    assert (s.ratio_before, s.ratio) == (4.0, 1.5)


@pytest.mark.parametrize(
    ("causes", "first", "named", "listed", "alone", "place", "right"),
    [
        ([cause("drum_radius", "all")], True, True, True, True, False, True),
        ([cause("drum_radius", "motor 3", alike=["backlash"])], True, True, True, False, True, True),
        ([cause("marker_offset", alike=["drum_radius"])], False, False, True, False, None, False),
        ([cause("marker_offset")], False, False, False, False, None, False),
        ([cause("marker_offset"), FOUND], False, True, True, False, True, False),
        ([FOUND, cause("marker_offset")], True, True, True, False, True, False),
        ([], False, False, False, False, None, False),
    ],
)
def test_each_way_to_be_wrong_is_told(
    causes: list[dict[str, Any]], first: bool, named: bool, listed: bool, alone: bool, place: bool | None, right: bool
) -> None:
    s = scored([DRUM], "ambiguous", *causes)
    (seen,) = s.sightings
    assert (seen.first, seen.named, seen.listed, seen.alone, seen.place) == (first, named, listed, alone, place)
    assert s.right == right


def test_a_number_further_off_than_three_sigma_is_wrong() -> None:
    off = scored([DRUM], "cause", cause("drum_radius", "motor 3", ("rd", 3, 0.043, 0.0009)))
    assert not off.sightings[0].numbers[0].within
    other = scored([DRUM], "cause", cause("drum_radius", "motor 2", ("rd", 2, 0.04, 0.001)))
    assert other.sightings[0].numbers == ()


def test_a_cause_is_false_where_nothing_hidden_could_be_meant() -> None:
    assert scored([DRUM], "ambiguous", FOUND, cause("clock_offset")).false == ("clock_offset",)
    assert scored([DRUM], "ambiguous", cause("clock_offset", alike=["drum_radius"])).false == ()


@pytest.mark.parametrize(
    ("hidden", "verdict", "right", "detected"),
    [
        ([], "consistent", True, False),
        ([], "insufficient", True, False),
        ([], "unknown", False, True),
        ([], "cause", False, True),
        ([COGGING], "unknown", True, True),
        ([COGGING], "consistent", False, False),
        ([COGGING], "cause", False, True),
        ([DRUM], "unknown", False, True),
        ([DRUM], "consistent", False, False),
        # too many explain it: what is listed is not said
        ([DRUM], "insufficient", False, False),
    ],
)
def test_verdicts(hidden: list[dict[str, Any]], verdict: str, right: bool, detected: bool) -> None:
    causes = [cause("drum_radius")] if verdict in ("cause", "insufficient") and hidden != [DRUM] else []
    causes = [FOUND] if hidden == [DRUM] and verdict == "insufficient" else causes
    s = scored(hidden, verdict, *causes)
    assert (s.right, s.detected) == (right, detected)
    assert s.said == ("drum_radius" if verdict == "cause" else verdict)
    assert not any(x.named for x in s.sightings)


def test_an_effect_of_no_size_is_nothing_hidden() -> None:
    assert scored([DRUM], "consistent", size=0.0).right
    assert scored([DRUM], "consistent", size=0.0).what == "none"


def test_two_at_once_are_right_where_both_are_named_in_any_order() -> None:
    both = scored([TILT, DRUM], "cause", FOUND, cause("base_tilt"))
    assert both.right
    assert [s.first for s in both.sightings] == [False, True]
    assert all(s.alone for s in both.sightings)
    assert not scored([TILT, DRUM], "cause", FOUND).right


def test_what_is_refused_is_neither_right_nor_detected() -> None:
    refused = {
        "name": "a",
        "case": {"manner": "rich", "size": 1.0},
        "truth": TRUTH | {"hidden": []},
        "refused": "no motion",
    }
    s = score_case(refused)
    assert (s.said, s.right, s.detected, s.ratio) == ("refused", False, False, None)


def test_creep_in_line_is_creep_beside() -> None:
    """A spring k in line with a Kelvin element of compliance share/k: immediate and lasting stiffness, and their time."""
    own = {"effect": "cable_creep", "where": "all", "parameters": {"share": 0.25, "tau": 5.0}}
    numbers = expected(own, TRUTH)
    for j, k in enumerate(TRUTH["k"]):
        assert k - numbers["km", j + 1] == pytest.approx(1 / (1 / k + 0.25 / k))
    assert numbers["tau", None] == pytest.approx(4.0)


def test_cubic_hardening_is_the_power_three() -> None:
    own = {"effect": "cable_hardening", "where": "all", "parameters": {"k31": 2e7, "k32": 1e7}}
    numbers = expected(own, TRUTH)
    x = 2e-3
    assert numbers["k2", 1] * 5e-3**2 * (x / 5e-3) ** numbers["nh", None] == pytest.approx(2e7 * x**3)
    assert expected({**own, "parameters": {"growth1": 80.0}}, TRUTH) == {}


def test_tables_count() -> None:
    scores = [
        scored([], "consistent"),
        scored([], "cause", FOUND),
        scored([DRUM], "cause", FOUND),
        scored([DRUM], "ambiguous", cause("marker_offset", alike=["drum_radius"])),
        scored([COGGING], "unknown"),
        scored([TILT, DRUM], "cause", FOUND),
    ]
    made = {table.title: table for table in summary_tables(scores, [*CATALOGUE, "cogging"])}
    confusion, found, alarms, pairs = made.values()
    assert [row[0].split()[-1] for row in confusion.rows] == ["none", "drum_radius", "cogging"]
    records = confusion.as_json()["rows"]
    drum, marker = (str([*CATALOGUE].index(name) + 1) for name in ("drum_radius", "marker_offset"))
    assert (records[0]["consistent"], records[0][drum]) == ("1", "1")
    assert (records[1][drum], records[1][marker], records[1]["consistent"]) == ("1", "1", ".")
    assert records[2]["unknown"] == "1"
    (row,) = found.as_json()["rows"]
    assert (row["cases"], row["named first"], row["in the set"], row["alone"]) == ("2", "1/2", "2/2", "1/2")
    assert (row["right place"], row["within 3 sigma"], row["rms z"]) == ("1/1", "1/1", "1.5")
    assert [(row["hidden"], row["a cause named"], row["unknown"]) for row in alarms.as_json()["rows"]] == [
        ("none", "1/2", "0/2"),
        ("cogging", "0/1", "1/1"),
    ]
    assert "All named: 0/1" in pairs.note
    assert "one or more named: 1/1" in pairs.note


def test_detection_is_counted_by_size_where_sizes_differ() -> None:
    said = {0.1: "consistent", 0.2: "consistent", 0.3: "unknown", 0.4: "consistent", 0.5: "unknown", 0.6: "unknown"}
    scores = [replace(scored([DRUM], verdict), size=size) for size, verdict in said.items()]
    scores += [replace(scored([DRUM], "cause", FOUND), size=size) for size in (0.7, 0.8)]
    made = {table.title: table for table in summary_tables(scores, [*CATALOGUE])}
    (row,) = made["Detection against size"].rows
    assert row == ("drum_radius", "0 0 2", "0 1 2", "0 2 2", "2 2 2")
    assert "Detection against size" not in {table.title for table in summary_tables(scores[-1:], [*CATALOGUE])}
