"""A cause of the catalogue and a law that no catalogue holds at once: each is named as what it is, with its numbers."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from diagnosis.cause import Cause
from diagnosis.causes_beside_laws import Explanation
from diagnosis.diagnose import diagnose
from diagnosis.effects import EFFECTS
from mechanism.arm import arm_of
from mechanism.description import read_neck
from tests.hidden_arms import PAYLOAD, STOP, seen_arms
from tests.paths import NECK_FILE
from xneck.report.diagnosis_text import diagnosis_sentence

STIFFNESS, SLACK, MASS = STOP.stiffness, STOP.slack, PAYLOAD.mass


def test_a_payload_beside_a_stop_is_named_and_weighed() -> None:
    """A loom of leads holds the first joint beyond 0.2 rad: while that is unknown no choice of causes explains the arm."""
    first, second = (seen_arms()["payload beside a stop"].synchronised(i) for i in range(2))
    found = diagnose([first], [second])
    assert [cause.effect.name for cause in found.causes] == ["tip_payload"]
    (gained,) = found.found_laws
    assert gained.law.words == "against joint 1: hinge of joint_angle"
    numbers = {p.name: p for p in gained.law.parameters}
    assert abs(numbers["slope"].value - STIFFNESS) < 4 * numbers["slope"].sigma < 0.1 * STIFFNESS
    assert abs(numbers["place"].value - SLACK) < 4 * numbers["place"].sigma < 0.05
    assert np.abs(found.causes[0].amounts[0] - MASS) < 0.15 * MASS
    assert found.verdict == "cause"
    assert found.why == "found beside the catalogue: against joint 1: hinge of joint_angle"
    assert all(r.ratio < 1.25 for r in found.remainder)
    assert "tip_payload" not in found.detectability.invisible
    sentence = diagnosis_sentence(found)
    assert "he arm carries something at its tip" in sentence
    assert "; and a law that no catalogue lists acts against joint 1: hinge of joint angle." in sentence


@pytest.mark.parametrize(
    ("dry", "variable", "causes", "may_be"),
    [
        (-0.005, "joint_speed", 1, True),  # friction that pushes, and a law of the speed that holds: air drag
        (0.02, "joint_speed", 1, False),  # friction that holds, of a form that a law mends
        (-0.005, "joint_angle", 1, False),  # a law of something else
        (-0.005, "joint_speed", 2, False),
    ],
)
def test_one_cause_at_its_least_and_a_law_of_its_variable_may_be_one_law(
    dry: float, variable: str, causes: int, may_be: bool
) -> None:
    """Of drag by the square of speed viscous joint friction and tanh were left, which cancel where it is slow."""
    described = arm_of(read_neck(NECK_FILE))
    effect = EFFECTS["joint_friction"]
    everywhere = effect.placements(described)[0]
    amounts = np.repeat([dry, 0.5], described.N)
    cause = Cause(effect, everywhere, amounts, dict(effect.start_shapes[0]))
    law = SimpleNamespace(law=SimpleNamespace(candidate=SimpleNamespace(variable=variable)))
    stage = SimpleNamespace(causes=[cause], before_causes=SimpleNamespace(arm=described))
    search = SimpleNamespace(named=[cause] * causes)
    assert Explanation(cast("Any", search), cast("Any", (law,)), cast("Any", stage)).may_be_one_law == may_be
