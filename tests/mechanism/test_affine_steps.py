"""Steps along a recording, against a loop over its rows."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mechanism.affine_steps import accumulated, accumulated_within

SEEDS = st.integers(0, 2**32 - 1)


@given(SEEDS, st.integers(0, 60))
def test_a_sum_within_bounds_is_that_of_a_play(seed: int, steps: int) -> None:
    """Turning, standing still, and staying at a bound."""
    rng = np.random.default_rng(seed)
    added = rng.normal(size=(steps, 3, 2)) * rng.choice([0.0, 0.1, 1.0], size=(steps, 3, 2))
    low, high = -rng.uniform(0.1, 2.0, size=(3, 2)), rng.uniform(0.1, 2.0, size=(3, 2))
    z = [rng.uniform(low, high)]
    for step in added:
        z.append(np.clip(z[-1] + step, low, high))
    np.testing.assert_allclose(accumulated_within(z[0], added, low, high), z, rtol=0, atol=1e-12)


@given(SEEDS, st.integers(1, 60))
def test_what_is_forgotten_fades_step_by_step(seed: int, steps: int) -> None:
    rng = np.random.default_rng(seed)
    added, decay = rng.normal(size=(steps, 3, 2)), rng.choice([0.0, 0.5, 1.0], size=(steps, 3, 2))
    z = [rng.normal(size=(3, 2))]
    for of_step, more in zip(decay, added, strict=True):
        z.append(of_step * z[-1] + more)
    np.testing.assert_allclose(accumulated(z[0], decay, added), z, rtol=0, atol=1e-12)
