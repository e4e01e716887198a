"""What another recording has for itself is found by steps each of which lessens its loss."""

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis import held_out_gain as module
from diagnosis.comparison import ColumnFit

ENDS = 0.4
"""where the loss below is least"""


@dataclass(frozen=True)
class BentLoss:
    """log cosh of one number: Newton's whole steps leave it for good from 1.1 on."""

    linearisation: Any
    base_count: int = 1
    nuisances: Any = field(default_factory=lambda: SimpleNamespace(count=0))

    @property
    def _off(self) -> float:
        return float(self.linearisation.p[0]) - ENDS

    @property
    def loss_with_clocks_at_best(self) -> float:
        return float(np.log(np.cosh(self._off)))

    @property
    def newton(self) -> ColumnFit:
        return ColumnFit(np.array([0]), np.array([-np.sinh(self._off) * np.cosh(self._off)]), 0.0)

    def clock_shifts(self, fit: ColumnFit) -> np.ndarray:
        return np.zeros(len(fit.columns))


def compared(at: Any) -> tuple[Any, ColumnFit]:
    loss = BentLoss(at)
    return loss, loss.newton


def at(p: float) -> Any:
    return SimpleNamespace(
        p=np.array([p]), unknowns=SimpleNamespace(size=np.ones(1)), frame_lags=np.zeros(1), hypothesis=None
    )


@pytest.mark.parametrize("start", [ENDS - 1.5, ENDS, ENDS + 0.5, ENDS + 2.0])
def test_steps_that_are_too_long_are_taken_shorter(start: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where cables harden much, whole steps led to slack cables, and the model seemed to do worse than without its cause."""
    monkeypatch.setattr(module, "corrected_signals", lambda h, data, lags: None)
    monkeypatch.setattr(module, "linearise", lambda h, signals, p, lags: at(float(p[0])))
    ends, _ = module._with_own_numbers(at(start), SimpleNamespace(data=None), compared)  # type: ignore[arg-type]
    assert abs(float(ends.linearisation.p[0]) - ENDS) < module._MIN_STEP
