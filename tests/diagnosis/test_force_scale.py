"""Forces are known no better than drums where a gain of the motors is as small as drums may make it."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis import cause_search
from diagnosis.cause import Cause
from diagnosis.effects import EFFECTS
from diagnosis.hypothesis import Hypothesis, as_described
from mechanism.description import read_neck
from tests.paths import SAMPLES


@pytest.mark.parametrize(
    ("effect", "amount", "searches"),
    [
        ("actuator_gain", 0.004, 2),
        ("actuator_gain", -0.004, 2),
        ("actuator_gain", 0.03, 1),
        ("actuator_offset", 0.004, 1),
    ],
)
def test_causes_are_sought_again_where_a_gain_may_be_a_drums(
    effect: str, amount: float, searches: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    h = as_described(read_neck(SAMPLES / "recording/neck.yaml"))
    where = EFFECTS[effect].placements(h.arm)[0]
    found = Cause(EFFECTS[effect], where, np.full(len(where.columns), amount), {})
    asked: list[Hypothesis] = []

    def search(of: Hypothesis, *_: Any) -> Any:
        asked.append(of)
        return SimpleNamespace(last=SimpleNamespace(causes=() if of.forces_as_drums else (found,)))

    monkeypatch.setattr(cause_search, "_search", search)
    last = cause_search.search_causes(h, []).last
    assert [of.forces_as_drums for of in asked] == [False, True][:searches]
    assert last.causes == (() if searches == 2 else (found,))


def test_what_is_known_of_an_arm_stays_known() -> None:
    """Beside departures that recordings told those of forces begin at none."""
    h = as_described(read_neck(SAMPLES / "recording/neck.yaml"))
    assert h.with_forces_as_drums().departures == ()
    told = Hypothesis(h.neck, (), {}, h.angle_error, departures=(0.5, -1.0))
    assert told.with_forces_as_drums().departures == (0.5, -1.0, 0.0, 0.0, 0.0, 0.0)
