"""A load is weighed and placed wherever on the last bar it hangs."""

import numpy as np
import pytest

from diagnosis.diagnose import diagnose
from diagnosis.effects.tip_payload import with_load
from mechanism.description import read_neck
from tests.hidden_arms import BESIDE, seen_arms
from tests.paths import NECK_FILE


def test_a_load_beside_the_middle_is_weighed_there_and_nothing_else_is_blamed() -> None:
    """Taken to hang in the middle, it drove bars, springs and the base's tilt as far as they may go."""
    first, second = (seen_arms()["payload off the middle"].synchronised(i) for i in range(2))
    found = diagnose([first], [second])
    assert [cause.effect.name for cause in found.causes] == ["tip_payload"]
    numbers = {p.name: p for p in found.numbers[0]}
    for name, true in {"m": BESIDE.mass, "xm": BESIDE.at, "ym": 0.0}.items():
        assert abs(numbers[name].value - true) < 4 * numbers[name].sigma, name
    # a load in the middle would be told from this one
    assert numbers["xm"].sigma < BESIDE.at / 4
    assert all(r.ratio < 1.25 for r in found.remainder)


@pytest.mark.parametrize(("mass", "x", "y"), [(0.05, 0.02, -0.01), (1.5, 0.0, 0.03), (-0.02, 0.01, 0.01)])
def test_a_bar_with_a_load_has_the_moments_of_both(mass: float, x: float, y: float) -> None:
    """Mass, first and second moments about the middle of the bar add up."""
    neck = read_neck(NECK_FILE)
    bar = neck.mechanisms[-1].top
    loaded = with_load(neck, mass, x, y).mechanisms[-1].top

    def moments(m: float, com: tuple[float, float], inertia: float) -> list[float]:
        return [m, m * com[0], m * com[1], inertia + m * (com[0] ** 2 + com[1] ** 2)]

    both = np.array(moments(bar.mass, bar.com, bar.inertia)) + moments(mass, (x, y), 0.0)
    if mass > 0:
        np.testing.assert_allclose(moments(loaded.mass, loaded.com, loaded.inertia), both, rtol=1e-12, atol=1e-18)
    else:  # what is taken off may leave no inertia below nothing
        np.testing.assert_allclose(
            moments(loaded.mass, loaded.com, loaded.inertia)[:3], both[:3], rtol=1e-12, atol=1e-18
        )
    unloaded = with_load(with_load(neck, abs(mass), x, y), -abs(mass), x, y).mechanisms[-1].top
    assert unloaded.mass == pytest.approx(bar.mass)
    np.testing.assert_allclose(unloaded.com, bar.com, atol=1e-12)
    assert unloaded.inertia == pytest.approx(bar.inertia)
