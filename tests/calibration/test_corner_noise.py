"""The noise of corners in pixels, by both of its estimators, on distances that are drawn: it sets the knee of the robust loss."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from calibration.bundle_adjustment import fit_noise
from calibration.bundle_problem import BundleProblem
from calibration.corner_noise import corner_noise
from calibration.stacked_views import StackedViews

NOISE = 0.3
ROWS, COLUMNS, VIEWS = 14, 20, 12
BOARD = (
    np.stack([*np.meshgrid(np.arange(COLUMNS), np.arange(ROWS)), np.zeros((ROWS, COLUMNS))], axis=-1).reshape(-1, 3)
    * 0.02
)
MARGIN = 4 * 1.17 / np.sqrt(VIEWS * ROWS * COLUMNS)
"""four standard deviations of a median distance of so many corners, as a share of it"""


def views() -> StackedViews:
    """A board seen through homographies with a bend."""
    rng = np.random.default_rng(3)
    pixels = []
    for _ in range(VIEWS):
        unit = BOARD[:, :2] / np.ptp(BOARD[:, :2], axis=0)
        depth = 1 + unit @ rng.uniform(-0.2, 0.2, 2)
        plane = (unit / depth[:, None]) @ (500 * np.eye(2) + rng.uniform(-60, 60, (2, 2))) + 40
        bent = plane + 3 * unit**2 @ rng.uniform(-1, 1, (2, 2))
        pixels.append(bent + rng.normal(0, NOISE, bent.shape))
    shown = np.ones((VIEWS, len(BOARD)), dtype=bool)
    return StackedViews(np.arange(len(BOARD)), BOARD, np.array(pixels), shown)


def test_noise_told_without_a_camera_is_the_noise() -> None:
    assert corner_noise(views()) == pytest.approx(NOISE, rel=MARGIN + 0.01)


def test_noise_told_by_a_fit_is_that_of_one_coordinate() -> None:
    """Distances of two normal coordinates: half are within 1.1774 sigma. Corners that are not visible have none."""
    distances = np.linalg.norm(np.random.default_rng(0).normal(0, NOISE, (VIEWS, ROWS * COLUMNS, 2)), axis=2)
    visible = np.random.default_rng(1).random(distances.shape) < 0.7
    fitted: Any = SimpleNamespace(distances=np.where(visible, distances, 0.0), visible=visible)
    assert fit_noise(fitted) == pytest.approx(NOISE, rel=MARGIN / np.sqrt(0.7))


def test_the_knee_is_three_sigmas_of_a_coordinate_and_leaves_one_corner_in_ninety() -> None:
    """exp(-9/2) = 1.1 % of distances are beyond."""
    problem = BundleProblem(views(), (), None, NOISE)  # type: ignore[arg-type]
    assert problem.knee == pytest.approx(0.9)
    distances = np.linalg.norm(np.random.default_rng(0).normal(0, NOISE, (100_000, 2)), axis=1)
    assert np.mean(distances > problem.knee) == pytest.approx(np.exp(-4.5), rel=4 / np.sqrt(1111))
