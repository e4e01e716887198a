"""A cause of the catalogue and a law that no catalogue holds at once: each is named as what it is, with its numbers."""

import numpy as np

from diagnosis.diagnose import diagnose
from tests.hidden_arms import PAYLOAD, STOP, seen_arms
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
