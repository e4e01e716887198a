"""Bend of bristles along a path: against fine steps of its equation, and without a memory of speed."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mechanism.bristles import mean_bend

WIDTH = 0.05
"""rad"""


def path(rng: np.random.Generator, steps: int) -> np.ndarray:
    """Angles (steps + 1, 2), rad, with many reversals and rests."""
    return np.cumsum(rng.normal(size=(steps + 1, 2)) * rng.choice([0.0, 0.01, 0.1], size=(steps + 1, 1)), axis=0)


def test_means_are_those_of_fine_steps_of_the_equation() -> None:
    theta = path(np.random.default_rng(1), 60)
    fine, z, means = 4000, np.zeros(2), []
    for step in np.diff(theta, axis=0):
        within = []
        for _ in range(fine):
            # Heun's step of z' = (theta' - |theta'| z) / width
            def rate(at: np.ndarray, move: np.ndarray = step / fine) -> np.ndarray:
                return (move - np.abs(move) * at) / WIDTH

            first = rate(z)
            after = z + (first + rate(z + first)) / 2
            within.append((z + after) / 2)
            z = after
        means.append(np.mean(within, axis=0))
    np.testing.assert_allclose(mean_bend(theta, WIDTH), means, atol=1e-7)


def test_motors_bend_over_widths_of_their_own() -> None:
    theta = path(np.random.default_rng(2), 80)
    both = mean_bend(theta, np.array([0.02, 0.2]))
    np.testing.assert_array_equal(both[:, 0], mean_bend(theta, 0.02)[:, 0])
    np.testing.assert_array_equal(both[:, 1], mean_bend(theta, 0.2)[:, 1])


@given(st.integers(0, 1000), st.integers(2, 5))
def test_bend_depends_on_the_path_alone(seed: int, parts: int) -> None:
    theta = path(np.random.default_rng(seed), 20)
    slower = np.concatenate(
        [theta[:1], *(theta[i] + np.diff(theta, axis=0)[i] * np.linspace(0, 1, parts + 1)[1:, None] for i in range(20))]
    )
    np.testing.assert_allclose(
        mean_bend(slower, WIDTH).reshape(20, parts, 2).mean(axis=1), mean_bend(theta, WIDTH), atol=1e-9
    )


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_after_many_widths_in_one_direction_friction_slides(direction: float) -> None:
    theta = direction * np.linspace(0, 2.0, 41)[:, None]
    bend = direction * mean_bend(theta, WIDTH)[:, 0]
    assert np.all(np.diff(bend) >= 0)
    assert bend[-1] == pytest.approx(1.0, abs=1e-12)
