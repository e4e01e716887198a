"""The clock at unusual rates of camera and log: its errors are of the size of its sigma at every rate."""

from dataclasses import replace

import numpy as np
import pytest

from identification.dataset.series import Series
from samples.worlds.clock_worlds import arm, clock_recording
from synchronisation.clocks.clock import fit_clock
from synchronisation.clocks.gauss_newton_step import NormalEquations
from synchronisation.clocks.log_gaps import repair_log
from synchronisation.clocks.motion_clock import stamped_period


@pytest.mark.parametrize(
    ("log_hz", "frame_hz", "limit_ms"),
    [(500.0, 5.0, 0.4), (500.0, 10.0, 0.25), (500.0, 240.0, 0.08), (50.0, 30.0, 0.15), (100.0, 30.0, 0.15)],
)
def test_a_slow_camera_a_fast_one_and_a_slow_log_give_a_clock(log_hz: float, frame_hz: float, limit_ms: float) -> None:
    """Two arms of 30 s each. Frames of 5 a second had been gaps to the arm's equation, and clocks erred by 8 ms; a log of 50 rows a
    second had been nothing but gaps; forces of 50 or 100 Hz jump with the friction that is computed of such a log only where both
    are means over the same rows (0.5 to 1.4 ms, three to five sigmas, where they were not)."""
    for kind, seed in (("linear elastic", 3003), ("everything", 3001)):
        made = clock_recording(kind, seed, 30.0, log_hz=log_hz, frame_hz=frame_hz)
        clock = fit_clock(arm(), made.angles, made.log)
        true = made.clocks.offset_s + made.clocks.skew * (clock.middle - made.clocks.middle_s)
        assert abs(clock.offset - true) < 3.5 * clock.offset_sigma
        assert clock.offset_sigma < 1e-3 * limit_ms
        assert not clock.lost.losses
        assert not clock.warnings


def test_rows_of_a_slow_log_are_no_gaps_and_a_missing_one_is() -> None:
    log = clock_recording("linear elastic", 3003, 8.0, log_hz=50.0).log
    assert repair_log(log).gaps == ()
    kept = np.arange(len(log)) != 200
    cut = repair_log(log.part(kept))
    assert cut.gaps == ((log.time[199], log.time[201]),)
    assert cut.missing_rows == 1


@pytest.mark.parametrize("hz", [500.0, 300.0])
def test_stamps_of_whole_milliseconds_that_jitter_miss_no_rows_and_lost_rows_are_counted(hz: float) -> None:
    """Stamps that are late by up to half a period: steps of 1, 2 and 3 ms at 500 Hz."""
    rng = np.random.default_rng(0)
    time = np.unique(np.rint(1e3 * (np.arange(6000) + rng.uniform(0, 0.5, 6000)) / hz)) / 1e3
    turned = {f"theta{j}": np.sin(j * time) for j in (1, 2)}
    log = Series(time, turned)
    assert len(log) == 6000
    assert repair_log(log).missing_rows == 0
    kept = ~np.isin(np.arange(6000), [1000, 2000, 2001, 2002, 2010, 4000])
    assert repair_log(log.part(kept)).missing_rows == 6


def test_the_period_is_as_exact_as_the_stamps_allow() -> None:
    """A loss is taken for one period: 50 losses with the median's error of 1 to 3e-5 s had been a skew of some 30 ppm."""
    made = clock_recording("linear elastic", 3003, 30.0)
    kept = np.random.default_rng(1).random(len(made.angles.time)) > 0.05
    a = made.angles
    thinned = replace(a, time=a.time[kept], alpha=a.alpha[kept], sigma=a.sigma[kept])
    assert stamped_period(a) == pytest.approx(1 / 30, abs=4e-6)
    assert stamped_period(thinned) == pytest.approx(1 / 30, abs=8e-6)


def test_sigma_does_not_shrink_with_the_number_of_unknowns() -> None:
    """Straight least squares of 40 blocks of 6 rows with 60 unknowns: the first unknown's true variance, and not three quarters of
    it, as residuals without the jackknife would have it."""
    rng = np.random.default_rng(0)
    J = rng.normal(size=(40, 6, 60))
    flat = J.reshape(-1, 60)
    information = flat.T @ flat
    true = np.linalg.inv(information)[0, 0]
    stated = []
    for _ in range(200):
        noise = rng.normal(size=240)
        residual = (noise - flat @ np.linalg.solve(information, flat.T @ noise)).reshape(40, 6)
        scores = np.einsum("brp,br->bp", J, residual)
        products = np.einsum("brp,brq->bpq", J, J)
        equations = NormalEquations(scores, products, information, np.zeros(60), np.ones(60))
        stated.append(equations.covariance(1)[0, 0])
    assert 0.95 * true < np.mean(stated) < 1.6 * true
