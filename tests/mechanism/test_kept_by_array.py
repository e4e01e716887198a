"""What is kept of an array: made once for a key, gone with the array, and never of one that may change."""

import gc
from dataclasses import replace

import numpy as np
import pytest

from mechanism.kept_by_array import MOST_OF_ONE, KeptByArray
from mechanism.laws import CableMotion, law_named
from tests.mechanism.test_simulation import ARM, VALUES


def test_it_is_made_once_for_an_array_and_a_key() -> None:
    kept, array, made = KeptByArray[str](), np.arange(3.0), []
    array.flags.writeable = False

    def make() -> str:
        made.append(1)
        return str(len(made))

    assert [kept.get(array, key, make) for key in ("a", "a", "b", "a")] == ["1", "1", "2", "1"]


def test_keys_that_change_at_every_step_do_not_fill_memory() -> None:
    kept, array = KeptByArray[int](), np.arange(3.0)
    array.flags.writeable = False
    sizes = []
    for step in range(100):
        assert kept.get(array, step, lambda step=step: step) == step
        sizes.append(len(kept))
    assert max(sizes) == MOST_OF_ONE


def test_nothing_is_kept_of_an_array_that_may_change() -> None:
    kept, array = KeptByArray[float](), np.arange(3.0)
    before = kept.get(array, "sum", lambda: float(array.sum()))
    array += 1
    assert kept.get(array, "sum", lambda: float(array.sum())) == before + 3
    assert not len(kept)


def test_an_array_that_is_gone_leaves_nothing_to_the_next_one_at_its_place() -> None:
    kept = KeptByArray[float]()

    def total(value: float) -> float:
        array = np.full(3, value)
        array.flags.writeable = False
        return kept.get(array, "sum", lambda: float(array.sum()))

    assert [total(float(value)) for value in range(50)] == [3.0 * value for value in range(50)]
    gc.collect()
    assert not len(kept)


@pytest.mark.parametrize("name", ["cable.harmonic.drum_angle", "cable.bump.motor_angle", "cable.smooth.drum_angle"])
def test_a_winding_that_was_kept_pulls_as_one_that_was_not(name: str) -> None:
    """With other amounts, other constants, and another drum than it was kept for."""
    law = law_named(name)
    rng = np.random.default_rng(0)
    theta = rng.uniform(-20, 20, (40, ARM.M))
    kept = theta.copy()
    kept.flags.writeable = False
    arms = (ARM, replace(ARM, drum=1.2 * ARM.drum), replace(ARM, gear=2 * ARM.gear))
    for arm in (*arms, *arms):
        values = {t.name: rng.normal(size=t.count(ARM)) * 1e-4 if t.linear else rng.uniform(1, 3, 1) for t in law.terms}
        pulls = [
            law.pull(
                VALUES | values,
                CableMotion(np.zeros_like(t), np.zeros_like(t), t, arm, np.ones_like(t), t / arm.gear, t),
                np.zeros((*t.shape, 0)),
            )
            for t in (theta, kept)
        ]
        assert np.abs(pulls[0]).max() > 1e-3
        assert np.allclose(*pulls, rtol=1e-9, atol=1e-12)
