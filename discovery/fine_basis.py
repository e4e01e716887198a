"""A variable's functions, all of them: fine columns of which every form is a sum, so that forms are compared without the rows."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Function = Callable[[Array], Array]
"""of values (T,), to columns (T, k)"""

HATS = 41
"""along a variable's range: knots of smooth functions fall on some of theirs"""
_LEAST_RANGE = 1e-9
"""of a variable, over its size"""
HARMONICS = 24
"""of a turn"""
_NODES = 4 * HARMONICS


def stands_still(low: float, high: float) -> bool:
    """Whether a variable is one value, but for a filter's rounding."""
    return high - low <= _LEAST_RANGE * max(abs(low), abs(high))


@dataclass(frozen=True, eq=False)
class FineBasis:
    """K columns of a variable: hats between knots, or what comes round with a turn."""

    knots: Array
    """values between which functions are straight, (K,); of a turn the nodes at which a function is read"""
    is_turn: bool = False
    reach: tuple[float, float] | None = None
    """within which forms are tried, where that is less than the knots'"""

    @classmethod
    def of(cls, values: Sequence[Array], is_turn: bool) -> "FineBasis":
        """For a variable's values in all rows, one array or several."""
        if is_turn:
            return cls(np.arange(_NODES) * 2 * np.pi / _NODES, is_turn=True)
        rows = np.concatenate(list(values))
        low, high = float(rows.min()), float(rows.max())
        if stands_still(low, high):
            low, high = low - 1.0, low + 1.0
        return cls(np.linspace(low, high, HATS))

    @property
    def low(self) -> float:
        """Lowest value there is."""
        return float(self.knots[0]) if self.reach is None else self.reach[0]

    @property
    def high(self) -> float:
        """Highest value there is."""
        return float(self.knots[-1]) if self.reach is None else self.reach[1]

    def columns(self, values: Array) -> Array:
        """The basis at values (T,): (T, K)."""
        if self.is_turn:
            # the powers of exp(i x) are its harmonics
            waves = np.cumprod(np.broadcast_to(np.exp(1j * values), (HARMONICS, len(values))), axis=0)
            return np.asarray(np.concatenate([waves.real, waves.imag]).T, dtype=float)
        at = np.interp(values, self.knots, np.arange(len(self.knots)))
        # of all hats but the two on either side a value is beyond the reach
        out, rows = np.zeros((len(self.knots), len(values))), np.arange(len(values))
        below = np.minimum(at.astype(int), len(self.knots) - 2)
        out[below, rows], out[below + 1, rows] = 1 - (at - below), 1 - (below + 1 - at)
        return out.T

    def coefficients(self, function: Function) -> Array:
        """Coefficients of the fine columns that add up to a function's columns, (..., K, k); of a turn without its mean.

        The function may be several at once, with leading axes."""
        values = function(self.knots)
        return self._harmonics @ values if self.is_turn else values

    @cached_property
    def _harmonics(self) -> Array:
        """From a turn's nodes to its harmonics, (K, nodes)."""
        phase = self.knots[:, None] * np.arange(1, HARMONICS + 1)
        return 2 / _NODES * np.concatenate([np.cos(phase), np.sin(phase)], axis=1).T
