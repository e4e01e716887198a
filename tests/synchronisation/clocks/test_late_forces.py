"""Clocks of logs whose commands act later than they say, by much more than the equations' first order holds for."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from identification.dataset.series import Series, numbered_columns
from samples.worlds.clock_worlds import ClockRecording, arm, clock_recording
from synchronisation.clocks import gauss_newton_fit
from synchronisation.clocks.clock import fit_clock
from synchronisation.clocks.gauss_newton_fit import MIN_STEP

LAG_S, DELAY_S = 0.020, 0.012
SEED = 104


def commanded(made: ClockRecording, command_of: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Series:
    """The log with commands (T, M) in the place of the forces that acted, from these forces and the time (T,), s."""
    log = made.log
    force = command_of(log.matrix("f"), log.time)
    return Series(log.time, numbered_columns("theta", log.matrix("theta")) | numbered_columns("f", force))


def lagging(force: np.ndarray, time: np.ndarray) -> np.ndarray:
    """What a motor was told that follows by a first-order lag: what it did, and LAG_S times how fast that changed."""
    return force + LAG_S * np.gradient(force, time, axis=0)


def delayed(force: np.ndarray, time: np.ndarray) -> np.ndarray:
    """What a motor was told that does everything DELAY_S later."""
    return np.stack([np.interp(time + DELAY_S, time, f) for f in force.T], axis=1)


@pytest.mark.parametrize(("command_of", "by"), [(lagging, LAG_S), (delayed, DELAY_S)])
def test_the_clock_stands_where_commands_act_late(command_of: Any, by: float) -> None:
    """A lag and a delay are found to 5 %, and the clock stays within 3.3 sigma, each a chance of one in a thousand."""
    made = clock_recording("linear elastic", SEED, 30.0)
    found = fit_clock(arm(), made.angles, commanded(made, command_of))
    error = found.offset - (made.clocks.offset_s + made.clocks.skew * (found.middle - made.clocks.middle_s))
    assert found.delay is not None
    assert found.delay[0] == pytest.approx(by, rel=0.05)
    assert abs(error) < 3.3 * found.offset_sigma
    assert found.offset_sigma < 5e-4


class Step:
    """A step whose cost is least at a share of it, and whose slopes promise that all of it may be taken."""

    def __init__(self, best: float) -> None:
        self.best = best

    def taken(self, share: float = 1.0) -> float:
        return share

    def cost(self, unknowns: float, residual: Any) -> float:
        return 1 + (unknowns - self.best) ** 2


@pytest.mark.parametrize(
    ("best", "share"), [(1.0, 1.0), (0.6, 1.0), (0.4, 0.5), (0.3, 0.5), (0.1, 0.125), (-1.0, MIN_STEP / 2)]
)
def test_a_step_that_leads_uphill_is_halved(best: float, share: float) -> None:
    """To the first share of 1, 1/2, 1/4 ... that is no further from the best than the start, but for 1 % of the cost."""
    rows: Any = replace  # any object: the steps above have costs of their own
    cables: Any = type("Cables", (), {"rows": lambda *_: type("Rows", (), {"residual": None})()})()
    before: Any = type("Before", (), {"cables": type("Rows", (), {"residual": None})(), "frames": rows})()
    step: Any = Step(best)
    assert gauss_newton_fit._downhill(step, before, cables)[0] == share
