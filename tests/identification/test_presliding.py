"""Friction that bends before it slides, identified on an arm of the second generator, which begins as bent as it was left."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.forward_arm_runs import SETTINGS, seen
from identification.dataset.dataset import DataSet
from identification.estimates import Estimates, estimate
from samples.forward_arms.arms import Arm, make_arms
from samples.forward_arms.laws import ActuatorOffset

pytestmark = pytest.mark.slow

SHORT = replace(SETTINGS, base="presliding", seconds=14.0, recordings=1)
SEED = 443
LAWS = ("dry_friction", "linear_cable", "presliding_friction")
FIRST_S = 0.5


@pytest.fixture(scope="module")
def arms() -> list[Arm]:
    """One that begins unbent, and one whose third motor gives more than the log says: friction holds it from the start."""
    return list(make_arms([SEED, SEED], SHORT, [[], [ActuatorOffset(np.array([0.0, 0.0, 2.6, 0.0]))]]))


@pytest.fixture(scope="module")
def recordings(arms: list[Arm]) -> list[DataSet]:
    return [seen(arm, SHORT, 0.03).synchronised(0) for arm in arms]


@pytest.fixture(scope="module")
def unbent(recordings: list[DataSet]) -> Estimates:
    return estimate(recordings[:1], LAWS)


def first_rows(of: Estimates) -> float:
    """RMS of the motors' residuals in the first half second, over that of the others; the largest of all motors."""
    motors = of.solution.residuals[0][: len(of.x0)]
    count = round(FIRST_S * motors.shape[1] / of.seconds[0])
    first, others = (np.sqrt(np.mean(part**2, axis=1)) for part in (motors[:, :count], motors[:, count:]))
    return float(np.max(first / others))


def told(of: Estimates, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Values of a term and their standard deviations."""
    places = [i for i, entry in enumerate(of.unknowns.entries) if entry.term.name == name]
    return of.solution.p[places], of.sigma[places]


def test_how_much_bends_and_over_which_angle_is_found(arms: list[Arm], unbent: Estimates) -> None:
    """Within a hundredth: the generator's bristles are damped a little, those of the law are not."""
    for name, true in (("fp", arms[0].plant.dry), ("wp", arms[0].plant.presliding)):
        value, sigma = told(unbent, name)
        assert np.all(np.abs(value - true) < 3 * sigma + 0.01 * true)


def test_bristles_that_begin_unbent_are_found_so(unbent: Estimates) -> None:
    value, sigma = told(unbent, "bend0")
    assert np.all(np.abs(value) < 0.02)
    assert np.all(sigma < 0.02)


def test_where_they_are_bent_from_the_start_the_first_rows_are_explained_as_well_as_the_others(
    recordings: list[DataSet],
) -> None:
    """Taken for nothing, it leaves newtons until the motor turns."""
    bent, forced = (estimate(recordings[1:], LAWS, held) for held in (None, {"bend0": 0.0}))
    assert first_rows(bent) < 2.0 < first_rows(forced)
