"""Frames of one noise keep one variance, frames of several get their own."""

import numpy as np
import pytest

from tests.vision.linkage.test_error_components import FRAMES, fitted, with_errors
from tests.vision.linkage.test_linkage_fit import motion
from vision.moderated_variance import moderated_variances

FREEDOM = 29.0


def squares(variance: np.ndarray, seed: int) -> np.ndarray:
    """Sums of FREEDOM squares of normal numbers of these variances (F,)."""
    rng = np.random.default_rng([43, seed])
    return np.sum(rng.normal(0, 1, (len(variance), int(FREEDOM))) ** 2, axis=1) * variance


def test_equal_frames_have_one_variance() -> None:
    """By itself a frame would tell its variance to 26 %."""
    told = moderated_variances(squares(np.full(400, 2.0), 0), np.full(400, FREEDOM))
    usual = np.sort(told)[:-20]  # one frame in a hundred stands out by chance
    assert usual == pytest.approx(2.0, rel=0.12)


def test_pictures_of_two_kinds_have_a_variance_each() -> None:
    """Every third picture has a quarter of the variance: the mean of each kind is right to 15 %."""
    true = np.where(np.arange(400) % 3 == 0, 0.25, 1.0)
    told = moderated_variances(squares(true, 1), np.full(400, FREEDOM))
    for kind in (0.25, 1.0):
        assert told[true == kind].mean() == pytest.approx(kind, rel=0.25 if kind < 1 else 0.1)


def test_a_frame_that_stands_out_is_taken_by_itself() -> None:
    true = np.ones(400)
    true[200] = 25.0
    told = moderated_variances(squares(true, 2), np.full(400, FREEDOM))
    assert told[200] == pytest.approx(25.0, rel=0.5)
    assert np.median(told) == pytest.approx(1.0, rel=0.05)


def test_frames_without_residuals_have_the_variance_of_all() -> None:
    freedom = np.where(np.arange(400) < 10, 0.0, FREEDOM)
    told = moderated_variances(np.where(freedom > 0, squares(np.full(400, 3.0), 3), 0.0), freedom)
    assert told[:10] == pytest.approx(3.0, rel=0.1)


def test_sigma_of_angles_follows_the_kind_of_picture() -> None:
    """Corners of every third frame err half as much as the others': z of either kind is one to 20 %."""
    small, large = with_errors(8, 0, 0, 0, 1.0), with_errors(8, 0, 0, 0, 2.0)
    fine = np.arange(FRAMES) % 3 == 0
    fit = fitted(np.where(fine[:, None, None, None], small, large))
    assert fit.noise is not None
    error = fit.alpha - motion(FRAMES)
    z = error / np.sqrt(np.diagonal(fit.noise, axis1=1, axis2=2))
    for kind in (fine, ~fine):
        assert np.sqrt(np.mean(z[kind] ** 2)) == pytest.approx(1.0, abs=0.2)
