"""What counts as undecided, and as settled."""

import pytest

from benchmarks.deciding_motions import LIMITS, POOR, SCENES, SEEDS, USUAL, cases, is_undecided, settles, table
from benchmarks.forward_arm_runs import Record
from benchmarks.tuned_seeds import TUNED_FORWARD_ARMS


def said(verdict: str, *sets: list[str]) -> Record:
    return {"verdict": verdict, "causes": [names[0] for names in sets], "sets": list(sets)}


def test_both_second_motions_are_as_long_and_none_of_the_seeds_was_set_on() -> None:
    assert POOR.seconds == USUAL.seconds
    assert LIMITS.speed == USUAL.motor_speed
    assert POOR.first_recording != USUAL.first_recording
    assert not set(SEEDS) & set(TUNED_FORWARD_ARMS)
    assert len(cases([1, 2])) == 2 * len(SCENES)


@pytest.mark.parametrize(
    ("scene", "after", "settled"),
    [
        ("rung1", said("consistent"), True),
        ("rung1", said("cause", ["base_tilt"]), False),
        ("rung1", said("insufficient"), False),
        ("rung2_base_tilt", said("cause", ["base_tilt"]), True),
        ("rung2_base_tilt", said("consistent"), False),
        ("rung2_base_tilt", said("ambiguous", ["base_tilt", "tip_payload"]), False),
        ("rung2_base_tilt", said("cause", ["base_tilt"], ["tip_payload"]), False),
        ("rung2_base_tilt", {"refused": "too short"}, False),
    ],
)
def test_settled_is_named_alone_or_consistent_with_nothing_hidden(scene: str, after: Record, settled: bool) -> None:
    assert settles({"scene": scene, "designed": after}, "designed") == settled


def test_only_undecided_cases_are_counted() -> None:
    alike = said("ambiguous", ["base_tilt", "tip_payload"])
    named, wrong = said("cause", ["base_tilt"]), said("cause", ["tip_payload"])
    scene = "rung2_base_tilt"
    records: list[Record] = [
        {"scene": scene, "poor": alike, "designed": named, "usual": wrong},
        {"scene": scene, "poor": alike, "designed": named, "usual": alike},
        {"scene": scene, "poor": named},
        {"scene": scene, "poor": {"refused": "nothing moves"}},
    ]
    assert [is_undecided(r) for r in records] == [True, True, False, False]
    (designed, by_design), (usual, as_usual) = table(records).rows
    assert (designed, usual) == ("designed motion", "usual motion")
    assert (by_design[:3], by_design[-1]) == ((4, 2, 2), 0)
    assert (as_usual[:3], as_usual[-1]) == ((4, 2, 0), 1)
