"""What the ladder hides, and how it counts."""

import numpy as np
import pytest

from benchmarks import reliability
from benchmarks.ladder import CATALOGUE, OUTSIDE, SCENES, SET_ON, hidden_in, is_right, mixture, shows
from benchmarks.true_numbers import true_numbers
from diagnosis.effects import EFFECTS
from samples.forward_arms.arms import Arm
from samples.forward_arms.drawing import drawn
from samples.forward_arms.settings import Settings

ARM = drawn(Settings(), 7)


def test_names_are_those_of_the_diagnosis() -> None:
    assert set(CATALOGUE) <= set(EFFECTS)
    assert not set(OUTSIDE) & set(EFFECTS)
    assert 2 * len(SET_ON) <= len(OUTSIDE)
    assert len({scene.name for scene in SCENES}) == len(SCENES)


@pytest.mark.parametrize("seed", range(8, 14))
def test_a_mixture_is_of_the_arm_alone(seed: int) -> None:
    arm = drawn(Settings(), seed)
    first, again = mixture(arm), mixture(arm)
    assert list(first) == list(again)
    assert 3 <= len(first) <= 6
    for name, law in first.items():
        for field in vars(law):
            np.testing.assert_array_equal(getattr(law, field), getattr(again[name], field))


def said(verdict: str, *sets: list[str], mixed: tuple[str, ...] = ()) -> dict[str, object]:
    return {"verdict": verdict, "causes": [s[0] for s in sets], "sets": list(sets), "mixture": list(mixed)}


@pytest.mark.parametrize(
    ("scene", "record", "right"),
    [
        ("rung1", said("consistent"), True),
        ("rung1", said("cause", ["base_tilt"]), False),
        ("outside_loom", said("unknown"), True),
        ("outside_loom", said("cause", ["spring_stiffness"]), False),
        ("rung2_base_tilt", said("cause", ["base_tilt"]), True),
        ("rung2_base_tilt", said("ambiguous", ["tip_payload", "base_tilt"]), True),
        ("rung2_base_tilt", said("cause", ["base_tilt"], ["tip_payload"]), False),
        ("rung2_base_tilt", said("unknown"), False),
        ("rung3", said("cause", ["base_tilt"], ["tip_payload"], mixed=("base_tilt", "tip_payload")), True),
        ("rung3", said("cause", ["base_tilt"], ["cable_creep"], mixed=("base_tilt", "tip_payload")), False),
        ("rung3", said("cause", ["base_tilt"], mixed=("base_tilt", "tip_payload")), False),
    ],
)
def test_right_is_what_was_hidden_and_nothing_else(scene: str, record: dict[str, object], right: bool) -> None:
    assert is_right(scene, record) == right


@pytest.mark.parametrize(("over", "named", "expected"), [(1.1, [], False), (1.1, ["base_tilt"], True), (1.5, [], True)])
def test_what_shows_is_above_noise_or_named(over: float, named: list[str], expected: bool) -> None:
    record = {"verdict": "unknown", "causes": named, "motors_over_floor": [over, 1.0], "joints_over_floor": [1.0]}
    assert shows("rung2_base_tilt", record) == expected
    assert shows("rung1", record)
    assert shows("rung2_base_tilt", {"refused": "too short"})


def test_what_a_scene_hides_is_told_by_its_name() -> None:
    assert hidden_in("rung1", {}) == []
    assert hidden_in("rung2_tip_payload", {}) == ["tip_payload"]
    assert hidden_in("outside_loom", {}) == []


def test_probabilities_are_compared_with_what_was_hidden() -> None:
    records = [
        {"scene": "rung2_base_tilt", "causes": ["base_tilt"], "probabilities": [1.0]},
        {"scene": "rung2_base_tilt", "causes": ["tip_payload"], "probabilities": [0.5]},
        {"scene": "rung3", "causes": ["tip_payload"], "probabilities": [0.5], "mixture": ["tip_payload"]},
        {"scene": "outside_loom", "causes": ["spring_stiffness"], "probabilities": [1.0]},
        {"scene": "rung1", "refused": "too short"},
    ]
    rows = dict(reliability.table(records).rows)
    assert [rows[name][:3] for name in ("40 to 60 %", "99 to 100 %")] == [(2, 50.0, 50.0), (2, 100.0, 50.0)]


@pytest.mark.parametrize("name", CATALOGUE)
def test_true_numbers_bear_the_names_of_the_diagnosis(name: str) -> None:
    law = CATALOGUE[name](ARM, np.random.default_rng(5))
    arm = Arm(7, ARM, law.altered(ARM), (law,), ())
    if (numbers := true_numbers(law, arm)) is None:
        assert name == "joint_friction"
        return
    effect = EFFECTS[numbers[0]]
    assert effect.name == name
    assert set(numbers[1]) <= {term.name for term in (*effect.terms, *effect.shape_terms)}
    assert any(np.any(value) for value in numbers[1].values())
