"""Forces are known no better than drums where a gain of the motors is as small as drums may make it."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis import cause_search
from diagnosis.cause import Cause
from diagnosis.effects import EFFECTS
from diagnosis.hypothesis import Hypothesis, as_described
from mechanism.arm import arm_of
from mechanism.description import read_neck
from tests.paths import SAMPLES

NECK = read_neck(SAMPLES / "recording/neck.yaml")
ARM = arm_of(NECK)


def cause(effect: str, place: int, amount: float) -> Cause:
    """At motor `place`, from 1."""
    return Cause(EFFECTS[effect], EFFECTS[effect].alone_at(place - 1, ARM), np.array([amount]), {})


@pytest.mark.parametrize(
    ("causes", "kept"),
    [
        ((cause("actuator_gain", 3, 0.004),), 0),
        ((cause("actuator_gain", 3, -0.004),), 0),
        ((cause("actuator_gain", 3, 0.03),), None),
        ((cause("actuator_offset", 3, 0.004),), None),
        ((cause("actuator_gain", 3, 0.03), cause("drum_radius", 3, 0.032)), 1),
        ((cause("drum_radius", 3, -0.032), cause("actuator_gain", 3, -0.03)), 1),
        ((cause("actuator_gain", 3, 0.03), cause("drum_radius", 3, 0.04)), None),
        ((cause("actuator_gain", 3, 0.03), cause("drum_radius", 2, 0.03)), None),
        ((cause("actuator_gain", 3, 0.03), cause("drum_radius", 3, -0.03)), None),
    ],
)
def test_causes_are_sought_again_where_a_gain_may_be_a_drums(
    causes: tuple[Cause, ...], kept: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """kept: of the causes, with which the second search begins; None where there is none. Sigma is .002 of every amount."""
    h, begun = as_described(NECK), []

    def search(
        of: Hypothesis, _ensembles: Any, _seed: int, causes_begun: Any = (), near: Any = None, rival: Any = None
    ) -> Any:
        begun.append((near, causes_begun))
        assert of.forces_as_drums == (near is not None)
        at = SimpleNamespace(linearisation="there")
        return SimpleNamespace(
            last=SimpleNamespace(causes=causes, sigma_of_causes=[np.full(1, 0.002)] * len(causes), comparison=at)
        )

    monkeypatch.setattr(cause_search, "_search", search)
    cause_search.search_causes(h, [])
    assert len(begun) == (1 if kept is None else 2)
    if kept is not None:
        assert begun[1][0] == "there"
        assert [c.effect.name for c in begun[1][1]] == ["drum_radius"] * kept


def test_what_is_known_of_an_arm_stays_known() -> None:
    """Beside departures that recordings told those of forces begin at none."""
    h = as_described(NECK)
    assert h.with_forces_as_drums().departures == ()
    told = Hypothesis(h.neck, (), {}, h.angle_error, departures=(0.5, -1.0))
    assert told.with_forces_as_drums().departures == (0.5, -1.0, 0.0, 0.0, 0.0, 0.0)
