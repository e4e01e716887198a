"""A clock between camera and log, as a recording's motion or a light gives it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.clock_record import LostFrames
from synchronisation.clocks.light import LightClock
from synchronisation.clocks.log_gaps import RepairedLog

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ClockEstimate:
    """Camera to log: log time = true camera time + offset + skew (true camera time - middle)."""

    offset: float
    """s"""
    offset_sigma: float
    """s; infinite where neither motion nor light gave a clock"""
    skew: float
    """ratio by which the log's clock runs faster"""
    skew_sigma: float
    middle: float
    """camera time at which the offset holds, s"""
    correlation: float
    """correlation of the cables' speeds in video and log at the coarse alignment"""
    second_peak: float
    """the next best shift's correlation over the best one's"""
    residual_rms: Array
    """(M,), m: RMS residual of each cable's equation"""
    source: str
    """what the clock rests on: `cables and arm`, `cables without forces`, `light`"""
    lost: LostFrames
    """frames lost without a trace, and the frames' period"""
    repaired: RepairedLog
    """the log without repeated rows, and its gaps"""
    warnings: tuple[str, ...]
    delay: tuple[float, float] | None = None
    """by how much forces act later than the log says, and its sigma, s; None where no motion gave it"""
    light: LightClock | None = None
    """the light's clock, where that is the source"""
    motion_offset: tuple[float, float] | None = None
    """where a light is the source: the offset that cables and arm would give, and its sigma, s"""

    def log_time(self, stamp: Array) -> Array:
        """Times on the log's clock, s, of frames at their stamps, s; of the same shape."""
        true_time = self.lost.corrected(stamp)
        return true_time + self.offset + self.skew * (true_time - self.middle)
