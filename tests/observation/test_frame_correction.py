"""What frames tell of a model that is a little wrong: learned where it comes back, and forgotten where it no longer holds."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from observation.frame_correction import FORGOTTEN_S, FrameCorrection, no_correction

NOISE, LEFT = np.radians(0.02), np.radians(0.1)


Array = NDArray[np.float64]


def one_joint() -> FrameCorrection:
    """Before any frame, of an arm of one joint and two motors."""
    return no_correction(np.zeros(1), np.full(1, 0.3), np.full(1, LEFT), 2)


def standing(beside: float) -> Callable[[Array, Array], Array]:
    """A joint that stands beside the model by the same wherever it is, rad."""
    return lambda alpha, side: np.full(1, beside)


def learned(
    frames: int, error: Callable[[Array, Array], Array], correction: FrameCorrection, first_s: float = 0.0
) -> FrameCorrection:
    """One frame a second of an arm of one joint and two motors whose error is a function of angle and sides."""
    rng = np.random.default_rng(int(first_s))
    for k in range(frames):
        alpha, side = rng.uniform(-0.3, 0.3, 1), rng.choice([-1.0, 1.0], 2)
        beside = error(alpha, side) + NOISE * rng.standard_normal(1)
        correction = correction.corrected(alpha, np.zeros(1), side, beside, np.full(1, 2 * NOISE**2), first_s + k)
    return correction


def test_play_is_told_by_the_sides_of_the_motors() -> None:
    def play(alpha: np.ndarray, side: np.ndarray) -> np.ndarray:
        return LEFT * side[:1] - LEFT / 2 * side[1:]

    told = learned(20, play, one_joint())
    for side in ([1.0, 1.0], [-1.0, 1.0]):
        at = told.at(np.full(1, 0.1), np.zeros(1), np.array(side))
        np.testing.assert_allclose(at, play(np.zeros(1), np.array(side)), atol=0.2 * LEFT)


def test_what_no_longer_holds_is_forgotten() -> None:
    """Joints stand 0.1 deg to the one side for ten minutes, and to the other from then on."""
    before = learned(600, standing(LEFT), one_joint())
    after = learned(int(FORGOTTEN_S), standing(-LEFT), before, 600.0)
    told = [c.at(np.zeros(1), np.zeros(1), np.zeros(2))[0] for c in (before, after)]
    np.testing.assert_allclose(told, [LEFT, -LEFT], atol=0.25 * LEFT)


def test_what_is_settled_is_not_forgotten() -> None:
    before = learned(50, standing(LEFT), one_joint())
    after = learned(50, standing(-LEFT), before.settled(), 600.0)
    np.testing.assert_array_equal(after.coefficients, before.coefficients)
