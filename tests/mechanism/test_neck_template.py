"""The description that `xneck init` writes is a whole arm, and says of every key what it means."""

import re

import numpy as np
import pytest
from pydantic import BaseModel
from scipy.optimize import linprog

from mechanism.arm import arm_of
from mechanism.cable_lengths import Z
from mechanism.description import Bar, Cable, Mechanism, Motor, Neck, Spring, Springs, Top
from mechanism.neck_template import neck_template
from mechanism.printed_markers import BarMarker, Markers
from mechanism.tolerance import Tolerance
from mechanism.usual_routes import usual_routes
from xneck_foundation.strict_yaml import parse_yaml, validate_document

MODELS = (Neck, Mechanism, Bar, Top, Spring, Springs, Cable, Motor, Markers, BarMarker, Tolerance)


def described(mechanisms: int, cables: int, L: float = 0.1, b: float = 0.05) -> Neck:
    return validate_document(parse_yaml(neck_template(mechanisms, cables, L, b), "neck.yaml"), Neck, "neck.yaml")


@pytest.mark.parametrize("mechanisms", [1, 2, 3, 6, 100])
@pytest.mark.parametrize("cables", [1, 2, 3, 6, 8, 101, 200])
def test_any_arm_is_read_as_it_is_written(mechanisms: int, cables: int) -> None:
    neck = described(mechanisms, cables)
    assert (neck.N, neck.M, len(neck.motors)) == (mechanisms, cables, cables)
    assert neck.markers is not None
    assert [marker.bar for marker in neck.markers.on_bars] == list(range(mechanisms + 1))


@pytest.mark.parametrize(("L", "b"), [(0.1, 0.05), (0.004, 0.002), (2.0, 1.0), (0.06, 0.055)])
def test_lengths_that_make_an_x_joint_are_taken(L: float, b: float) -> None:
    neck = described(2, 3, L=L, b=b)
    assert {(m.L, m.b) for m in neck.mechanisms} == {(L, b)}


@pytest.mark.parametrize("mechanisms", [1, 2, 3, 4, 6])
def test_usual_cables_can_turn_every_joint_both_ways_by_itself(mechanisms: int) -> None:
    """Pulls (never pushes) reach any torques from n + 1 cables on: Z has full rank, and some positive tensions balance."""
    for cables in range(mechanisms + 1, 2 * mechanisms + 4):
        assert turns_all_joints(mechanisms, cables), cables


def test_too_few_cables_cannot() -> None:
    assert not turns_all_joints(3, 3)


def turns_all_joints(mechanisms: int, cables: int) -> bool:
    z = Z(arm_of(described(mechanisms, cables)), np.zeros(mechanisms))
    balanced = linprog(np.ones(cables), A_eq=z, b_eq=np.zeros(mechanisms), bounds=(1.0, None)).success
    return bool(np.linalg.matrix_rank(z) == mechanisms and balanced)


def test_fasquelles_arm_has_her_routes() -> None:
    assert usual_routes(3, 4) == (
        ("right",),
        ("strut", "right"),
        ("strut", "strut", "right"),
        ("left_through", "left_through", "left"),
    )


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.__name__)
def test_every_key_says_what_it_means(model: type[BaseModel]) -> None:
    assert [name for name, field in model.model_fields.items() if not field.description] == []


def test_every_key_stands_in_the_file_below_what_it_means() -> None:
    text = neck_template(2, 3)
    unfolded = re.sub(r"\n *#   ", " ", text)
    for model in set(MODELS) - {Spring}:
        for name, field in model.model_fields.items():
            meaning = re.escape(" ".join(str(field.description).split()))
            assert re.search(rf"^ *# {meaning}.*\n *(# )?{name}:", unfolded, re.MULTILINE), (model, name)


def test_tolerances_of_the_file_are_a_workshops() -> None:
    written, usual = described(1, 2).tolerance.model_dump(), Tolerance().model_dump()
    assert written == pytest.approx(usual, rel=2e-3)
