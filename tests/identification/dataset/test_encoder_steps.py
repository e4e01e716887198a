"""Steps of motor angles are those of the encoder that wrote them, whatever the motion; what is not counted has none."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from identification.dataset.encoder_steps import count_angles, measured_steps
from identification.dataset.series import Series, numbered_columns
from mechanism.description import Neck, read_neck
from samples.worlds.clock_worlds import NECK_FILE
from synchronisation.encoder_counts import counts_warnings

Array = NDArray[np.float64]
NECK = read_neck(NECK_FILE)
ROWS, STEP_S = 15_000, 2e-3
COUNT = 2 * np.pi / 2048


def motion(seed: int, rad_s: float, motors: int = 1) -> Array:
    """A motor that turns to and fro, as fast as that at most, (ROWS, motors), rad; nothing is counted."""
    rng = np.random.default_rng(seed)
    time = STEP_S * np.arange(ROWS)[:, None]
    hz = rng.uniform(0.1, 0.5, (6, motors))
    waves = [
        rad_s / (6 * 2 * np.pi * f) * np.sin(2 * np.pi * f * time + p)
        for f, p in zip(hz, rng.uniform(0, 6, hz.shape), strict=True)
    ]
    return np.asarray(np.sum(waves, axis=0), dtype=np.float64)


def log_of(theta: Array) -> Series:
    return Series(np.linspace(0, STEP_S * (len(theta) - 1), len(theta)), numbered_columns("theta", theta))


def described(counts: int) -> Neck:
    return NECK.with_({f"motors[{j}].counts": counts for j in range(NECK.M)})


@given(
    seed=st.integers(0, 50),
    rad_s=st.floats(0.3, 60.0),
    step=st.floats(2e-4, 0.02),
    offset=st.floats(-5.0, 5.0),
    decimals=st.sampled_from([6, 9, None]),
)
def test_the_step_is_the_one_that_was_counted_in(
    seed: int, rad_s: float, step: float, offset: float, decimals: int | None
) -> None:
    counted = offset + step * np.floor(motion(seed, rad_s) / step)
    logged = counted if decimals is None else np.round(counted, decimals)
    found = measured_steps(logged)[0]
    if rad_s * STEP_S < 5 * step < 0.01:  # slow enough to go by single steps
        assert found == pytest.approx(step, rel=2e-3)
    else:  # half a step would say that it is finer than it is
        assert np.isnan(found) or abs(found / step - 1) < 2e-3


@pytest.mark.parametrize("rad_s", [0.5, 30.0])
def test_what_is_not_counted_has_no_step(rad_s: float) -> None:
    theta = motion(3, rad_s)
    even = np.linspace(0, rad_s * STEP_S * ROWS, ROWS)[:, None]
    noisy = theta + 1e-4 * np.random.default_rng(0).standard_normal(theta.shape)
    still = np.zeros((ROWS, 1))
    assert np.isnan(measured_steps(np.hstack([theta, even, noisy, still]))).all()


def test_the_log_says_in_which_steps_it_is_written() -> None:
    """Four edges to a line are believed, and what is coarser; the steps that a filter leaves are not the encoder's."""
    theta = motion(5, 20.0, NECK.M)
    whole = COUNT * np.floor(theta / COUNT)
    quarter = COUNT / 4 * np.floor(4 * theta / COUNT)
    for counted, of_lines, step in (
        (whole, 2048, COUNT),
        (quarter, 2048, COUNT / 4),
        (whole, 8192, COUNT),
        (np.round(theta, 1), 2048, 0.1),
        (theta, 2048, COUNT),
    ):
        np.testing.assert_allclose(count_angles(described(of_lines), log_of(counted)), step, rtol=1e-3)
    filtered = np.convolve(whole[:, 0], np.full(5, 0.2), "valid")[:, None].repeat(NECK.M, axis=1)
    np.testing.assert_allclose(measured_steps(filtered), COUNT / 5, rtol=1e-3)
    np.testing.assert_allclose(count_angles(described(2048), log_of(filtered)), COUNT)
    no_motors = Series(np.arange(5.0), {})
    np.testing.assert_allclose(count_angles(described(2048), no_motors), COUNT)


def test_a_description_of_lines_is_named() -> None:
    theta = motion(6, 20.0, NECK.M)
    quarter = log_of(COUNT / 4 * np.floor(4 * theta / COUNT))
    assert counts_warnings(described(8192), quarter) == ()
    (words,) = counts_warnings(described(2048), quarter)
    assert "theta1 moves in steps of 0.000767 rad (as 4 motors do)" in words
    assert "8192 to a turn, where neck.yaml has counts: 2048; its noise" in words
    assert words.endswith(": write counts: 8192 there")
    one = NECK.with_({"motors[2].counts": 1000})
    (words,) = counts_warnings(one, log_of(COUNT * np.floor(theta / COUNT)))
    assert "theta3 moves in steps of 0.003068 rad, 2048 to a turn, where neck.yaml has counts: 1000" in words
    (words,) = counts_warnings(described(2048), log_of(np.round(theta, 1)))
    assert (
        "steps of 0.1 rad (as 4 motors do), 32.6 counts of neck.yaml; its noise is taken to be of these: does the log round"
        in words
    )
