"""Recordings that begin anew, and blocks of different length, in arrays without a law."""

import numpy as np
import pytest

from discovery.discover import discover
from xneck_foundation.errors import Refused


def test_recordings_may_each_begin_at_zero_in_blocks_of_their_own() -> None:
    """Within a block time goes on."""
    rng = np.random.default_rng(1)
    time = np.tile(0.02 * np.arange(300), 2)
    residual, angle = rng.normal(size=(2, 600))
    found = discover(residual, {"joint_angle": angle}, time, np.repeat(np.arange(12), 50))
    assert found.laws == ()
    assert found.after == pytest.approx(1.0, abs=0.1)
    with pytest.raises(Refused, match="time goes back after row 299"):
        discover(residual, {"joint_angle": angle}, time, np.repeat(np.arange(15), 40))


def test_the_busiest_block_is_the_loudest_and_not_the_longest() -> None:
    """A tenth as long as the others and twice as loud, it has less than half as much in all."""
    rows = [200] * 6 + [20] + [200] * 6
    block = np.repeat(np.arange(13), rows)
    rng = np.random.default_rng(2)
    quiet, loud = (rng.permutation(np.tile([-size, size], len(block))[: len(block)]) for size in (1.0, 2.0))
    residual = np.where(block == 6, loud, quiet)
    found = discover(residual, {"joint_angle": rng.normal(size=len(block))}, 0.01 * np.arange(len(block)), block)
    assert found.laws == ()
    assert found.busiest == pytest.approx((12.0, 12.19))
    assert found.busiest_rms == pytest.approx(2.0, rel=0.1)
