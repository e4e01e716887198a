"""Friction of a slightly other curve is within tolerance; one that is plainly other is not."""

import numpy as np
import pytest

from diagnosis.diagnose import diagnose
from diagnosis.friction_curve import BUMP_SPEEDS, friction_bumps
from mechanism.friction import dry
from tests.hidden_arms import seen_arms


def test_bumps_are_odd_and_one_at_their_speeds() -> None:
    speed = np.linspace(-150.0, 150.0, 3001)
    np.testing.assert_allclose(friction_bumps(-speed), -friction_bumps(speed), atol=1e-15)
    at_speeds = friction_bumps(np.array(BUMP_SPEEDS))
    np.testing.assert_allclose(np.diag(at_speeds), 1.0)
    assert (at_speeds <= 1.0).all()


def test_bumps_add_up_to_what_parts_a_hyperbola_from_the_arc_tangent() -> None:
    """Of speed / (|speed| + 4 / pi), whose tail is the arc tangent's, a fifth of what they differ by is left at most."""
    speed = np.geomspace(0.1, 150.0, 400)
    apart = speed / (speed + 4 / np.pi) - dry(speed)
    bumps = friction_bumps(speed)
    amounts = np.linalg.lstsq(bumps, apart, rcond=None)[0]
    assert np.sqrt(np.mean((apart - bumps @ amounts) ** 2)) < 0.2 * np.sqrt(np.mean(apart**2))


@pytest.mark.slow
def test_a_peak_is_a_cause_beside_a_small_difference_of_curves() -> None:
    """3 N, on friction 0.05 N rms from the arc tangent. That the difference alone is none is with the arms of
    test_hidden_effects.py in which nothing is hidden."""
    first, second = (seen_arms()["another curve with a peak"].synchronised(i) for i in range(2))
    found = diagnose([first], [second])
    assert (found.verdict, [cause.effect.name for cause in found.causes]) == ("cause", ["stribeck_friction"])
