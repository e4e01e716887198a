"""What is said of a law that was found: its band and its equation, by hand."""

import numpy as np
import pytest

from discovery.fine_basis import FineBasis
from discovery.form import FORMS, Form
from discovery.found_law import FoundLaw
from discovery.problem import Candidate


def polynomial(degree: int) -> Form:
    return next(form for form in FORMS if form.name == "polynomial" and len(form.amounts) == degree)


def candidate(places: int = 1, follows: tuple[str, ...] = ("force",), factor: str = "") -> Candidate:
    basis = FineBasis.of([np.linspace(-1, 1, 50)], False)
    return Candidate("all", follows, "N", "line", basis, target_unit="N", places=places, factor=factor)


@pytest.mark.parametrize(
    ("place", "value", "variance"),
    [
        (0, 2 * 1.0 + 4 * 10.0, 4 * 1.0 + 2 * 8 * 0.5 + 16 * 16.0),
        (1, 2 * 2.0 + 4 * 20.0, 4 * 4.0 - 2 * 8 * 2.0 + 16 * 9.0),
        (2, 2 * 3.0 + 4 * 30.0, 4 * 100.0 + 16 * 0.01),
    ],
)
def test_the_band_of_a_place_is_of_its_own_amounts(place: int, value: float, variance: float) -> None:
    """a1 x + a2 x^2 at x = 2: its variance is 4 var(a1) + 2 8 cov(a1, a2) + 16 var(a2), of that place alone."""
    covariance = np.diag([1.0, 4.0, 100.0, 16.0, 9.0, 0.01])  # a1 of three places, then a2
    covariance[0, 3] = covariance[3, 0] = 0.5
    covariance[1, 4] = covariance[4, 1] = -2.0
    law = FoundLaw(candidate(3), polynomial(2), {}, np.array([1.0, 2.0, 3.0, 10.0, 20.0, 30.0]), covariance)
    values, sigma = law.curve(np.array([2.0]), place)
    assert values == pytest.approx([value], rel=1e-12)
    assert sigma == pytest.approx([np.sqrt(variance)], rel=1e-12)


@pytest.mark.parametrize(
    ("follows", "factor", "equation"),
    [
        (("force",), "", "a1 x + a2 x^2, x = force"),
        (
            ("force", "motor_speed"),
            "sign(motor_speed)",
            "sign(motor_speed) (a1 x + a2 x^2), x = force",
        ),
    ],
)
def test_an_equation_holds_what_turns_the_law_over(follows: tuple[str, ...], factor: str, equation: str) -> None:
    law = FoundLaw(candidate(1, follows, factor), polynomial(2), {}, np.ones(2), np.eye(2))
    assert law.equation == equation
