"""Cables that come taut little by little, on an arm of the second generator whose controller lets them go slack."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from benchmarks.forward_arm_runs import SETTINGS, seen
from diagnosis.cause_fit import CauseFitter
from diagnosis.diagnose import Diagnosis, diagnose
from diagnosis.effects import EFFECTS
from diagnosis.fit_stage import FitStage
from diagnosis.hypothesis import as_described
from diagnosis.linearisation import base_unknowns, with_laws_of
from diagnosis.noise_ensemble import noise_ensemble
from identification.dataset.frames import frame_angles
from samples.forward_arms.arms import make_arms
from samples.forward_arms.laws import Law, Snapshot
from samples.forward_arms.plant import Array
from tests.hidden_arms import seen_arms

pytestmark = pytest.mark.slow

SEED, NOISE_DEG, TOE_M = 453, 0.02, 5e-4
LOW = replace(SETTINGS, seconds=24.0, tension_range=(0.0, 80.0), pretension=(9.0, 9.0))
"""cables of the base arm are never far from slack, and cannot push either"""


@dataclass(frozen=True)
class Toe(Law):
    """The first cable's strands come taut one after another, over some `width` (m) of its elongation."""

    width: float

    def tension(self, s: Snapshot) -> Array:
        out = np.zeros_like(s.x)
        out[0] = s.stiffness[0] * (self.width * np.logaddexp(0.0, s.x[0] / self.width) - s.x[0])
        return out


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    (arm,) = make_arms([SEED], LOW, hidden=[(Toe(TOE_M),)])
    there = seen(arm, LOW, NOISE_DEG)
    return diagnose([there.synchronised(0)], [there.synchronised(1)])


def test_it_is_named_alone_with_the_elongation_over_which_it_comes_taut(found: Diagnosis) -> None:
    """With an amount free beside it, cables went slack by 1.5 or by .7 of what they bear, and other causes stood beside it."""
    assert [cause.effect.name for cause in found.causes] == ["cable_slack"]
    first = next(p for p in found.numbers[0] if p.name == "xs" and p.index == 1)
    assert abs(first.value - TOE_M) < 4 * first.sigma < 0.2 * TOE_M
    assert goes_slack(found.search.first, 0)


def test_nothing_plain_is_left(found: Diagnosis) -> None:
    assert found.found_laws == ()
    assert max(gain.after / gain.noise_floor for gain in found.remainder) < 1.5


def test_a_cable_that_hardens_is_not_said_to_go_slack() -> None:
    """A law that turns over little by little is straight from nowhere on, as one that hardens."""
    first, second = (seen_arms()["one cable hardens"].synchronised(i) for i in range(2))
    hardens = diagnose([first], [second])
    assert [(cause.effect.name, cause.where.label) for cause in hardens.causes] == [("cable_hardening", "cable 2")]


def test_a_taut_cable_does_not_come_to_where_slack_acts() -> None:
    """Of an arm that holds every cable at 12 N and more."""
    taut = replace(SETTINGS, seconds=24.0, tension_range=(12.0, 80.0), pretension=(30.0, 30.0))
    (arm,) = make_arms([SEED], taut)
    data = seen(arm, taut, NOISE_DEG).synchronised(0)
    stage = CauseFitter(as_described(data.neck), [noise_ensemble(data, frame_angles(data), 0)]).base_model()
    assert not any(goes_slack(stage, cable) for cable in range(4))


def goes_slack(stage: FitStage, cable: int) -> bool:
    """Whether a cable, counted from 0, comes to where a law that turns over within TOE_M acts."""
    effect, at = EFFECTS["cable_slack"], stage.comparison.linearisation
    h = at.hypothesis.with_law("cable_slack", {"slack": np.ones(at.hypothesis.arm.M), "xs": np.full(4, TOE_M)})
    (read,) = with_laws_of(at, h, at.unknowns.carried(at.p, base_unknowns(h, 1))).recordings
    return effect.is_reached(read, effect.alone_at(cable, h.arm))
