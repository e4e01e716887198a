"""Two clocks and the camera's frames: when pictures were taken, and what the controller's clock said then."""

from dataclasses import dataclass

import numpy as np

from samples.generator.taut_string import Array

FRAME_HZ = 30.0
_JITTER_S = 0.0004
_DROPPED_SHARE = 0.008
_TICK_HZ = 90_000
"""the time base of the video's stamps: frame times lie on it, so that stamps are exact"""


@dataclass(frozen=True)
class Clocks:
    """log time = camera time + offset + skew (camera time - middle)."""

    offset_s: float
    skew: float
    middle_s: float
    """of the camera's recording, camera time"""

    def log_time(self, camera_time: Array) -> Array:
        """s of the controller's clock, shape of camera_time"""
        return camera_time + self.offset_s + self.skew * (camera_time - self.middle_s)

    def camera_time(self, log_time: Array) -> Array:
        """s of the camera's clock, shape of log_time"""
        return (log_time - self.offset_s + self.skew * self.middle_s) / (1 + self.skew)


def frame_times(duration: float, rng: np.random.Generator, hertz: float = FRAME_HZ) -> Array:
    """Middles of the exposures on the camera's clock, shape (F,), s, from 0 on: jittering, a few frames missing."""
    nominal = np.arange(round(duration * hertz)) / hertz
    times = nominal + rng.normal(0, _JITTER_S, len(nominal))
    inner = np.arange(hertz, len(nominal) - hertz, dtype=int)  # the first and the last second stay whole
    dropped = rng.choice(inner, max(2, round(_DROPPED_SHARE * len(nominal))), replace=False)
    times = np.delete(times - times[0], dropped.astype(int))
    return np.round(times * _TICK_HZ) / _TICK_HZ


def clocks(times: Array, rng: np.random.Generator) -> Clocks:
    """An offset of some seconds and a skew of some tens of ppm, of either sign, for frames at `times`, s."""
    skew = rng.choice([-1.0, 1.0]) * rng.uniform(15e-6, 60e-6)
    return Clocks(float(rng.uniform(3.0, 9.0)), float(skew), float((times[0] + times[-1]) / 2))
