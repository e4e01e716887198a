"""An arm that is no longer the one identified is said to be, and one that is is not."""

import numpy as np
import pytest

from identification.dataset.series import Series
from observation.health import sentences, verdict
from observation.observed_log import observe_log
from samples.forward_arms.laws import Payload, ViscousFriction
from tests.observation.arms import case, changed

SEED = 5011


def test_a_quiet_recording_is_said_to_be_as_identified() -> None:
    of = case(SEED)
    seen = observe_log(of.neck, of.model, of.log.part(slice(0, 9500)))
    assert verdict(seen.health) == "as identified"
    assert sentences(seen.health) == []
    assert seen.health.windows == 2


@pytest.mark.parametrize("law", [Payload(0.3), ViscousFriction(np.full(4, 0.15))], ids=["load", "friction"])
def test_a_changed_arm_is_named_with_its_time(law: object) -> None:
    of = changed(SEED, (law,))  # type: ignore[arg-type]
    seen = observe_log(of.neck, of.model, of.log.part(slice(0, 5200)))
    assert verdict(seen.health) == "changed"
    assert seen.health.findings[0].time == pytest.approx(of.log.time[0] + 2.0, abs=0.01)
    assert "is not as identified" in sentences(seen.health)[0]


def test_a_short_log_is_not_judged() -> None:
    of = case(SEED)
    seen = observe_log(of.neck, of.model, of.log.part(slice(0, 300)))
    assert verdict(seen.health) == "cannot tell"


def test_a_cable_that_slips_is_named_where_it_slips() -> None:
    """Its motor has wound in 3 mm that the cable did not follow."""
    of = case(SEED)
    log = of.log.part(slice(0, 9500))
    drum = of.neck.motors[1].rd / of.neck.motors[1].R
    slipped = {**log.columns, "theta2": log.columns["theta2"] + np.where(log.time > log.time[5200], 3e-3 / drum, 0.0)}
    seen = observe_log(of.neck, of.model, Series(log.time, slipped))
    assert verdict(seen.health) == "changed"
    assert min(f.time for f in seen.health.findings) > log.time[4900]
