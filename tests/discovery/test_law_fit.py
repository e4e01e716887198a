"""Inner constants of two laws are fitted together, each to its own."""

import numpy as np

from discovery.array_problem import ArrayProblem
from discovery.found_law import FoundLaw
from discovery.law_fit import fitted
from discovery.problem import Candidate


def bump(candidate: Candidate, place: float, width: float) -> FoundLaw:
    (form,) = (form for form in candidate.forms if form.name == "bump")
    return FoundLaw(candidate, form, {"place": place, "width": width}, np.zeros(1), np.zeros((3, 3)))


def test_the_constants_of_two_laws_are_both_told_to_their_sigma() -> None:
    """Bumps of 2 and -3 N in white noise of 0.3 N, from beside their places."""
    rng = np.random.default_rng(12)
    force, speed = rng.uniform(-1, 1, (2, 1500))
    true = ((0.31, 0.23), (-0.42, 0.37))
    target = 2 * np.exp(-(((force - 0.31) / 0.23) ** 2)) - 3 * np.exp(-(((speed + 0.42) / 0.37) ** 2))
    problem = ArrayProblem(
        y=target + 0.3 * rng.normal(size=1500),
        values={"force": force, "joint_speed": speed},
        block=np.arange(1500) // 50,
        turns=(),
        direction_width=1.0,
        scale=0.3,
    )
    one, other = problem.candidates[:2]
    laws = fitted(problem, (bump(one, 0.25, 0.3), bump(other, -0.5, 0.3)))
    for law, amount, (place, width) in zip(laws, (2.0, -3.0), true, strict=True):
        sigma = np.sqrt(np.diag(law.covariance))
        off = np.array([law.amounts[0] - amount, law.constants["place"] - place, law.constants["width"] - width])
        assert np.all(np.abs(off) < 4 * sigma)
        assert np.all(sigma < [0.1, 0.01, 0.01])
