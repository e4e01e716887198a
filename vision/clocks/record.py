"""The clock as a data set's record states it."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vision.clocks.slips import Slip, Slips

Array = NDArray[np.float64]


def log_time(clock: Mapping[str, Any], camera_time: Array) -> Array:
    """Stamps of frames on the log's clock, s, by the record of a synchronisation."""
    slips = tuple(Slip(s["time_s"], s["frames"]) for s in clock.get("slips", ()))
    camera_time = Slips(slips, clock.get("frame_period_s", 0.0)).corrected(camera_time)
    skew = 1e-6 * clock["skew_ppm"]
    return camera_time + clock["offset_s"] + skew * (camera_time - clock["camera_middle_s"])
