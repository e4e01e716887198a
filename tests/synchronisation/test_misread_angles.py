"""What a tracker writes where it saw nothing, or took a marker for turned, is no angle."""

import numpy as np
import pytest
from numpy.typing import NDArray

from identification.dataset.series import Series, numbered_columns
from synchronisation.angles import checked_angles
from synchronisation.misread_angles import marks_of_nothing, misread
from xneck_foundation.errors import Refused
from xneck_foundation.recovery import Recovered

Array = NDArray[np.float64]

FRAMES, RATE_HZ = 900, 30.0
TIME = np.arange(FRAMES) / RATE_HZ
RNG = np.random.default_rng(11)
SOME = np.sort(RNG.choice(np.arange(2, FRAMES - 2), 60, replace=False))


def angles(speed: float = 1.0) -> Array:
    """Of three joints, rad, that pass zero often, up to 0.7 rad/s."""
    phases = 2 * np.pi * speed * np.array([0.21, 0.17, 0.13]) * TIME[:, None] + [0.3, 1.1, 2.0]
    return 0.5 * np.sin(phases) + 0.1 * np.sin(3.3 * phases) + RNG.normal(0, 5e-4, (FRAMES, 3))


def read(alpha: Array) -> Array:
    return checked_angles(Series(TIME, numbered_columns("alpha", alpha)), 3, "a.csv", {}).alpha


@pytest.mark.parametrize("mark", [0.0, -1.0])
def test_marks_are_not_seen_and_the_rest_stays(mark: float) -> None:
    alpha = angles()
    marked = alpha.copy()
    marked[SOME] = mark
    with pytest.warns(Recovered, match=f"{mark:g} stands for all angles in 60 frames .the first in row {SOME[0] + 1}."):
        seen = read(marked)
    expected = alpha.copy()
    expected[SOME] = np.nan
    np.testing.assert_array_equal(seen, expected)


@pytest.mark.parametrize("turn", [np.pi / 2, np.pi, -np.pi / 2])
def test_a_marker_taken_for_turned_is_left_out(turn: float) -> None:
    alpha = angles()
    turned = alpha.copy()
    turned[SOME[::3], 1] += turn
    with pytest.warns(Recovered, match=rf"20 angles jump away .* alpha2 of .* in row {SOME[0] + 1}"):
        seen = read(turned)
    assert np.isnan(seen).sum() == 20
    np.testing.assert_array_equal(seen[~np.isnan(seen)], alpha[~np.isnan(seen)])


def test_an_arm_at_rest_at_zero_fast_ones_and_rounded_angles_stay_as_they_are() -> None:
    for alpha in (np.round(angles(), 2), angles(speed=12.0), np.round(angles(0.05), 1)):
        assert not marks_of_nothing(alpha)
        assert not misread(alpha).any()
    resting = angles()
    resting -= resting[300]
    resting[:300] = 0.0
    assert not marks_of_nothing(resting)


def test_angles_of_which_few_are_beyond_pi_are_no_degrees() -> None:
    """A marker that was taken for turned for a second is no jump and back."""
    alpha = angles()
    alpha[400:430, 0] += np.pi
    with pytest.raises(Refused, match=r"alpha1 in row 4\d\d, and few others; leave angles blank"):
        read(alpha)
    with pytest.raises(Refused, match="these are degrees"):
        read(np.degrees(angles()))
