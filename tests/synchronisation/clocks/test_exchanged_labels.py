"""What is exchanged or turned over is said once, not motor by motor where it is all of them."""

import numpy as np
import pytest

from synchronisation.clocks.exchanged_labels import ALL_AGAINST, exchange_words

UPRIGHT = np.ones(2)


@pytest.mark.parametrize(
    ("signs", "pairs", "words"),
    [
        (UPRIGHT, [(0, -1), (1, -1), (2, -1)], [ALL_AGAINST]),
        (-UPRIGHT, [(0, 1), (1, 1), (2, 1)], [ALL_AGAINST]),
        (UPRIGHT, [(0, 1), (1, -1), (2, 1)], ["theta2 runs against the camera (theta_sign of motors[1])"]),
        (UPRIGHT, [(1, 1), (0, 1), (2, 1)], ["theta1 and theta2 are swapped"]),
        (UPRIGHT, [(0, 1), (1, 1), (2, 1)], []),
    ],
)
def test_each_is_said_once(signs: np.ndarray, pairs: list[tuple[int, int]], words: list[str]) -> None:
    assert exchange_words((0, 1), signs, pairs) == words
