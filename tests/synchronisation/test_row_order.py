"""Rows that a recorder left a little out of order, or twice, are put right; what is more than that is not."""

import re
from collections.abc import Callable

import numpy as np
import pytest

from identification.dataset.series import Series
from synchronisation.encoder_log import motor_log
from synchronisation.log_contents import LogContents
from synchronisation.log_mapping import map_log
from synchronisation.row_order import MAX_ROWS_BACK, kept_rows
from tests.synchronisation.test_any_log import NECK, ROWS, truth
from tests.synchronisation.test_foreign_topics import LOG, WINCHES, JointStateChannel
from xneck.watch.log_findings import time_finding
from xneck_foundation.errors import Refused
from xneck_foundation.recovery import collected_recoveries

AS_SAMPLED = np.arange(ROWS)


def moved(row: int, by: int) -> np.ndarray:
    """Rows, one of which stands further behind."""
    return np.insert(np.delete(AS_SAMPLED, row), row + by, row)


SMALL: dict[str, tuple[np.ndarray, str]] = {
    "exchanged": (moved(100, 1), "1 row stood behind later ones: put where their times belong"),
    "late": (moved(100, MAX_ROWS_BACK), "1 row stood behind later ones"),
    "the first": (moved(0, 2), "1 row stood behind later ones"),
    "often": (AS_SAMPLED.reshape(-1, 20)[:, [1, 0, *range(2, 20)]].ravel(), "75 rows stood behind"),
    "twice": (np.insert(AS_SAMPLED, 500, 499), "1 row repeated another, its time too: left out"),
    "twice, apart": (np.insert(AS_SAMPLED, 500, 496), "1 row repeated another, its time too: left out"),
}


@pytest.mark.parametrize("case", SMALL)
def test_a_small_disorder_is_put_right(case: str) -> None:
    rows, says = SMALL[case]
    with collected_recoveries() as said:
        found = motor_log(truth().part(rows), NECK, "log.csv")
    np.testing.assert_array_equal(found.time, truth().time)
    np.testing.assert_array_equal(found.matrix("theta"), truth().matrix("theta"))
    assert len(said) == 1
    assert re.search(says, said[0])
    channel = truth().part(rows)
    topic = JointStateChannel(WINCHES, channel.time, channel.matrix("theta"), channel.matrix("f"))
    assert map_log(LOG, LogContents(topics={"joint_states": topic}), NECK.M).rate == pytest.approx(500)
    assert time_finding(channel, "log.csv") is None


def stamped_late(series: Series) -> Series:
    """One stamp is wrong, by 2.3 steps: the place that it names is not empty."""
    time = series.time.copy()
    time[700] += 0.0046
    return Series(time, series.columns)


LARGE: dict[str, tuple[Callable[[Series], Series], str]] = {
    "too late": (lambda s: s.part(moved(100, MAX_ROWS_BACK + 1)), "time jumps back in row 112"),
    "pieces exchanged": (lambda s: s.part(np.roll(AS_SAMPLED, 500)), "time begins again|time jumps back"),
    "a stamp that is wrong": (stamped_late, "time jumps back in row 702"),
    "another row with its time": (
        lambda s: Series(np.where(AS_SAMPLED == 700, s.time[699], s.time), s.columns),
        "time stands still in row 701",
    ),
    "all twice": (lambda s: s.part(np.repeat(AS_SAMPLED, 2)), "50 % of its rows repeat the one before"),
}


@pytest.mark.parametrize("case", LARGE)
def test_a_disorder_that_is_not_small_is_refused(case: str) -> None:
    change, says = LARGE[case]
    with pytest.raises(Refused, match=says):
        motor_log(change(truth()), NECK, "log.csv")


def test_rows_behind_one_that_was_left_out_keep_their_numbers() -> None:
    wrong = truth().part(np.insert(AS_SAMPLED, 500, 499))
    wrong.columns["theta2"][1000] = np.nan
    with collected_recoveries(), pytest.raises(Refused, match="theta2 is not a number in row 1001"):
        motor_log(wrong, NECK, "log.csv")


def test_an_empty_cell_repeats_an_empty_one_and_no_number() -> None:
    nan = np.nan
    columns = {"theta1": np.array([1.0, 2.0, 2.0, 3.0, 3.0]), "led": np.array([0.0, nan, nan, nan, 1.0])}
    assert kept_rows(Series(np.array([0.0, 1.0, 1.0, 2.0, 2.0]), columns)).tolist() == [0, 1, 3, 4]


def test_nothing_is_said_of_rows_in_order() -> None:
    with collected_recoveries() as said:
        motor_log(truth(), NECK, "log.csv")
    assert not said
