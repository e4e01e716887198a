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
    stem: str, unit: str, cases: Array, shared: int, measured: Array, variance: Array, window: NDArray[np.intp]
) -> list[Channel]:
    """One a column. cases (1 + doubts, S, columns): simulated as measured and modelled, then with each doubt by one sigma;
    from case `shared` on one that all windows share.

    measured: (S, columns), NaN where it is not known; variance of its own noise (S, columns); window: of each
    sample, rising, below zero where it does not count (S,).
    """
    out = []
    for i in range(measured.shape[1]):
        known = np.isfinite(measured[:, i]) & (window >= 0)
        if not known.any():
            word = f"nothing measured of {stem}{i + 1} lies in a window without gaps"
            raise Refused("simulate", word, "give shorter windows, or check the clock")
        error = cases[0, known, i] - measured[known, i]
        doubts = cases[1:, known, i] - cases[0, known, i]
        noise = np.broadcast_to(variance, measured.shape)[known, i]
        floor = float(np.mean(np.sum(doubts**2, axis=0) + noise))
        begins = np.flatnonzero(np.diff(window[known])) + 1
        alike = [doubts[shared - 1 :], *np.split(doubts[: shared - 1], begins, axis=1)]
        name, rms = f"{stem}{i + 1}", float(np.sqrt(np.mean(error**2)))
        out.append(Channel(name, rms, float(np.sqrt(floor)), unit, _ratio_95(alike, noise, floor)))
    return out


def _ratio_95(alike: list[Array], noise: Array, floor: float) -> float:
    """Of doubts that are one draw on some of the samples, each (K, those), and noise's variance (S,); floor is squared.

    A mean square is a sum of squares of normal numbers, weighted by the eigenvalues of the doubts' products; as chi-square of
    the same mean and variance (Satterthwaite).
    """
    spread = sum((float(np.sum((d @ d.T) ** 2)) for d in alike), start=float(np.sum(noise**2))) / len(noise) ** 2
    if not spread:
        return 1.0
    freedom = floor**2 / spread
    return float(np.sqrt(chi2.ppf(USUAL, freedom) / freedom))


def as_text(channels: Sequence[Channel]) -> str:
    """A channel a row; angles in degrees."""
    lines = [f"{'channel':9}{'rms':>10}{'noise floor':>13}{'ratio':>8}{'95 %':>8}"]
    for c in channels:
        rms, floor, unit = (
            (degrees(c.rms), degrees(c.noise_floor), "deg") if c.unit == "rad" else (c.rms, c.noise_floor, c.unit)
        )
        lines.append(f"{c.name:9}{rms:>10.3g}{floor:>13.3g}{c.ratio:>8.2f}{c.ratio_95:>8.2f}  {unit}")
    return "\n".join(lines)
