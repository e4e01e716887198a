"""The shared filters: a lag against its exact answer to a ramp, a low-pass on sines, ends and short signals."""

import numpy as np
import pytest

from identification.decimation import decimating_filter
from identification.filters import first_order_lag, low_pass

RATE = 500.0


@pytest.mark.parametrize("tau", [1e-6, 3e-3, 0.1])
def test_a_lag_follows_a_ramp_behind_by_itself(tau: float) -> None:
    """Of a ramp a first-order lag makes the ramp tau later, once exp(-t / tau) is nothing; exactly, however short tau is."""
    t = np.arange(2000)[:, None] / RATE
    np.testing.assert_allclose(first_order_lag(t, RATE, tau)[-1], t[-1] - tau, atol=1e-9)


def test_each_column_has_its_own_lag_and_none_changes_nothing() -> None:
    values = np.random.default_rng(0).normal(size=(300, 3))
    lagged = first_order_lag(values, RATE, np.array([0.0, 0.01, 0.2]))
    np.testing.assert_array_equal(lagged[:, 0], values[:, 0])
    for column, tau in ((1, 0.01), (2, 0.2)):
        np.testing.assert_array_equal(lagged[:, [column]], first_order_lag(values[:, [column]], RATE, tau))


@pytest.mark.parametrize(("hertz", "gain"), [(2.0, 1.0), (20.0, 0.5), (80.0, 0.0)])
def test_low_pass_halves_its_cutoff_and_shifts_nothing(hertz: float, gain: float) -> None:
    """Order 4 both ways: 1 / (1 + (f / 20 Hz)^8), 1e-8 below 1 at 2 Hz and 2e-5 at 80 Hz, but for the bilinear transform."""
    t = np.arange(4000) / RATE
    wave = np.sin(2 * np.pi * hertz * t)[:, None]
    middle = slice(1000, 3000)
    np.testing.assert_allclose(low_pass(wave, RATE, 20.0)[middle], gain * wave[middle], atol=1e-3)


@pytest.mark.parametrize("cutoff", [20.0, 400.0])
def test_straight_lines_pass_to_their_ends(cutoff: float) -> None:
    """A line mirrored through its ends is the line; a cutoff beyond half the rate is lowered instead of refused."""
    line = np.linspace(-3.0, 5.0, 1000)[:, None]
    np.testing.assert_allclose(low_pass(line, RATE, cutoff), line, atol=1e-9)


def test_short_signals_are_filtered() -> None:
    """0.08 s are mirrored as a whole, too short for the filter to settle: within a tenth of the line's span."""
    line = np.linspace(-3.0, 5.0, 40)[:, None]
    np.testing.assert_allclose(low_pass(line, RATE, 20.0), line, atol=0.8)


def test_of_waves_as_much_passes_as_if_each_were_filtered() -> None:
    """In sine and cosine together, whatever the phases; rows that tell nothing are left out."""
    rng, hertz, step = np.random.default_rng(0), np.array([1.25, 8.0, 20.0]), 1 / 250
    sizes, known = rng.normal(size=(2, 1500)), np.arange(1500) != 700
    low_pass = decimating_filter(step, known)
    found = np.sum(low_pass.of_waves(np.where(known, sizes, np.nan), hertz * step) ** 2, axis=0)
    phase = 2 * np.pi * hertz[:, None] * step * np.arange(1500)
    expected = low_pass(sizes[:, None] * np.cos(phase)) ** 2 + low_pass(sizes[:, None] * np.sin(phase)) ** 2
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)
