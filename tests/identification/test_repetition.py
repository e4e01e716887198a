"""How much a motion resembles itself, by motions of which that is known."""

import numpy as np
import pytest

from identification.design.repetition import likeness_to_itself

TIME = np.arange(0.0, 40.0, 0.02)


def test_a_motion_that_repeats_is_wholly_like_itself() -> None:
    wave = np.sin(2 * np.pi * 0.3 * TIME) + 0.5 * np.cos(2 * np.pi * 0.9 * TIME)
    assert likeness_to_itself(np.stack([wave, -wave], axis=1)) == pytest.approx(1.0, abs=1e-3)


def test_two_waves_of_no_common_period_are_alike_as_their_cosines_add_up() -> None:
    """Of equal energy, of 0.31 and 0.5 Hz, over 20 s: the mean of both cosines of the lag, at its greatest past its first zero."""
    waves = np.stack([np.sin(2 * np.pi * hertz * TIME) for hertz in (0.31, 0.5)], axis=1)
    lags = np.arange(0.0, 20.0, 0.02)
    mean = (np.cos(2 * np.pi * 0.31 * lags) + np.cos(2 * np.pi * 0.5 * lags)) / 2
    expected = mean[np.flatnonzero(mean < 0)[0] :].max()
    assert likeness_to_itself(waves) == pytest.approx(expected, abs=0.03)


def test_noise_is_not_like_itself() -> None:
    assert abs(likeness_to_itself(np.random.default_rng(1).normal(size=(2000, 3)))) < 0.15
