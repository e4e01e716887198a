"""What counters and loggers do to motor angles is undone where it is certain, and only there."""

import numpy as np
import pytest

from identification.dataset.series import Series, numbered_columns
from mechanism.description import read_neck
from synchronisation.encoder_log import motor_log
from synchronisation.motor_counters import absurd_samples, row_of_reset, unwrapped
from tests.identification.dataset.test_true_rows import moving_log
from tests.paths import SAMPLES
from tests.synchronisation.test_any_log import NECK, truth
from xneck_foundation.recovery import collected_recoveries


@pytest.mark.parametrize("rows", [10, 50, 140])
def test_rows_before_a_drive_found_its_zero_are_left_out(rows: int) -> None:
    """Zeros, or the true motion from another zero: all motors leap in one row, whatever they count from."""
    whole = truth()
    for before in (0.0, whole.matrix("theta")[:rows] + np.array([3.0, -2.0, 5.0, 9.0])):
        theta = whole.matrix("theta").copy()
        theta[:rows] = before
        with collected_recoveries() as said:
            found = motor_log(
                Series(whole.time, {**whole.columns, **numbered_columns("theta", theta)}), NECK, "log.csv"
            )
        np.testing.assert_array_equal(found.matrix("theta"), whole.matrix("theta")[rows:])
        assert any(f"counters were set there; left out: {rows} rows before" in text for text in said)


@pytest.mark.parametrize("case", ["sound", "one motor", "missing rows", "late"])
def test_what_is_no_reset_of_all_counters_leaves_the_log_whole(case: str) -> None:
    whole = truth()
    theta = whole.matrix("theta").copy()
    if case == "one motor":
        theta[:50, 2] = 0.0
    elif case == "late":
        theta[:700] = 0.0
    kept = np.delete(np.arange(len(whole)), slice(50, 80)) if case == "missing rows" else np.arange(len(whole))
    assert row_of_reset(whole.time[kept], theta[kept]) == 0


def test_a_counter_is_unwrapped_only_where_it_is_certain() -> None:
    motor = read_neck(SAMPLES / "recording/neck.yaml").motors[0]
    time = np.arange(0, 20, 0.002)
    theta = 30 * np.sin(time) + 5 * np.sin(3.1 * time)
    for period, low in ((2 * np.pi, 0.0), (2 * np.pi, -np.pi), (65536.0, -32768.0)):
        unit = period / (2 * np.pi)
        counter = unwrapped(((theta * unit - low) % period + low).astype(np.float64), motor)
        moved = np.diff(counter.values)
        assert counter.period == pytest.approx(period)
        np.testing.assert_allclose(moved, unit * np.diff(theta), atol=1e-6 * unit)
    assert unwrapped(theta, motor).wraps == 0
    slow = slice(None, None, 60)  # 0.12 s: by up to 4 rad from row to row
    assert unwrapped(theta[slow] % (2 * np.pi), motor).ambiguous
    # a motor at rest flips between counts, and a jump to anywhere is no wrap
    assert unwrapped((np.arange(5000) // 1000 % 2).astype(np.float64), motor).wraps == 0
    jumped = np.where(time < 10, theta, theta + 1e6)
    assert unwrapped(jumped, motor).wraps == 0


def test_a_sample_that_its_neighbours_contradict_is_found_and_no_other() -> None:
    time = np.arange(0, 20, 0.002)
    theta = np.round(30 * np.sin(time) / 0.003) * 0.003
    spoiled = theta.copy()
    spoiled[[100, 7000]] = [1e6, 0.0]
    assert np.flatnonzero(absurd_samples(spoiled, 0.02)).tolist() == [100, 7000]
    assert not absurd_samples(theta, 0.02).any()
    for begin, end in ((0, 1), (len(theta) - 1, len(theta)), (300, 305)):
        spoiled = theta.copy()
        spoiled[begin:end] = 1e6
        assert np.flatnonzero(absurd_samples(spoiled, 0.02)).tolist() == list(range(begin, end))
    spoiled = theta.copy()
    spoiled[::97] = -1e6
    assert np.flatnonzero(absurd_samples(spoiled, 0.02)).tolist() == list(range(0, len(theta), 97))
    slipped = theta + np.where(time > 10, 5.0, 0.0)
    assert not absurd_samples(slipped, 0.02).any()


def test_a_pause_of_the_logger_is_no_reset_of_counters() -> None:
    """After a fifth of a second of one row all motors leap as nowhere else. Zeros from the first row on are a reset."""
    log = moving_log()
    theta = log.matrix("theta").copy()
    theta[1000:1100] = theta[1000]
    assert row_of_reset(log.time, theta) == 0
    theta = log.matrix("theta") + 30.0
    theta[:300] = 0.0
    assert row_of_reset(log.time, theta) == 300
