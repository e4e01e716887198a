"""Hysteresis of cables on an arm of the second generator: strands that rub remember a way that cameras see with noise."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.forward_arm_runs import SETTINGS, seen
from diagnosis.diagnose import Diagnosis, diagnose
from identification.dataset.dataset import DataSet
from identification.estimates import DEFAULT_LAWS, estimate
from samples.forward_arms.arms import make_arms
from samples.forward_arms.laws import Hysteresis

pytestmark = pytest.mark.slow

SEED, NOISE_DEG = 451, 0.05
SHORT = replace(SETTINGS, seconds=20.0)
FORCE_N, WIDTH_M = 1.1, 3e-4


@pytest.fixture(scope="module")
def recordings() -> list[DataSet]:
    (arm,) = make_arms([SEED], SHORT, hidden=[(Hysteresis(FORCE_N, WIDTH_M),)])
    there = seen(arm, SHORT, NOISE_DEG)
    return [there.synchronised(i) for i in range(2)]


@pytest.fixture(scope="module")
def found(recordings: list[DataSet]) -> Diagnosis:
    fitted, held_out = recordings
    return diagnose([fitted], [held_out])


def told(found: Diagnosis, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Values of the cause's numbers of a name, and their standard deviations."""
    numbers = [p for p in found.numbers[0] if p.name == name]
    return np.array([p.value for p in numbers]), np.array([p.sigma for p in numbers])


def test_its_numbers_are_those_that_were_hidden(found: Diagnosis) -> None:
    """Along elongations with noise of cameras or encoders strands seem to forget, and their force was told a third too large."""
    assert [cause.effect.name for cause in found.causes] == ["cable_hysteresis"]
    value, sigma = told(found, "h")
    assert np.all(np.abs(value - FORCE_N) < 4 * sigma)
    assert np.all(sigma < 0.1 * FORCE_N)
    width, _ = told(found, "xh")
    assert width == pytest.approx(WIDTH_M, rel=0.15)


def test_what_they_remember_from_before_the_recording_is_no_law_of_time(found: Diagnosis) -> None:
    assert found.found_laws == ()
    assert max(gain.after / gain.noise_floor for gain in found.remainder) < 1.3


@pytest.mark.parametrize("i", [0, 1])
def test_each_recording_alone_identifies_them(recordings: list[DataSet], i: int) -> None:
    """Along elongations as cameras see them `h` came out up to .3 N too large, or at minus three."""
    estimates = estimate([recordings[i]], (*DEFAULT_LAWS, "cable_hysteresis"))
    force = [p for p in estimates.parameters if p.name == "h"]
    assert sum(p.identified for p in force) >= 3
    for p in force:
        assert abs(p.value - FORCE_N) < 4 * p.sigma
    assert estimates.values("xh") == pytest.approx([WIDTH_M], rel=0.1)
