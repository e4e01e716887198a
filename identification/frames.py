"""Frames on the log's clock, as a data set's record of its clock states it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset import DataSet
from identification.state import Seen

Array = NDArray[np.float64]

DEFAULT_SIGMA = float(np.radians(0.1))
"""rad: assumed for angles that come without their sigma, and said so"""
FRAME_HZ = 25.0
"""at which the state stands in for frames"""
_LEAST_WHITE = 0.05
"""of sigma: no angle is free of noise"""


@dataclass(frozen=True)
class Slip:
    """Frames that were lost just before the frame stamped `time` (camera clock, s); it and all later ones are late."""

    time: float
    frames: int


@dataclass(frozen=True)
class Slips:
    """All losses of a recording, and the period by which a frame is late, s."""

    slips: tuple[Slip, ...] = ()
    period: float = 0.0

    def corrected(self, stamp: Array) -> Array:
        """When frames were really taken, s on the camera's clock."""
        stamp = np.asarray(stamp, dtype=float)
        late = np.zeros(stamp.shape)
        for slip in self.slips:
            late += slip.frames * self.period * (stamp >= slip.time)
        return stamp + late


def log_time(clock: Mapping[str, Any], camera_time: Array) -> Array:
    """Stamps of frames on the log's clock, s, by the record of a synchronisation."""
    slips = tuple(Slip(s["time_s"], s["frames"]) for s in clock.get("slips", ()))
    camera_time = Slips(slips, clock.get("frame_period_s", 0.0)).corrected(camera_time)
    skew = 1e-6 * clock["skew_ppm"]
    return camera_time + clock["offset_s"] + skew * (camera_time - clock["camera_middle_s"])


def white(sigma: Array, common: Array) -> Array:
    """The part of sigma that differs from frame to frame, of sigma and of what all frames share, rad."""
    return np.sqrt(np.maximum(sigma**2 - common**2, (_LEAST_WHITE * sigma) ** 2))


def frames_of(data: DataSet) -> Seen:
    """Frames on the log's clock; the state, thinned, where the data set has no frames or no clock for them."""
    alpha = data.angles.matrix("alpha")
    if "offset_s" in data.clock and alpha.shape[1] == data.neck.N:
        sigma, common = data.angles.matrix("sigma"), data.angles.matrix("common")
        sigma = sigma if sigma.shape == alpha.shape else np.full(alpha.shape, DEFAULT_SIGMA)
        common = common if common.shape == alpha.shape else np.zeros_like(alpha)
        return Seen(log_time(data.clock, data.angles.time), alpha, white(sigma, common), common)
    state = data.state
    rows = slice(None, None, max(1, round(1 / (FRAME_HZ * float(np.mean(np.diff(state.time)))))))
    alpha, sigma = state.matrix("alpha")[rows], state.matrix("sigma_alpha")[rows]
    sigma = sigma if sigma.shape == alpha.shape else np.full(alpha.shape, DEFAULT_SIGMA)
    return Seen(state.time[rows], alpha, sigma, np.zeros_like(sigma))
