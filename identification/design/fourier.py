"""Fourier series that joints and tension levels follow, faded in from rest and out to rest."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

REST_S = 0.5
"""s of rest at both ends"""
RAMP_S = 1.5
"""s of fading in, and of fading out"""
MAX_TONES = 6
"""tones of each signal"""


@dataclass(frozen=True)
class FourierShape:
    """S signals of H tones each, the joints' first, then the tension levels'; amplitudes are relative."""

    hertz: Array
    """frequencies (S, H), Hz; no two signals share one"""
    amplitude: Array
    """(S, H)"""
    phase: Array
    """(S, H), rad"""
    reach: Array
    """amplitude of each signal as a share of what the limits allow, (S,), 0..1"""


@dataclass(frozen=True)
class Signal:
    """Values with two derivatives by time, each (T, S); each signal's largest magnitude is 1."""

    value: Array
    d1: Array
    d2: Array


def tone_frequencies(signals: int, seconds: float, band: tuple[float, float]) -> Array:
    """Frequencies (S, H), Hz: multiples of one over the time in motion, evenly spread on a logarithmic scale and dealt out in turn.

    Raises Refused where the time or the band holds fewer than one for each signal.
    """
    period = seconds - 2 * REST_S
    low, high = (max(1, int(np.ceil(band[0] * period))), int(np.floor(band[1] * period))) if period > 0 else (1, 0)
    per_signal = min(MAX_TONES, (high - low + 1) // signals)
    if per_signal < 1:
        raise Refused(
            "design",
            f"{seconds:g} s hold no {signals} different tones of {band[0]:g} to {band[1]:g} Hz",
            "take more --seconds",
        )
    ideal = np.geomspace(low, high, per_signal * signals)
    number = np.zeros(len(ideal), dtype=int)
    for i, w in enumerate(ideal):
        # each above the one before it, and with room for those that follow
        lowest = low if i == 0 else number[i - 1] + 1
        number[i] = min(max(round(w), lowest), high - (len(ideal) - 1 - i))
    return number.reshape(per_signal, signals).T / period


def random_shape(hertz: Array, rng: np.random.Generator) -> FourierShape:
    """A random shape: spectra of random steepness, random phases and random reach."""
    signals = len(hertz)
    fall = rng.uniform(0.0, 1.5, (signals, 1))
    return FourierShape(
        hertz,
        hertz**-fall * rng.uniform(0.2, 1.0, hertz.shape),
        rng.uniform(0, 2 * np.pi, hertz.shape),
        rng.uniform(0.4, 1.0, signals),
    )


def fourier_signal(shape: FourierShape, time: Array) -> Signal:
    """The signals of a shape at times (T,), s, from 0."""
    r, r1, r2 = _ramp(time)
    w = 2 * np.pi * shape.hertz
    at = time[:, None, None] * w + shape.phase
    sine, cosine = np.sin(at), np.cos(at)
    s, s1, s2 = (
        np.sum(a, axis=-1)
        for a in (shape.amplitude * sine, shape.amplitude * w * cosine, -shape.amplitude * w**2 * sine)
    )
    value = r * s
    peak = np.abs(value).max(axis=0)
    return Signal(value / peak, (r1 * s + r * s1) / peak, (r2 * s + 2 * r1 * s1 + r * s2) / peak)


def _ramp(time: Array) -> tuple[Array, Array, Array]:
    """0 at both ends, 1 between, with two derivatives, each (T, 1).

    Four derivatives are continuous: tensions follow alpha'', elongations follow tensions, and forces follow the second derivative
    of the elongations.
    """
    end = time[-1]
    first = time < end / 2
    u = np.clip((np.where(first, time, end - time) - REST_S) / RAMP_S, 0.0, 1.0)
    sign = np.where(first, 1.0, -1.0)
    value = u**5 * (126 - 420 * u + 540 * u**2 - 315 * u**3 + 70 * u**4)
    slope = 630 * u**4 * (1 - u) ** 4 * sign / RAMP_S
    bend = 2520 * u**3 * (1 - u) ** 3 * (1 - 2 * u) / RAMP_S**2
    return value[:, None], slope[:, None], bend[:, None]
