"""Where an effect sits, two effects at once, and motions that show little: from files to the verdict.

Seeds were chosen before they were run.
"""

from pathlib import Path

import pytest

from tests.diagnosis.test_diagnose import diagnosed

pytestmark = pytest.mark.slow


def test_a_marker_that_sits_askew_is_named_where_it_was_hidden(tmp_path: Path) -> None:
    """Or in a set with it that nothing tells apart."""
    found, truth = diagnosed(tmp_path, ["marker_offset"], 7013)
    (hidden,) = truth["hidden"]
    (cause,) = found["causes"]
    assert "marker_offset" in (cause["effect"], *cause["indistinguishable_from"])
    if cause["effect"] == "marker_offset":
        assert cause["where"] == hidden["where"]


@pytest.fixture(scope="module")
def named_of_two(tmp_path_factory: pytest.TempPathFactory) -> list[set[str]]:
    """The sets that are named where two effects are hidden."""
    found, _ = diagnosed(tmp_path_factory.mktemp("two"), ["viscous_friction", "tip_payload"], 7010)
    return [{cause["effect"], *cause["indistinguishable_from"]} for cause in found["causes"]]


@pytest.mark.parametrize("hidden", ["viscous_friction", "tip_payload"])
def test_of_two_effects_both_are_named(hidden: str, named_of_two: list[set[str]]) -> None:
    assert any(hidden in names for names in named_of_two)


def test_of_two_effects_neither_is_taken_for_a_third(named_of_two: list[set[str]]) -> None:
    assert all(names & {"viscous_friction", "tip_payload"} for names in named_of_two)


def test_a_motion_that_shows_little_gives_no_false_cause(tmp_path: Path) -> None:
    """Slow motions have no inertia to tell: no reason to name anything."""
    found, _ = diagnosed(tmp_path, [], 7014, manner="slow")
    assert found["causes"] == []
    assert found["verdict"] in ("consistent", "insufficient")


def test_what_such_a_motion_shows_is_named_all_the_same(tmp_path: Path) -> None:
    """At one tension nothing stretches, and a load at the tip weighs as much in any motion."""
    found, truth = diagnosed(tmp_path, ["tip_payload"], 7015, manner="constant tension")
    named = {name for cause in found["causes"] for name in (cause["effect"], *cause["indistinguishable_from"])}
    assert found["causes"]
    assert "tip_payload" in named
    assert truth["hidden"][0]["effect"] == "tip_payload"
