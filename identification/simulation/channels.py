"""How far a simulation is from the measurement, channel by channel, and how far it would be were the model true."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from xneck.errors import Refused

Array = NDArray[np.float64]

USUAL = 0.95
"""of recordings, in which a true model stays below `ratio_95`"""


@dataclass(frozen=True)
class Channel:
    """RMS over all windows of simulated less measured, and of what state, parameters and sensors leave unknown."""

    name: str
    rms: float
    noise_floor: float
    unit: str
    ratio_95: float
    """below which the ratio stays in 95 of 100 recordings where the model is true: its numbers, x0 and delay are one draw"""

    @property
    def ratio(self) -> float:
        """About one where the model is true, and more where it is not."""
        return self.rms / self.noise_floor if self.noise_floor else float("inf")

    def as_json(self) -> dict[str, Any]:
        """The contract's record."""
        return {
            "channel": self.name,
            "rms": self.rms,
            "noise_floor": self.noise_floor,
            "ratio": self.ratio if np.isfinite(self.ratio) else None,
            "ratio_95": self.ratio_95,
            "unit": self.unit,
        }


def channels_of(
    stem: str, unit: str, cases: Array, shared: int, measured: Array, variance: Array, counted: NDArray[np.bool_]
) -> list[Channel]:
    """One a column. cases (1 + doubts, S, columns): simulated as measured and modelled, then with each doubt by one sigma;
    from case `shared` on one that all windows share.

    measured: (S, columns), NaN where it is not known; variance of its own noise (S, columns); counted: which samples (S,).
    """
    out = []
    for i in range(measured.shape[1]):
        known = np.isfinite(measured[:, i]) & counted
        if not known.any():
            word = f"nothing measured of {stem}{i + 1} lies in a window without gaps"
            raise Refused("simulate", word, "give shorter windows, or check the clock")
        error = cases[0, known, i] - measured[known, i]
        doubts = cases[1:, known, i] - cases[0, known, i]
        floor = np.mean(np.sum(doubts**2, axis=0) + np.broadcast_to(variance, measured.shape)[known, i])
        lasting = doubts[shared - 1 :]
        usual = _ratio_95(lasting @ lasting.T / lasting.shape[1], floor)
        name, rms = f"{stem}{i + 1}", float(np.sqrt(np.mean(error**2)))
        out.append(Channel(name, rms, float(np.sqrt(floor)), unit, usual))
    return out


def _ratio_95(shared: Array, floor: float) -> float:
    """Of shared doubts with mean products (K, K) below a floor, squared.

    What they do is a sum of squares of normal numbers, weighted by the products' eigenvalues; as chi-square of the same mean and
    variance (Satterthwaite). All else is the mean over many windows, and taken as it is.
    """
    spread = float(np.sum(shared**2))
    if not spread:
        return 1.0
    part = float(np.trace(shared))
    freedom = part**2 / spread
    return float(np.sqrt(1 + part / floor * (chi2.ppf(USUAL, freedom) / freedom - 1)))


def as_text(channels: Sequence[Channel]) -> str:
    """A channel a row; angles in degrees."""
    lines = [f"{'channel':9}{'rms':>10}{'noise floor':>13}{'ratio':>8}{'95 %':>8}"]
    for c in channels:
        rms, floor, unit = (
            (degrees(c.rms), degrees(c.noise_floor), "deg") if c.unit == "rad" else (c.rms, c.noise_floor, c.unit)
        )
        lines.append(f"{c.name:9}{rms:>10.3g}{floor:>13.3g}{c.ratio:>8.2f}{c.ratio_95:>8.2f}  {unit}")
    return "\n".join(lines)
