"""Error of a simulation against the measurement, channel by channel, and the error expected if the model were true."""

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
"""share of recordings in which a true model stays below `ratio_95` (docs/thresholds.md)"""


@dataclass(frozen=True)
class Channel:
    """RMS over all windows of simulated less measured, and the noise floor: the RMS expected from state, parameters and sensors."""

    name: str
    rms: float
    noise_floor: float
    unit: str
    ratio_95: float
    """ratio that a true model exceeds in 5 of 100 recordings: its parameters, x0 and delay are one draw for all windows"""

    @property
    def ratio(self) -> float:
        """RMS over noise floor: about one where the model is true, more where it is not."""
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
    """Simulated and measured values of a quantity at S samples of a part of a recording."""

    simulated: Array
    """(1 + K, S, columns): simulated as measured and modelled, then with each of K perturbations by one sigma"""
    measured: Array
    """(S, columns), NaN where it is not known"""
    variance: Array
    """variance of the measurement's noise, broadcastable to (S, columns)"""
    window: NDArray[np.intp]
    """number of each sample's window, ascending, negative where the sample does not count, (S,)"""


class ChannelSums:
    """Sums over the parts of a recording, each of whole windows, from which the channels of a quantity are computed."""

    def __init__(self, stem: str, unit: str, shared: int) -> None:
        """shared: place of the first perturbation that all windows share among the simulations."""
        self._stem, self._unit, self._shared = stem, unit, shared
        self._columns: list[_Sums] = []

    def add(self, part: ChannelSamples) -> None:
        """Adds a part of the recording."""
        self._columns = self._columns or [_Sums() for _ in part.measured.T]
        noise = np.broadcast_to(part.variance, part.measured.shape)
        for i, sums in enumerate(self._columns):
            known = np.isfinite(part.measured[:, i]) & (part.window >= 0)
            error = part.simulated[0, known, i] - part.measured[known, i]
            perturbations = part.simulated[1:, known, i] - part.simulated[0, known, i]
            sums.add(error, perturbations, self._shared - 1, noise[known, i], part.window[known])

    def channels(self) -> list[Channel]:
        """One channel for each column. Raises Refused where a column has no measurement."""
        out = []
        for i, sums in enumerate(self._columns, 1):
            if not sums.count:
                word = f"nothing measured of {self._stem}{i} lies in a window without gaps"
                raise Refused("simulate", word, "give shorter windows, or check the clock")
            out.append(sums.channel(f"{self._stem}{i}", self._unit))
        return out


class _Sums:
    """Sums over the samples of one column."""

    def __init__(self) -> None:
        self.count = 0
        self._error = self._floor = self._spread = 0.0
        self._shared: Array | float = 0.0
        """products of the perturbations that all windows share, (K, K)"""

    def add(self, error: Array, perturbations: Array, independent: int, noise: Array, window: NDArray[np.intp]) -> None:
        """error, noise's variance, window (S,); perturbations (K, S), the first `independent` differ between windows."""
        if not len(error):
            return
        self.count += len(error)
        self._error += float(np.sum(error**2))
        self._floor += float(np.sum(perturbations**2) + np.sum(noise))
        begins = np.flatnonzero(np.diff(window)) + 1
        by_window = np.split(perturbations[:independent], begins, axis=1)
        self._spread += float(np.sum(noise**2)) + sum(float(np.sum((d @ d.T) ** 2)) for d in by_window)
        self._shared = self._shared + perturbations[independent:] @ perturbations[independent:].T

    def channel(self, name: str, unit: str) -> Channel:
        """The channel, with RMS error and noise floor.

        The mean square is a sum of squares of normal numbers, weighted by the eigenvalues of the perturbations' products; it is
        approximated by a chi-square of the same mean and variance (Satterthwaite).
        """
        rms, floor = float(np.sqrt(self._error / self.count)), float(np.sqrt(self._floor / self.count))
        spread = self._spread + float(np.sum(np.square(self._shared)))
        freedom = self._floor**2 / spread if spread else np.inf
        ratio_95 = float(np.sqrt(chi2.ppf(COVERAGE, freedom) / freedom)) if spread else 1.0
        return Channel(name, rms, floor, unit, ratio_95)


def as_text(channels: Sequence[Channel]) -> str:
    """A table with one row for each channel; angles in degrees."""
    lines = [f"{'channel':9}{'rms':>10}{'noise floor':>13}{'ratio':>8}{'95 %':>8}"]
    for c in channels:
        rms, floor, unit = (
            (degrees(c.rms), degrees(c.noise_floor), "deg") if c.unit == "rad" else (c.rms, c.noise_floor, c.unit)
        )
        lines.append(f"{c.name:9}{rms:>10.3g}{floor:>13.3g}{c.ratio:>8.2f}{c.ratio_95:>8.2f}  {unit}")
    return "\n".join(lines)
