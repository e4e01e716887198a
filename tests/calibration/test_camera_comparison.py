"""How often a camera that did not change is called changed: changes drawn from the very covariance that the test is told."""

import numpy as np
import pytest
from scipy.stats import binom

from calibration.camera_comparison import CHANGE_KINDS, CameraComparison
from calibration.lens import PARAMETER_NAMES
from tests.calibration.test_camera_check import calibrated

DRAWS = 800
NAMED = [name for name in PARAMETER_NAMES if name != "k3"]


def comparisons(scale: float) -> list[CameraComparison]:
    """Of changes with a standard deviation `scale` times the one that is told, which is known exactly."""
    camera, rng = calibrated(0)
    index = [PARAMETER_NAMES.index(name) for name in NAMED]
    assert camera.covariance is not None
    covariance = camera.covariance[np.ix_(index, index)]
    size = np.sqrt(np.diag(covariance))
    weight = np.linalg.inv(covariance / np.outer(size, size)) / np.outer(size, size)
    draws = rng.multivariate_normal(np.zeros(len(index)), scale**2 * covariance, DRAWS)
    return [
        CameraComparison(camera=camera, free=tuple(NAMED), change=draw, weight=weight, freedom=1e6) for draw in draws
    ]


@pytest.mark.parametrize("level", [0.05, 0.2])
def test_false_alarms_are_as_rare_as_they_are_said_to_be(level: float) -> None:
    """Five tests of one change: the most extreme of five is not taken for one. They are related, so alarms are fewer than said,
    but not fewer than of any single test, which has a fifth."""
    every = comparisons(1.0)
    alarms = sum(comparison.significance() < level for comparison in every)
    assert alarms <= binom.isf(1e-4, DRAWS, level)
    assert alarms >= binom.ppf(1e-4, DRAWS, level / len((*CHANGE_KINDS, CHANGE_KINDS)))
    # the control: the most extreme of five taken for the only one
    best = [min(c.probability(kinds) for kinds in (*((k,) for k in CHANGE_KINDS), CHANGE_KINDS)) for c in every]
    assert np.sum(np.array(best) < level) > binom.isf(1e-4, DRAWS, level)


def test_larger_changes_are_alarms() -> None:
    assert np.mean([comparison.significance() < 0.05 for comparison in comparisons(5.0)]) > 0.95
