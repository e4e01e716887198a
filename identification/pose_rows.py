"""What is known of a recording where motors shall tell the joints: rows of the log, and the frames of the camera."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset import DataSet
from identification.dataset.frames import FrameAngles, frame_angles
from identification.dataset.series import interpolated

Array = NDArray[np.float64]

_ROWS_HZ = 50.0
"""rate at which the equations are formed"""
_UNTOLD_CLOCK_SIGMA_S, _UNTOLD_SKEW_SIGMA = 4e-3, 3e-5
"""s, and ratio, of a recording's clock where its data set does not say how well it is aligned (docs/thresholds.md)"""
_LEAST_CLOCK_SIGMA_S, _LEAST_SKEW_SIGMA = 1e-5, 1e-6
"""s, and ratio, at least (docs/thresholds.md)"""


@dataclass(frozen=True)
class PoseRows:
    """What is known of one recording at rows of `step` s, and its frames."""

    step: float
    time: Array
    alpha: Array
    alpha_d: Array
    alpha_dd: Array
    theta: Array
    theta_d: Array
    theta_dd: Array
    f: Array
    frames: FrameAngles
    log_time: Array
    """of all rows of the state, (R,), s"""
    state: tuple[Array, Array, Array]
    """alpha with its derivatives in them, each (R, N)"""
    clock_sigma: float
    """s, of the offset; not wider than `sync` says it is: play and friction that no law has look like a late clock"""
    skew_sigma: float
    count_angles: Array
    """(M,), rad, in which motors' angles were logged"""


def rows_of(data: DataSet) -> PoseRows:
    """The rows and frames of a data set."""
    state = data.state
    log_step = float(np.mean(np.diff(state.time)))
    part = slice(None, None, max(1, round(1 / (_ROWS_HZ * log_step))))
    f = state.matrix("f")
    f = np.concatenate([f[:1], (f[:-1] + f[1:]) / 2])  # a force holds from its row on
    frames = frame_angles(data)
    margin = 2 / _ROWS_HZ
    frames = frames.within(state.time[0] + margin, state.time[-1] - margin)
    frames = frames.clear_of(data.clock.get("log_gaps", ()), margin)
    alpha, bridged = frames.alpha, state.matrix("bridged")
    if bridged.size:  # where the state was not seen it is no place to linearise at
        alpha = np.where(interpolated(frames.time, state.time, bridged) > 0, np.nan, alpha)
    names = [("alpha", s) for s in ("", "_d", "_dd")] + [("theta", s) for s in ("", "_d", "_dd")]
    alpha0, alpha_d, alpha_dd, theta, theta_d, theta_dd = (state.matrix(*name)[part] for name in names)
    offset_sigma, skew_ppm = data.clock.get("offset_sigma_s"), data.clock.get("skew_sigma_ppm")
    return PoseRows(
        step=log_step * part.step,
        time=state.time[part],
        alpha=alpha0,
        alpha_d=alpha_d,
        alpha_dd=alpha_dd,
        theta=theta,
        theta_d=theta_d,
        theta_dd=theta_dd,
        f=f[part],
        frames=replace(frames, alpha=alpha),
        log_time=state.time,
        state=(state.matrix("alpha"), state.matrix("alpha", "_d"), state.matrix("alpha", "_dd")),
        clock_sigma=max(float(offset_sigma), _LEAST_CLOCK_SIGMA_S) if offset_sigma else _UNTOLD_CLOCK_SIGMA_S,
        skew_sigma=max(1e-6 * float(skew_ppm), _LEAST_SKEW_SIGMA) if skew_ppm else _UNTOLD_SKEW_SIGMA,
        count_angles=data.count_angles,
    )
