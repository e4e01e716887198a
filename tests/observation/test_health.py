"""An arm that is no longer the one identified is said to be, and one that is is not."""

import numpy as np
import pytest

from identification.dataset.series import Series
from observation import load_test
from observation.health import SETTLING_S, sentences, verdict
from observation.observed_log import observe_log
from tests.observation.arms import CHANGES, SEEDS, case, changed

ROWS = 5200
"""a window and what comes before it"""


def test_a_quiet_recording_is_said_to_be_as_identified() -> None:
    for seed in SEEDS:
        of = case(seed)
        seen = observe_log(of.neck, of.model, of.log.part(slice(0, ROWS)))
        assert verdict(seen.health) == "as identified"
        assert sentences(seen.health) == []
        assert seen.health.windows == 1


@pytest.mark.parametrize("name", sorted(CHANGES))
def test_a_changed_arm_is_named_with_its_time(name: str) -> None:
    of = changed(name)
    seen = observe_log(of.neck, of.model, of.log.part(slice(0, ROWS)))
    assert verdict(seen.health) == "changed"
    assert seen.health.findings[0].time == pytest.approx(of.log.time[0] + SETTLING_S, abs=0.01)
    assert "is not as identified" in sentences(seen.health)[0]


def test_a_short_log_is_not_judged() -> None:
    of = case(SEEDS[1])
    seen = observe_log(of.neck, of.model, of.log.part(slice(0, 100)))
    assert verdict(seen.health) == "cannot tell"


def test_a_cable_that_slips_is_named() -> None:
    """Its motor has wound in 3 mm that the cable did not follow."""
    of = case(SEEDS[1])
    log = of.log.part(slice(0, ROWS))
    drum = of.neck.motors[1].rd / of.neck.motors[1].R
    slipped = {**log.columns, "theta2": log.columns["theta2"] + np.where(log.time > log.time[1200], 3e-3 / drum, 0.0)}
    seen = observe_log(of.neck, of.model, Series(log.time, slipped))
    assert verdict(seen.health) == "changed"
    assert max(seen.health.findings, key=lambda found: found.ratio).motor == 2


def test_a_load_is_weighed(monkeypatch: pytest.MonkeyPatch) -> None:
    """0.3 kg on the tip within a third, in a stretch of 8 s; and none where none hangs there."""
    monkeypatch.setattr(load_test, "LOAD_STRETCH_S", 8.0)
    of = changed("load")
    (load, *_) = observe_log(of.neck, of.model, of.log.part(slice(0, ROWS))).health.loads
    assert load.mass == pytest.approx(0.3, rel=1 / 3)
    assert load.time == pytest.approx(of.log.time[0] + SETTLING_S, abs=0.2)
    quiet = case(SEEDS[1])
    assert not observe_log(quiet.neck, quiet.model, quiet.log.part(slice(0, ROWS))).health.loads
