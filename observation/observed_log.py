"""The joints along a log of motor angles and forces, with what the observer says of the arm's health."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.frames import FrameAngles
from identification.dataset.series import Series, numbered_columns
from identification.model_file import Model, pose_machine
from mechanism.description import Neck
from observation.health import SETTLING_S, HealthMonitor, as_json
from observation.load_test import find_loads
from observation.observer import MAX_GAP_S, Observed, Observer
from observation.smoother import smoothed
from xneck_foundation.errors import Refused
from xneck_foundation.one_blas_thread import one_blas_thread
from xneck_foundation.one_line import counted

Array = NDArray[np.float64]

START_SIGMA_RAD = 0.05
"""rad, of a pose that is told where a log begins, where nobody says better (docs/thresholds.md)"""


_LOAD_TEST_HZ = 10.0
"""rows in a second in which a load is looked for"""


@dataclass(frozen=True)
class ObservedLog:
    """Columns alphaI, alphaI_d, sigma_alphaI, sigma_alphaI_d on the log's clock, and the arm's health."""

    series: Series
    health: HealthMonitor
    frames_used: int
    restarts: int

    def as_json(self) -> dict[str, Any]:
        """The record of `xneck observe`."""
        sigma = self.series.matrix("sigma_alpha")
        rate = self.series.matrix("sigma_alpha", "_d")
        return {
            "rows": len(self.series),
            "frames_used": self.frames_used,
            "restarts": self.restarts,
            "sigma_alpha_rms_rad": np.sqrt(np.mean(sigma**2, axis=0)).tolist(),
            "sigma_alpha_d_rms_rad_s": np.sqrt(np.mean(rate**2, axis=0)).tolist(),
            "health": as_json(self.health),
        }


@one_blas_thread
def observe_log(
    neck: Neck,
    model: Model,
    log: Series,
    frames: FrameAngles | None = None,
    start: Array | None = None,
    smooth: bool = False,
    progress: Callable[[int], object] = lambda rows: None,
) -> ObservedLog:
    """The joints in every row of a log with columns thetaJ and fJ.

    frames: angles by a camera on the log's clock, where there are some. start: joint angles (N,), rad, where the log begins.
    smooth: each row by the rows after it too. Raises Refused where the log holds no forces, or the model was not identified for it.

    >>> import xneck
    >>> data = xneck.read_dataset("monday.mcap")
    >>> seen = xneck.observe(data.neck, xneck.read_model("model.yaml"), data.log)  # motors alone
    >>> seen.series.matrix("alpha").shape == (len(data.log), 3)  # rad
    True
    >>> seen.as_json()["health"]["verdict"]  # the sample carries something at its tip that its description lacks
    'changed'
    """
    theta, f = log.matrix("theta"), log.matrix("f")
    if theta.shape[1] != neck.M:
        raise Refused(
            "observe", f"the log holds {theta.shape[1]} motors, the arm has {neck.M}", "is it this arm's log?"
        )
    if f.shape[1] != neck.M:
        raise Refused("observe", "the log holds no forces f", "log the force command of every motor")
    if start is not None and len(start) != neck.N:
        raise Refused(
            "start", f"{counted(len(start), 'angle')} for {counted(neck.N, 'joint')}", "give one for each joint"
        )
    step_s = float(np.median(np.diff(log.time)))
    observer = Observer(neck, model, step_s)
    at_rows = _frames_at_rows(frames, log.time)
    monitor = HealthMonitor(observer.numbers.friction_sigma)
    layout = observer.numbers.layout
    gaps = np.concatenate([[False], np.diff(log.time) > MAX_GAP_S])

    every = max(1, round(1 / (_LOAD_TEST_HZ * step_s)))
    kept: list[tuple[Any, ...]] = []

    def take(row: int) -> Observed:
        angles, sigma = None, None
        if row == 0 and start is not None:
            angles, sigma = start, np.full(neck.N, START_SIGMA_RAD)
        elif row in at_rows and frames is not None:
            frame = at_rows[row]
            moved = observer.observed.alpha_d * (log.time[row] - frames.time[frame]) if row else 0.0
            angles = frames.alpha[frame] + moved
            sigma = np.hypot(frames.sigma[frame], frames.common[frame])
        observer.step(theta[row], f[row], float(log.time[row]), angles, sigma)
        return observer.observed

    def watched(row: int) -> Observed:
        seen = take(row)
        if gaps[row]:
            monitor.restart()
        monitor.add(float(log.time[row]), observer.friction_error, observer.state[layout.theta_d])
        if row % every == 0 and log.time[row] - log.time[0] >= SETTLING_S:
            s = observer.state
            kept.append((log.time[row], s[layout.alpha], s[layout.theta], s[layout.theta_d], s[layout.friction_error]))
        if row % 500 == 499:
            progress(500)
        return seen

    rows = [watched(row) for row in range(len(log))]
    if kept:
        times, angles, turned, speeds, unsaid = (np.array(v) for v in zip(*kept, strict=True))
        machine = pose_machine(model, neck)
        monitor.loads = find_loads(machine, times, angles, turned, speeds, unsaid, monitor.sigma)
    if smooth:
        observer.restart()
        rows = smoothed(observer, len(log), take)
    alpha, alpha_d = np.array([r.alpha for r in rows]), np.array([r.alpha_d for r in rows])
    sigma = np.sqrt(np.array([np.maximum(np.diag(r.covariance), 0.0) for r in rows]))
    columns = numbered_columns("alpha", alpha) | numbered_columns("alpha", alpha_d, "_d")
    columns |= numbered_columns("sigma_alpha", sigma[:, : neck.N])
    columns |= numbered_columns("sigma_alpha", sigma[:, neck.N :], "_d")
    return ObservedLog(Series(log.time, columns), monitor, len(at_rows), int(gaps.sum()))


def _frames_at_rows(frames: FrameAngles | None, time: Array) -> dict[int, int]:
    """Row of the log to the frame that is nearest to it, for frames within it that show something."""
    if frames is None:
        return {}
    out: dict[int, int] = {}
    for frame in np.flatnonzero((frames.time >= time[0]) & (frames.time <= time[-1])):
        if np.isfinite(frames.alpha[frame]).any():
            after = int(np.clip(np.searchsorted(time, frames.time[frame]), 1, len(time) - 1))
            row = after if time[after] - frames.time[frame] < frames.time[frame] - time[after - 1] else after - 1
            out[row] = int(frame)
    return out
