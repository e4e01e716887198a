"""Clocks that run apart by more than those of two devices do."""

from dataclasses import replace

import pytest

from samples.worlds.clock_worlds import arm, clock_recording
from synchronisation.clocks.clock import fit_clock


@pytest.mark.parametrize(("ppm", "is_said"), [(0.0, False), (-600.0, True), (600.0, True)])
def test_clocks_that_run_apart_further_than_quartz_are_told_of(ppm: float, is_said: bool) -> None:
    """The log's stamps of a computer whose clock is being slewed run faster or slower than its seconds."""
    made = clock_recording("linear elastic", 911)
    slewed = replace(made.log, time=made.log.time * (1 + 1e-6 * ppm))
    clock = fit_clock(arm(), made.angles, slewed)
    true = (1 + made.clocks.skew) * (1 + 1e-6 * ppm) - 1
    assert abs(clock.skew - true) < 3.3 * clock.skew_sigma
    said = [w for w in clock.warnings if "slewed" in w]
    assert bool(said) == is_said
    assert all(("faster" if ppm > 0 else "slower") in words for words in said)
