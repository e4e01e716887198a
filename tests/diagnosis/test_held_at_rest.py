"""Dry friction that holds joints at rest: named alone, with its numbers, and what it holds is neither noise nor another cause."""

import numpy as np
import pytest

from diagnosis.diagnose import Diagnosis, diagnose
from diagnosis.held_at_rest import held_share
from mechanism.laws import JointMotion, Sliding, law_named
from tests.hidden_arms import STICKING, seen_arms

DRY_N_M = float(STICKING.dry[0])


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    fitted, held_out = (seen_arms()["sticking joints"].synchronised(i) for i in range(2))
    return diagnose([fitted], [held_out])


def test_it_is_the_one_cause(found: Diagnosis) -> None:
    """Speeds are known to some .005 rad/s: at rest a law of speed is off by as much as the friction itself."""
    assert (found.verdict, [c.effect.name for c in found.causes]) == ("cause", ["joint_friction"])
    assert found.found_laws == ()


def test_its_numbers_are_the_hidden_ones(found: Diagnosis) -> None:
    (cause,), (sigma,) = found.causes, found.search.last.sigma_of_causes
    dry, sigma_of_dry = cause.amounts[:3], sigma[:3]
    assert np.all(sigma_of_dry < 0.03 * DRY_N_M)
    assert np.all(np.abs(dry - DRY_N_M) < 4 * sigma_of_dry)


def test_where_joints_rest_any_torque_up_to_its_greatest_is_as_likely(found: Diagnosis) -> None:
    """What is left where it was not fitted is noise; the mean square of what is as likely anywhere in -1 ... 1 is a third."""
    assert all(r.held_out and 0.7 < r.ratio < 1.25 for r in found.remainder)
    assert 0.2 < found.search.fitter.hypothesis.held.joints < 0.45


@pytest.mark.parametrize("share", [0.0, 0.3, 0.8])
def test_the_share_that_is_seen_is_the_one_drawn(share: float) -> None:
    """Of 3 joints a quarter of 2000 rows each: the mean of 1500 squares is known to 3.7 %, of noise as loud to 9 % of a tenth."""
    rng = np.random.default_rng(5)
    square = np.where(rng.random((3, 2000)) < 0.25, 0.01, 1e-5)
    noise = 0.03
    residual = noise * rng.normal(size=square.shape) + np.sqrt(share * square) * rng.normal(size=square.shape)
    assert abs(held_share([residual**2 - noise**2], [square]) - share) < 4 * (0.037 * share + 0.005)


def test_what_is_left_everywhere_is_not_held() -> None:
    """Another cause that is not named yet leaves as much where joints slide."""
    rng = np.random.default_rng(6)
    square = np.where(rng.random((3, 2000)) < 0.25, 0.01, 1e-5)
    assert abs(held_share([0.01 * rng.normal(size=square.shape) ** 2], [square])) < 4 * 0.037 * np.sqrt(4 / 3)


def test_friction_and_what_it_may_hold_beyond_are_no_more_than_its_greatest() -> None:
    speed = np.linspace(-0.2, 0.2, 401)[:, None]
    values = {"cj": np.array([0.05]), "dj": np.zeros(1), "vj": np.array([0.02]), "nj": np.array([4.0])}
    law, at = law_named("joint_friction"), JointMotion(speed, speed)
    held = law.held_torque(values, at)
    assert np.all(np.hypot(law.resistance(values, at), held) < 0.05 * (1 + 1e-9))
    assert held[200, 0] == pytest.approx(0.05)
    assert np.all(held[np.abs(speed) > 0.1] < 0.03 * 0.05)
    cable = {"ma": np.array([0.01]), "vp": np.array([1e-3]), "wm": np.zeros(1)}
    still = law_named("pulley_friction").held_loss(cable, Sliding(*np.array([0.0, 3.0, 0.0])[:, None, None]))
    assert still == pytest.approx(0.03)
