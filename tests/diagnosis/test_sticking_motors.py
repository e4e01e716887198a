"""Motors whose friction holds them at rest by anything up to its greatest: forward arms of the second generator."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.forward_arm_runs import SETTINGS, seen
from diagnosis.diagnose import MOTORS_STICK, Diagnosis, diagnose
from diagnosis.held_at_rest import HeldAtRest, HeldShares
from diagnosis.linearisation import Linearisation
from samples.forward_arms import make_arms
from samples.forward_arms.laws import Presliding
from tests.diagnosis.test_signature import at  # noqa: F401 (fixture)

pytestmark = pytest.mark.slow

SHORT = replace(SETTINGS, seconds=12.0, recordings=1)
WITHIN_A_COUNT_RAD, SEEN_RAD = 1e-3, 0.05
"""over which bristles bend: less than an encoder of 2048 counts sees, and more"""


@pytest.fixture(scope="module")
def found() -> list[Diagnosis]:
    """Of an arm whose motors stick, and of one with bristles that encoders see bend."""
    widths = [(Presliding(np.full(4, width)),) for width in (WITHIN_A_COUNT_RAD, SEEN_RAD)]
    arms = make_arms([5031, 5032], SHORT, hidden=widths)
    return [diagnose([seen(arm, SHORT, 0.03).synchronised(0)]) for arm in arms]


def test_motors_that_stick_are_said_to_and_are_no_cause(found: list[Diagnosis]) -> None:
    """Else four motors would leave several times their noise at rest, which no function of their speed explains."""
    sticking, _ = found
    assert (sticking.verdict, sticking.causes, sticking.found_laws) == ("consistent", (), ())
    assert MOTORS_STICK in sticking.why
    assert all(0.75 < left.ratio < 1.3 for left in sticking.remainder)


def test_bristles_that_encoders_see_are_named(found: list[Diagnosis]) -> None:
    _, bristles = found
    assert [cause.effect.name for cause in bristles.causes] == ["presliding_friction"]
    assert MOTORS_STICK not in bristles.why
    assert bristles.search.fitter.hypothesis.held.motors == 0


def test_draws_of_what_holds_are_as_large_as_the_variance_says(at: Linearisation) -> None:  # noqa: F811
    """The mean square over rows of 40 draws, which each stay alike for .2 s: a quarter of an hour, known to some 3 %."""
    (recording,) = at.recordings
    s, rng, shares = recording.signals, np.random.default_rng(7), HeldShares(motors=0.3, joints=0.2)
    rests = (s.time % 5.0 < 2.0)[:, None]
    held = HeldAtRest(
        motors=np.where(rests, 15.0, 0.0) * np.ones(s.arm.M), joints=np.where(rests, 0.05, 0.0) * np.ones(s.arm.N)
    )
    drawn = np.mean([np.mean(held.residuals(shares, s, rng) ** 2, axis=1) for _ in range(40)], axis=0)
    assert drawn == pytest.approx(held.variance(shares, s).mean(axis=1), rel=0.15)
