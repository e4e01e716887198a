"""Parts of the check by themselves: what a baseline is believed, and what a person reads."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from synchronisation.check.fault_search import law_prior_of
from synchronisation.check.wording import sentence, usable


def test_a_baseline_is_believed_to_twice_the_sigma_of_white_residuals_and_the_rope_to_five_micrometres() -> None:
    """Residuals of neighbouring frames are alike: four times the variance. Of 2 cables with 2 factors each the first is the rest
    length, which differs from recording to recording. Two are of the drawing; what was fitted along is no part of it."""
    inverse = np.diag(np.arange(1.0, 9.0)) * 1e-12 + 1e-13
    fit: Any = SimpleNamespace(inverse=inverse, beta=np.arange(8.0), of_arm=6)
    observation: Any = SimpleNamespace(arm=SimpleNamespace(M=2), law=SimpleNamespace(X=np.zeros((10, 2, 2))))
    prior = law_prior_of(observation, fit)
    np.testing.assert_array_equal(prior.beta, np.arange(6.0))
    expected = 4 * inverse[:6, :6]
    expected[[0, 2], [0, 2]] += 25e-12
    np.testing.assert_allclose(prior.covariance, expected, rtol=1e-12)


@pytest.mark.parametrize(
    ("size", "sigma", "unit", "said"),
    [
        (1.5e-3, 2e-5, "m", "1.5 mm +- 0.02"),
        (np.pi / 60, np.pi / 1800, "rad", "3 deg +- 0.1"),
        (-0.023, 0.001, "1", "-2.3 % +- 0.1"),
        (0.0125, 0.0004, "s", "12.5 ms +- 0.4"),
        (7.0, 0.5, "N", "7 N +- 0.5"),
    ],
)
def test_sizes_are_said_in_the_units_of_a_workshop(size: float, sigma: float, unit: str, said: str) -> None:
    fault = {
        "fault": "pulley_radius",
        "where": "mechanism 2",
        "size": size,
        "sigma": sigma,
        "unit": unit,
        "fix": "measure",
    }
    assert sentence(fault) == f"pulley_radius of mechanism 2: {said}; measure"
    others = {"or": [{"fault": "bar_length", "where": "mechanism 1"}], "when_s": 3.14159}
    assert sentence(fault | others) == (
        f"pulley_radius of mechanism 2 at 3.14 s: {said}, or bar_length of mechanism 1; measure"
    )


def test_only_what_happened_at_one_moment_leaves_a_part_usable() -> None:
    slip, radius = {"fault": "winch_slip"}, {"fault": "pulley_radius"}
    assert usable(()) is True
    assert usable((slip,)) == "in part"
    assert usable((radius,)) is False
    assert usable((slip, radius)) is False
