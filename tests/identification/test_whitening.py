"""Whitened rows are noise of one, told from an autoregressive process whose numbers are known."""

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from identification.whitening import WHITENING_ORDER, fit_whitener

POLES, SLOW = [1.0, -1.6, 0.8], [1.0, -1.9, 0.95]
ROWS = 40_000


def noise(rng: np.random.Generator, poles: list[float], sizes: list[float]) -> NDArray[np.float64]:
    """Autoregressive, innovations of these sizes, (C, ROWS)."""
    drawn = np.array(sizes)[:, None] * rng.normal(size=(len(sizes), ROWS))
    return np.asarray(lfilter([1.0], poles, drawn, axis=1))


def test_rows_of_which_more_is_unsure_are_worth_as_much_as_the_others() -> None:
    """Errors a hundred times the innovation beside it, for ten rows out of four hundred: whitened, every row has spread one."""
    rng = np.random.default_rng(1)
    plain = noise(rng, POLES, [0.3, 1e-3])
    starts = np.arange(ROWS) == 0
    whiten = fit_whitener([plain], [starts])
    place = np.arange(ROWS) % 400
    unsure = np.where(place < 10, np.array([[30.0**2], [0.1**2]]), 0.0)
    seen = plain + np.sqrt(unsure) * rng.normal(size=plain.shape)
    found = whiten(seen, starts, unsure)
    # 100 places of each kind, two channels: the spread of one kind is known to 1 / sqrt(2 * 200)
    reached = place < 10 + WHITENING_ORDER
    assert abs(found[:, reached].std() - 1) < 4 / np.sqrt(2 * 200 * 16 / 4)
    assert abs(found[:, ~reached].std() - 1) < 4 / np.sqrt(2 * 2 * (~reached).sum())
    # as if all rows were alike, those few would be nearly all that is seen
    assert whiten(seen, starts)[:, reached].std() > 30


def test_slow_noise_is_not_made_fast_by_weights() -> None:
    rng = np.random.default_rng(2)
    plain = noise(rng, SLOW, [1.0])
    starts = np.arange(ROWS) == 0
    whiten = fit_whitener([plain], [starts])
    unsure = np.where(np.arange(ROWS) % 40 < 20, 0.0, 25.0)[None]
    assert whiten(plain, starts, unsure).std() < 1
    assert whiten(plain / np.sqrt(1 + unsure), starts).std() > 3


def test_rows_are_those_of_the_taps_one_by_one() -> None:
    """In two segments, in columns side by side, and of a number of rows that no product takes at once."""
    rng = np.random.default_rng(3)
    plain = rng.normal(size=(2, 103, 3))
    starts = np.isin(np.arange(103), [0, 40])
    whiten = fit_whitener([noise(rng, POLES, [0.3, 1e-3])], [np.arange(ROWS) == 0])
    expected = np.zeros_like(plain)
    for row in (*range(WHITENING_ORDER, 40), *range(40 + WHITENING_ORDER, 103)):
        for lag in range(WHITENING_ORDER + 1):
            expected[:, row] += whiten.taps[:, lag, None] * plain[:, row - lag]
    np.testing.assert_allclose(whiten(plain, starts), expected, rtol=1e-9, atol=1e-9)
