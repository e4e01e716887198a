"""What is said of a parameter by its value and sigma: two parameters made up, each limit from both sides."""

import numpy as np
import pytest

from identification.fitting import FitSolution
from identification.identifiability import Identifiability, judge_identifiability
from identification.unknowns import Unknown, Unknowns
from mechanism.laws import LAWS

FS, FV = LAWS["dry_friction"].terms[0], LAWS["viscous_friction"].terms[0]


def judged(value: float, sigma: float, correlation: float = 0.0, at_bound: bool = False) -> Identifiability:
    """Dry friction of motor 2 beside viscous friction that is well known."""
    u = Unknowns((Unknown(FS, 2), Unknown(FV, 2)), {("fs", None): slice(0, 1), ("fv", None): slice(1, 2)}, {}, ())
    size = np.array([sigma, 1e-4])
    covariance = np.array([[1.0, correlation], [correlation, 1.0]]) * np.outer(size, size)
    solution = FitSolution(
        p=np.array([value, 0.05]),
        covariance=covariance,
        least_squares=np.zeros(2),
        least_squares_covariance=covariance,
        difference_covariance=covariance,
        blocks=30,
        information=np.linalg.inv(covariance),
        residuals=(),
        at_bound=np.array([at_bound, False]),
        instrumented=np.zeros(2, dtype=bool),
    )
    first, second = judge_identifiability(u, solution)
    assert second.identified
    return first


@pytest.mark.parametrize(
    ("sigmas", "kind"),
    [(0.0, "nothing"), (1.5, "nothing"), (2.95, "nothing"), (3.05, "flat"), (-2.95, "nothing"), (-3.05, "flat")],
)
def test_what_is_within_three_sigmas_of_zero_is_not_told_apart_from_it(sigmas: float, kind: str) -> None:
    found = judged(2.0 * sigmas, 2.0)
    assert (found.identified, found.kind) == (False, kind)
    assert found.why == ("not told apart from zero" if kind == "nothing" else "known to 33 % only")
    assert found.record == FS.would_tell


@pytest.mark.parametrize(("percent", "identified"), [(9.9, True), (10.1, False)])
def test_a_tenth_of_a_value_is_the_limit(percent: float, identified: bool) -> None:
    assert judged(-20.0, 0.2 * percent).identified == identified


@pytest.mark.parametrize(("correlation", "kind"), [(0.89, "flat"), (0.91, "traded"), (-0.91, "traded")])
def test_what_is_traded_off_is_named_with_the_other(correlation: float, kind: str) -> None:
    found = judged(10.0, 2.0, correlation)
    assert found.kind == kind
    assert (f"fv(2) (correlation {correlation:+.2f})" in found.why) == (kind == "traded")


def test_what_is_at_its_bound_or_without_effect_is_said_so() -> None:
    assert judged(20.0, 0.1, at_bound=True).why == "at its bound, 20 N"
    assert judged(20.0, 0.1).identified
    # the range of fs is 1000 N: with less information than that the motion tells nothing
    assert judged(20.0, 1500.0).kind == "dead"
    assert judged(20.0, 90.0).kind == "nothing"
