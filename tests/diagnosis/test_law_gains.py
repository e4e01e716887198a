"""In which equations a law is judged, and beside which laws causes are sought anew."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis import law_gains
from diagnosis.causes_beside_laws import _held, _with_other_causes
from diagnosis.held_out_gain import EQUATIONS, Gain, HeldOutResiduals
from discovery.form import FORMS, SMOOTH

SIMULATED = Gain("simulated joint angles", "rad", 0.1, 0.01, 0.01, 0.001)


def gains(motors: tuple[float, float], joints: tuple[float, float]) -> list[Gain]:
    """Before and after, where noise is 1 and the gain's sigma 0.1; a simulation gains most of all."""
    return [*(Gain(name, "", *of, 1.0, 0.1) for name, of in zip(EQUATIONS, (motors, joints), strict=True)), SIMULATED]


def law(detail: str) -> Any:
    return SimpleNamespace(candidate=SimpleNamespace(detail=detail))


@pytest.mark.parametrize(
    ("motors", "joints", "shown", "holds"),
    [
        ((3.0, 1.0), (1.2, 1.0), 0, True),
        ((1.02, 1.0), (3.5, 1.0), 1, True),  # the motor's own noise hides what the arm shows
        ((1.02, 1.0), (1.1, 1.0), 1, False),
        ((1.0, 1.5), (3.5, 1.0), 1, False),  # motors are worse with it
    ],
)
def test_a_law_at_a_motor_is_judged_where_it_shows(
    motors: tuple[float, float], joints: tuple[float, float], shown: int, holds: bool
) -> None:
    gained = gains(motors, joints)
    assert law_gains._shown_in(gained, law("against the motors")) == shown
    assert bool(law_gains._holds(gained, shown, False)) is holds


@pytest.mark.parametrize(
    ("before", "after", "holds"),
    [
        ([20.0, 1.0], [1.05, 1.0], True),
        ([20.0, 1.0], [7.0, 1.0], False),  # an eighth of the energy above noise is left
        ([1.4, 1.0], [1.0, 1.0], False),  # not plain
        ([1.9, 1.8], [1.0, 1.05], True),
        ([1.9, 1.8], [1.0, 1.7], False),
    ],
)
def test_what_acts_in_one_block_alone_holds_where_hardly_more_than_noise_is_left(
    before: list[float], after: list[float], holds: bool
) -> None:
    """A motor that saturates in one moment: left out, that block takes the gain with it, which is then one sigma."""
    noise, nothing = [np.ones((2, 900)) * [[3.0], [0.1]]] * 2, np.zeros((2, 900))

    def left(ratios: list[float]) -> HeldOutResiduals:
        return HeldOutResiduals(
            (np.array(ratios)[:, None] * noise[0],), (noise,), (nothing,), (0.0,), (np.arange(900) / 32,)
        )

    takes = law_gains._takes_nearly_all(left(before), left(after))
    assert takes is holds
    own = Gain(EQUATIONS[0], "", 6.0, 3.0, 3.0, 3.0)
    assert bool(law_gains._holds([own, Gain(EQUATIONS[1], "", 0.1, 0.1, 0.1, 0.01)], 0, takes)) is holds


def test_a_law_at_a_joint_is_judged_by_the_joints() -> None:
    assert law_gains._shown_in(gains((3.0, 1.0), (1.2, 1.0)), law(law_gains.AGAINST_JOINTS)) == 1


def found(*of: tuple[str, str]) -> Any:
    """Laws by variable and form."""
    forms = {form.name: form for form in FORMS}

    def one(variable: str, form: str) -> Any:
        candidate = SimpleNamespace(variable=variable, is_sibling=lambda other: other.variable == variable)
        return SimpleNamespace(law=SimpleNamespace(candidate=candidate, form=forms[form]))

    return SimpleNamespace(laws=[one(*each) for each in of])


@pytest.mark.parametrize(
    ("laws", "held"),
    [
        ((("time", SMOOTH), ("time of motor 2", "step")), [[1], [0]]),
        ((("speed", "hinge"), ("joint speed", "saturating")), [[0]]),
        ((("angle", "bump"), ("speed", "hinge"), ("angle", "harmonic")), [[0, 2]]),
        ((("time", SMOOTH),), [[0]]),
    ],
)
def test_causes_are_sought_beside_laws_of_a_simple_form_first(
    laws: tuple[tuple[str, str], ...], held: list[list[int]]
) -> None:
    assert list(_held(found(*laws))) == held


@pytest.mark.parametrize(
    ("outweighed", "named", "tried"),
    [
        ("beside too little", 0, ["beside too little"]),
        (None, 0, []),
        (None, 1, ["none"]),
        ("beside too little", 2, ["beside too little", "one", "none"]),
    ],
)
def test_causes_that_took_too_little_alone_are_tried_beside_a_law(
    outweighed: str | None, named: int, tried: list[str]
) -> None:
    search: Any = SimpleNamespace(
        named=[None] * named,
        with_outweighed_causes=lambda: outweighed,
        with_one_cause=lambda: "one",
        without_causes=lambda: "none",
    )
    assert list(_with_other_causes(search)) == tried
