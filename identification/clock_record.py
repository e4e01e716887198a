"""The camera's clock against the log's, as a data set's record states it, and the frames that were lost without a trace."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


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
