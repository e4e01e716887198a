"""What is short is set aside; what comes again and again is not."""

import numpy as np
import pytest

from diagnosis.held_out_gain import HeldOutResiduals
from diagnosis.noise_excess import noise_excess
from diagnosis.short_disturbances import short_disturbances_held_out

ROWS_S, SECONDS = 31.25, 60.0
TIME = np.arange(0, SECONDS, 1 / ROWS_S)


def left(bursts: int, seconds: float) -> HeldOutResiduals:
    """Two channels of noise, in one of which stretches of some seconds are 30 times as loud."""
    rng = np.random.default_rng(bursts)
    begins = (np.arange(bursts) + 0.5) * SECONDS / bursts
    bursting = np.any((begins < TIME[:, None]) & (begins + seconds > TIME[:, None]), axis=1)
    residual, *noise = rng.normal(size=(5, 2, len(TIME)))
    residual[0] *= np.where(bursting, 30.0, 1.0)
    return HeldOutResiduals((residual,), (list(noise),), (np.zeros_like(residual),), (0.0,), (TIME,))


@pytest.mark.parametrize("bursts", [1, 4, 8])
def test_a_few_pushes_are_set_aside(bursts: int) -> None:
    of = left(bursts, 0.5)
    found = short_disturbances_held_out(of, noise_excess(of.residuals, of.noise, of.uncertain))
    assert len(found) == bursts
    assert all(e.end - e.begin < 2.0 for e in found)


def test_what_comes_again_and_again_is_not() -> None:
    of = left(25, 0.9)
    assert not short_disturbances_held_out(of, noise_excess(of.residuals, of.noise, of.uncertain))
