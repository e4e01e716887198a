"""What is said of an effect is whole, and its true numbers are those of a study's truth."""

import pytest

from diagnosis.effect import Effect
from diagnosis.effects import EFFECTS
from mechanism.laws import LAWS

TRUTH = {"k": [1e4] * 4, "neck": {"mechanisms": [{}] * 3}}


@pytest.mark.parametrize("effect", EFFECTS.values(), ids=EFFECTS)
def test_an_effect_says_what_would_tell_it_and_what_shows_it(effect: Effect) -> None:
    assert effect.words
    assert effect.would_tell
    assert effect.shown_by.equation in ("motor", "joint")
    assert all(set(shape) <= {term.name for term in effect.shape_terms} for shape in effect.start_shapes)


def test_names_of_terms_have_one_meaning() -> None:
    terms = {term.name: term for law in LAWS.values() for term in law.terms}
    assert all(terms[term.name] == term for law in LAWS.values() for term in law.terms)


def test_hidden_parameters_that_bear_a_terms_name_are_its_numbers() -> None:
    """With an index, at the place where it was hidden, and everywhere where no place is said."""
    viscous, play = EFFECTS["viscous_friction"], EFFECTS["backlash"]
    assert viscous.true_numbers({"fv1": 0.1, "fv3": 0.3}, TRUTH, None) == {("fv", 1): 0.1, ("fv", 3): 0.3}
    assert play.true_numbers({"play": 1e-3, "crossing_s": 0.01}, TRUTH, 2) == {("play", 2): 1e-3}
    assert EFFECTS["pulley_friction"].true_numbers({"mu": 0.01}, TRUTH, None) == {("mu", j): 0.01 for j in (1, 2, 3, 4)}
    assert EFFECTS["joint_friction"].true_numbers({"cj": 0.01}, TRUTH, None) == {("cj", i): 0.01 for i in (1, 2, 3)}
    assert EFFECTS["tip_payload"].true_numbers({"mass": 0.1}, TRUTH, 3) == {("m", None): 0.1}


def test_a_law_of_another_form_has_no_true_numbers() -> None:
    assert EFFECTS["joint_friction"].true_numbers({"dry": 0.01, "viscous": 0.01, "sharpness": 20.0}, TRUTH, None) == {}
    assert EFFECTS["cable_hysteresis"].true_numbers({"force1": 3.0, "force2": 4.0}, TRUTH, None) == {}
    assert EFFECTS["clock_offset"].true_numbers({"late_s": 5e-3}, TRUTH, None) == {}
