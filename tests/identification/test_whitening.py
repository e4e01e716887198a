"""Whitened rows are noise of one, told from an autoregressive process whose numbers are known."""

import numpy as np
from scipy.signal import lfilter

from identification.whitening import ORDER, fit_whitener

POLES = [1.0, -1.6, 0.8]
ROWS = 40_000


def test_rows_of_which_more_is_unsure_are_worth_as_much_as_the_others() -> None:
    """Errors a hundred times the innovation beside it, for ten rows out of four hundred: whitened, every row has spread one."""
    rng = np.random.default_rng(1)
    noise = lfilter([1.0], POLES, rng.normal(size=(2, ROWS)), axis=1) * np.array([[0.3], [1e-3]])
    starts = np.arange(ROWS) == 0
    whiten = fit_whitener([noise], [starts])
    place = np.arange(ROWS) % 400
    unsure = (place < 10) * np.array([[30.0**2], [0.1**2]])
    seen = noise + np.sqrt(unsure) * rng.normal(size=noise.shape)
    found = whiten(seen, starts, unsure)
    # 100 places of each kind, two channels: the spread of one kind is known to 1 / sqrt(2 * 200)
    reached = place < 10 + ORDER
    assert abs(found[:, reached].std() - 1) < 4 / np.sqrt(2 * 200 * 16 / 4)
    assert abs(found[:, ~reached].std() - 1) < 4 / np.sqrt(2 * 2 * (~reached).sum())
    # as if all rows were alike, those few would be nearly all that is seen
    assert whiten(seen, starts)[:, reached].std() > 30


def test_slow_noise_is_not_made_fast_by_weights() -> None:
    rng = np.random.default_rng(2)
    noise = lfilter([1.0], [1.0, -1.9, 0.95], rng.normal(size=(1, ROWS)), axis=1)
    starts = np.arange(ROWS) == 0
    whiten = fit_whitener([noise], [starts])
    unsure = np.tile(np.where(np.arange(ROWS) % 40 < 20, 0.0, 25.0), (1, 1))
    assert whiten(noise, starts, unsure).std() < 1
    assert whiten(noise / np.sqrt(1 + unsure), starts).std() > 3
