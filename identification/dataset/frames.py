"""Angles in the camera's frames, on the log's clock, of a data set."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from identification.dataset.clock_record import log_time
from identification.dataset.dataset import DataSet
from identification.dataset.series import clear_of_gaps

Array = NDArray[np.float64]

DEFAULT_SIGMA_RAD = np.radians(0.1)
"""rad: sigma assumed for angles that come without one; the data set says so (docs/thresholds.md)"""
MAX_SIGMA_RAD = 2 * np.pi
"""rad: largest sigma that an angle may have; at it nothing is known (docs/thresholds.md)"""
MAX_ORDINARY_SIGMA = 4.0
"""times the median sigma beyond which a frame has no say in clock and check (docs/thresholds.md)"""
STATE_AS_FRAMES_HZ = 25.0
"""Hz: rate at which the state replaces the frames of a data set that has none"""
_MIN_WHITE_SHARE = 0.05
"""share of sigma that differs from frame to frame at least: no angle is free of noise (docs/thresholds.md)"""


@dataclass(frozen=True)
class FrameAngles:
    """Angles in F frames: times (F,) on the log's clock, s; angles and sigmas (F, N), rad, NaN where a joint was not measured."""

    time: Array
    alpha: Array
    sigma: Array
    """standard deviation of the error that differs from frame to frame"""
    common: Array
    """standard deviation of the error that all frames share"""

    def within(self, first: float, last: float) -> "FrameAngles":
        """Frames from `first` to `last`, s."""
        part = (self.time >= first) & (self.time <= last)
        return self._part(part)

    def clear_of(self, gaps: Iterable[Sequence[float]], margin: float) -> "FrameAngles":
        """Frames at least `margin`, s, before the begin or after the end of every gap, s."""
        return self._part(clear_of_gaps(self.time, gaps, margin))

    def _part(self, part: NDArray[np.bool_]) -> "FrameAngles":
        return FrameAngles(self.time[part], self.alpha[part], self.sigma[part], self.common[part])


def frame_angles(data: DataSet) -> FrameAngles:
    """Frames of a data set on the log's clock; the state, thinned, where it has no frames or no clock for them."""
    n, alpha = data.arm.N, data.angles.matrix("alpha")
    if "offset_s" in data.clock and alpha.shape[1] == n:
        sigma, common = data.angles.matrix("sigma"), data.angles.matrix("common")
        sigma = sigma if sigma.shape == alpha.shape else np.full(alpha.shape, DEFAULT_SIGMA_RAD)
        common = common if common.shape == alpha.shape else np.zeros_like(alpha)
        return FrameAngles(log_time(data.clock, data.angles.time), alpha, white_sigma(sigma, common), common)
    state = data.state
    rows = slice(None, None, max(1, round(1 / (STATE_AS_FRAMES_HZ * float(np.mean(np.diff(state.time)))))))
    alpha, sigma = state.matrix("alpha")[rows], state.matrix("sigma_alpha")[rows]
    sigma = sigma if sigma.shape == alpha.shape else np.full(alpha.shape, DEFAULT_SIGMA_RAD)
    return FrameAngles(state.time[rows], alpha, sigma, np.zeros_like(sigma))


def spline_through_frames(frames: Array, alpha: Array, time: Array) -> tuple[Array, Array, Array]:
    """Angles, rates and accelerations (T, N) at `time` (T,) by quintic splines through every frame: not smoothed, not fused.

    frames: (F,), s; alpha: (F, N), rad, NaN where not measured.
    """
    measured = np.isfinite(alpha)
    if np.array_equal(measured.any(axis=1), measured.all(axis=1)):
        # frames that show all joints or none: one factorisation serves all
        whole = make_interp_spline(frames[measured[:, 0]], alpha[measured[:, 0]], k=5)
        return whole(time), whole(time, 1), whole(time, 2)
    splines = [make_interp_spline(frames[k], a[k], k=5) for k, a in zip(measured.T, alpha.T, strict=True)]
    value, rate, acceleration = (np.stack([s(time, d) for s in splines]).T for d in range(3))
    return value, rate, acceleration


def ordinary_frames(alpha: Array, sigma: Array) -> NDArray[np.bool_]:
    """Frames (F,) in which all angles are known, and none has a much larger sigma than in most, as of a frame that stands out.

    alpha, sigma: (F, N), rad. Where that leaves fewer than half, all that are known."""
    known = np.asarray(np.isfinite(alpha).all(axis=1))
    if not known.any():
        return known
    within = np.nan_to_num(sigma) <= MAX_ORDINARY_SIGMA * np.median(sigma[known], axis=0)
    ordinary = known & np.asarray(within.all(axis=1))
    return ordinary if ordinary.sum() > known.sum() / 2 else known


def white_sigma(sigma: Array, common: Array) -> Array:
    """The part of sigma that differs from frame to frame, (F, N), rad."""
    return np.sqrt(np.maximum(sigma**2 - common**2, (_MIN_WHITE_SHARE * sigma) ** 2))
