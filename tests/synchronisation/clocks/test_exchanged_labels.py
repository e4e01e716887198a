"""What is exchanged or turned over is said once, not motor by motor where it is all of them."""

import re

import numpy as np
import pytest

from mechanism.arm import arm_of
from synchronisation.clocks.coarse_alignment import CoarseAlignment, cable_speeds
from synchronisation.clocks.exchanged_labels import ALL_AGAINST, _refuse_loose_cables, check_labels, exchange_words
from synchronisation.clocks.frame_geometry import cable_winding
from tests.mechanism.test_neck_template import described
from xneck_foundation.errors import Refused

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


@pytest.mark.parametrize(
    ("order", "signs", "words"),
    [
        ([0, 1, 2, 3, 4, 5], -1, "log and video do not fit: " + re.escape(ALL_AGAINST)),
        ([0, 2, 1, 3, 4, 5], 1, "theta2 and theta3 are swapped"),
    ],
)
def test_cables_that_mirror_each_other_are_not_called_swapped_where_all_run_the_other_way(
    order: list[int], signs: int, words: str
) -> None:
    """Cables over struts on either side run against each other but for little, which stretch that both share hides."""
    arm = arm_of(described(2, 6))
    rng = np.random.default_rng(0)
    time = np.arange(0, 24, 1 / 30)
    hertz, phase = rng.uniform(0.1, 1.2, (2, 8)), rng.uniform(0, 2 * np.pi, (2, 8))
    alpha = 0.08 * np.sin(2 * np.pi * time[:, None, None] * hertz + phase).sum(axis=-1)
    winding = cable_winding(arm, alpha)
    logged = signs * winding[:, order]
    logged[:, [1, 3]] -= signs * 0.6 * (winding[:, [1]] + winding[:, [3]])
    video, log = cable_speeds(time, winding), cable_speeds(time, logged)
    wrong = np.full(6, -1.0)
    alignment = CoarseAlignment(0.0, -1.0, 0.0, wrong, wrong, np.zeros(6), (0.0, 24.0))
    with pytest.raises(Refused, match=words):
        check_labels(arm, time, alpha, video, log, alignment)


@pytest.mark.parametrize(
    ("each", "words"),
    [
        (
            [0.97, 0.52, 0.79],
            r"cable 2 hardly follows its motor \(correlation 0.52, of all together 0.94\); a cable that stretches",
        ),
        ([0.55, 0.52, 0.97], r"cable 1, cable 2 hardly follow their motors \(correlation 0.52, of all"),
    ],
)
def test_cables_that_follow_half_are_named_and_the_motion_is_not_doubted(each: list[float], words: str) -> None:
    """Soft cables in a small motion: log and video are of one recording, by what all of them do together."""
    cables = np.array(each)
    alignment = CoarseAlignment(0.0, 0.94, 0.3, cables, cables, np.zeros(3), (0.0, 20.0))
    with pytest.raises(Refused, match=words):
        _refuse_loose_cables(alignment, np.ones(3, dtype=bool))
