"""How far a simulation is from the measurement, channel by channel, and how far it would be were the model true."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

COVERAGE = 0.95
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


@dataclass(frozen=True)
class ChannelSamples:
    """What was measured of some quantities beside what was simulated of them, in a part of a recording."""

    cases: Array
    """(1 + doubts, S, columns): simulated as measured and modelled, then with each doubt by one sigma"""
    measured: Array
    """(S, columns), NaN where it is not known"""
    variance: Array
    """of its own noise, (S, columns) or fewer"""
    window: NDArray[np.intp]
    """of each sample, rising, below zero where it does not count, (S,)"""


class ChannelSums:
    """Sums over a recording's parts, of which each holds whole windows: what a quantity's channels come from."""

    def __init__(self, stem: str, unit: str, shared: int) -> None:
        """shared: of the cases the first with a doubt that is the same in all windows."""
        self._stem, self._unit, self._shared = stem, unit, shared
        self._columns: list[_Sums] = []

    def add(self, part: ChannelSamples) -> None:
        """A part."""
        self._columns = self._columns or [_Sums() for _ in part.measured.T]
        noise = np.broadcast_to(part.variance, part.measured.shape)
        for i, sums in enumerate(self._columns):
            known = np.isfinite(part.measured[:, i]) & (part.window >= 0)
            error = part.cases[0, known, i] - part.measured[known, i]
            doubts = part.cases[1:, known, i] - part.cases[0, known, i]
            sums.add(error, doubts, self._shared - 1, noise[known, i], part.window[known])

    def channels(self) -> list[Channel]:
        """One a column. Raises Refused where nothing was measured of one."""
        out = []
        for i, sums in enumerate(self._columns, 1):
            if not sums.count:
                word = f"nothing measured of {self._stem}{i} lies in a window without gaps"
                raise Refused("simulate", word, "give shorter windows, or check the clock")
            out.append(sums.channel(f"{self._stem}{i}", self._unit))
        return out


class _Sums:
    """Of one column's samples."""

    def __init__(self) -> None:
        self.count = 0
        self._error = self._floor = self._spread = 0.0
        self._shared: Array | float = 0.0
        """products of the doubts that all windows share"""

    def add(self, error: Array, doubts: Array, own: int, noise: Array, window: NDArray[np.intp]) -> None:
        """error, noise's variance, window (S,); doubts (K, S), of which the first `own` are drawn anew in each window."""
        if not len(error):
            return
        self.count += len(error)
        self._error += float(np.sum(error**2))
        self._floor += float(np.sum(doubts**2) + np.sum(noise))
        begins = np.flatnonzero(np.diff(window)) + 1
        anew = np.split(doubts[:own], begins, axis=1)
        self._spread += float(np.sum(noise**2)) + sum(float(np.sum((d @ d.T) ** 2)) for d in anew)
        self._shared = self._shared + doubts[own:] @ doubts[own:].T

    def channel(self, name: str, unit: str) -> Channel:
        """Errors and floor as RMS.

        A mean square is a sum of squares of normal numbers, weighted by the eigenvalues of the doubts' products; as chi-square
        of the same mean and variance (Satterthwaite).
        """
        rms, floor = float(np.sqrt(self._error / self.count)), float(np.sqrt(self._floor / self.count))
        spread = self._spread + float(np.sum(np.square(self._shared)))
        freedom = self._floor**2 / spread if spread else np.inf
        usual = float(np.sqrt(chi2.ppf(COVERAGE, freedom) / freedom)) if spread else 1.0
        return Channel(name, rms, floor, unit, usual)


def as_text(channels: Sequence[Channel]) -> str:
    """A channel a row; angles in degrees."""
    lines = [f"{'channel':9}{'rms':>10}{'noise floor':>13}{'ratio':>8}{'95 %':>8}"]
    for c in channels:
        rms, floor, unit = (
            (degrees(c.rms), degrees(c.noise_floor), "deg") if c.unit == "rad" else (c.rms, c.noise_floor, c.unit)
        )
        lines.append(f"{c.name:9}{rms:>10.3g}{floor:>13.3g}{c.ratio:>8.2f}{c.ratio_95:>8.2f}  {unit}")
    return "\n".join(lines)
