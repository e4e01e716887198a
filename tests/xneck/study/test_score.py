"""A diagnosis against the truth: each rule on records made by hand."""

from typing import Any

import pytest

from tests.xneck.study.records import COGGING, DRUM, FOUND, TILT, TRUTH, cause, scored
from xneck.study.score import score_case


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
