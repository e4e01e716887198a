"""What the arm did before a row: sides of the motors as play would have them, and speed, kept where a joint turns round."""

import numpy as np
import pytest

from identification.dataset.series import Series
from observation.observed_log import observe_log
from observation.recent_motion import SIDE_TRAVEL_M, no_motion
from tests.observation.arms import SEEDS, SETTLED, case
from xneck_foundation.recovery import Recovered


def test_a_motor_is_on_the_side_to_which_it_turned_for_as_long_as_play_is_wide() -> None:
    motion, half = no_motion(2), SIDE_TRAVEL_M / 2
    for travel, expected in (([half, 0], [1, 0]), ([half, -half / 2], [1, -0.5]), ([-half, -half], [0, -1])):
        motion = motion.after(np.zeros(3), np.array(travel), 0.002)
        np.testing.assert_allclose(motion.sides, expected, atol=1e-12)


def test_speed_is_forgotten_within_a_second() -> None:
    motion = no_motion(1)
    for _ in range(5000):
        motion = motion.after(np.array([3.0, 4.0]), np.zeros(1), 0.002)
    assert motion.mean_square == pytest.approx(25.0, rel=1e-3)
    for _ in range(500):
        motion = motion.after(np.zeros(2), np.zeros(1), 0.002)
    assert motion.mean_square == pytest.approx(25.0 / np.e, rel=1e-2)


def test_rates_are_no_surer_where_joints_turn_round() -> None:
    """Of what calibration left of them sigma holds the whole in motion, however slowly joints go in that row."""
    of, rate = case(SEEDS[0]), np.radians(0.8)
    assert of.model.pose is not None
    left = of.model.pose.residual.model_copy(update={"rate_rad_s": (rate,) * 3, "slope": (0.01,) * 3})
    model = of.model.model_copy(update={"pose": of.model.pose.model_copy(update={"residual": left})})
    seen = observe_log(of.neck, model, of.log.part(slice(0, 3000))).series
    sigma = seen.matrix("sigma_alpha", "_d")[SETTLED:]
    moves = np.abs(of.alpha_d).max(axis=1)[SETTLED : SETTLED + len(sigma)] > 0.3
    assert moves.mean() > 0.5
    assert sigma[moves].min() > 0.9 * rate


def test_rows_that_repeat_the_one_before_are_left_out_in_python_too() -> None:
    """Half a second in which the controller wrote the same row again: no angle is made of it."""
    of = case(SEEDS[0])
    log = of.log.part(slice(0, 2000))
    held = {name: np.where(np.arange(2000) // 250 == 4, column[1000], column) for name, column in log.columns.items()}
    with pytest.warns(Recovered, match="249 rows repeat the one before"):
        seen = observe_log(of.neck, of.model, Series(log.time, held))
    assert (len(seen.series), seen.restarts) == (2000 - 249, 1)
    kept = np.isin(log.time, seen.series.time)
    error = np.degrees(np.abs(seen.series.matrix("alpha") - of.alpha[:2000][kept]))
    assert np.delete(error[SETTLED:], slice(1001 - SETTLED, 1101 - SETTLED), axis=0).max() < 0.1
