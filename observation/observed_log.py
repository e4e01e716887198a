"""The joints along a log of motor angles and forces, with what the observer says of the arm's health."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset import DataSet
from identification.dataset.frames import FrameAngles, frame_angles
from identification.dataset.same_log import check_same_log
from identification.dataset.series import Series, numbered_columns
from identification.dataset.true_rows import true_rows
from identification.model_file import Model, pose_machine
from mechanism.description import Neck
from observation.checked_row import checked_numbers
from observation.frame_consistency import FrameConsistency, frame_consistency
from observation.health import SETTLING_S, HealthMonitor, as_json
from observation.load_test import JointRows, find_loads
from observation.logged_forces import check_forces
from observation.observer import Innovation, Observed, Observer
from observation.smoother import smoothed
from xneck_foundation.errors import Refused
from xneck_foundation.one_blas_thread import one_blas_thread
from xneck_foundation.one_line import counted

Array = NDArray[np.float64]

START_SIGMA_RAD = 0.05
"""rad, of a pose that is told where a log begins, where nobody says better (docs/thresholds.md)"""
_LOAD_TEST_HZ = 10.0
"""rows in a second in which a load is looked for"""
_PROGRESS_ROWS = 500
"""rows after which progress is told"""


@dataclass(frozen=True)
class ObservedLog:
    """Columns alphaI, alphaI_d, sigma_alphaI, sigma_alphaI_d on the log's clock, rad and rad/s, and the arm's health."""

    series: Series
    health: HealthMonitor
    frames_used: int
    restarts: int
    consistency: FrameConsistency | None
    """of the frames; None where there are too few to tell"""

    @property
    def doubt(self) -> str | None:
        """Of the frames, for a person; None where the arm's health says enough."""
        changed = self.health.healthy is False
        return None if changed or self.consistency is None else self.consistency.doubt

    def as_json(self) -> dict[str, Any]:
        """The record of `xneck observe`."""
        sigma = self.series.matrix("sigma_alpha")
        rate = self.series.matrix("sigma_alpha", "_d")
        return {
            "rows": len(self.series),
            "frames_used": self.frames_used,
            "frames_misfit": None if self.consistency is None else self.consistency.misfit,
            "frames_doubt": self.doubt,
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
    frames: FrameAngles | DataSet | None = None,
    start: Array | None = None,
    smooth: bool = False,
    progress: Callable[[int], object] = lambda rows: None,
) -> ObservedLog:
    """The joints in every row of a log with columns thetaJ, rad, and fJ, N, but for rows that repeat the one before (true_rows.py).

    frames: angles by a camera on the log's clock, or the data set that was made of them and this log. start: joint angles (N,),
    rad, where the log begins. smooth: each row by the rows after it too. progress: called with the number of rows done since
    the last call. Raises Refused where the log holds no forces, the model was not identified for it, or frames are not this log's.

    >>> import xneck
    >>> data = xneck.read_dataset("monday.mcap")
    >>> seen = xneck.observe(data.neck, xneck.read_model("model.yaml"), data.log)  # motors alone
    >>> seen.series.matrix("alpha").shape == (len(data.log), 3)  # rad
    True
    >>> seen.as_json()["health"]["verdict"]  # the sample carries something at its tip that its description lacks
    'changed'
    """
    _check(neck, log, start)
    if isinstance(frames, DataSet):
        check_same_log(frames, log, "frames")
        frames = frame_angles(frames)
    if frames is not None and frames.alpha.shape[1] != neck.N:
        what = f"they have {counted(frames.alpha.shape[1], 'angle')}, the arm has {neck.N}"
        raise Refused("frames", what, "are they this arm's?")
    log = true_rows(log, "the log")
    step_s = float(np.median(np.diff(log.time)))
    observer = Observer(neck, model, step_s)
    check_forces(log)
    seen = None if frames is None else _FramesAtRows(frames, log.time)
    rows = _Rows(observer, log, seen, start)
    # frames that an observer was told of, 30 in a second, stand beside it by little, whatever their clock
    alone = None if seen is None else _MotorsAlone(Observer(neck, model, step_s), log, seen, start)
    monitor = HealthMonitor(observer.numbers.friction_sigma, observer.numbers.dry_friction)
    after_gap = np.concatenate([[False], np.diff(log.time) > observer.gap_s])
    each = max(1, round(1 / (_LOAD_TEST_HZ * step_s)))
    observed: list[Observed] = []
    load_rows, states, accelerations = list[int](), list[Array](), list[Array]()
    for row, time in enumerate(log.time.tolist()):
        observed.append(rows.take(row))
        if alone is not None:
            alone.take(row)
        if after_gap[row]:
            monitor.restart()
        monitor.add(time, observer.friction_error, observer.state[observer.numbers.layout.theta_d])
        if row % each == 0 and time - log.time[0] >= SETTLING_S:
            load_rows.append(row)
            states.append(observer.state)
            accelerations.append(observer.acceleration)
        if row % _PROGRESS_ROWS == _PROGRESS_ROWS - 1:
            progress(_PROGRESS_ROWS)
    monitor.end()
    consistency = None if alone is None else frame_consistency(alone.times, alone.innovations)
    if consistency is not None and monitor.doubted is None:
        consistency.check()
    if states:
        s, layout = np.array(states), observer.numbers.layout
        monitor.loads = find_loads(
            pose_machine(model, neck),
            JointRows(log.time[load_rows], s[:, layout.alpha], s[:, layout.alpha_d], np.array(accelerations)),
            s[:, layout.theta],
            s[:, layout.theta_d],
            s[:, layout.friction_error],
            monitor.sigma,
        )
    if smooth:
        told_by_all_frames = observer.correction.settled()
        observer.restart()
        observer.correction = told_by_all_frames
        observed = smoothed(observer, len(log), rows.take)
    return ObservedLog(
        series=_columns(log.time, observed, monitor.doubted_from),
        health=monitor,
        frames_used=0 if seen is None else len(seen.at),
        restarts=int(after_gap.sum()),
        consistency=consistency,
    )


def _check(neck: Neck, log: Series, start: Array | None) -> None:
    """Raises Refused where a log or the angles at its beginning are not this arm's."""
    motors = log.matrix("theta").shape[1]
    if motors != neck.M:
        raise Refused(
            "observe", f"the log holds {counted(motors, 'motor')}, the arm has {neck.M}", "is it this arm's log?"
        )
    if log.matrix("f").shape[1] != neck.M:
        raise Refused("observe", "the log holds no forces f", "log the force command of every motor")
    if start is not None and not np.all(np.abs(checked_numbers("start", start, neck.N)) < np.pi):
        raise Refused("observe", "start holds angles that are not within +-180 deg", "give them in rad")


class _FramesAtRows:
    """Frames of a camera within a log, at the rows that are nearest to each."""

    def __init__(self, frames: FrameAngles, time: Array) -> None:
        self._frames, self._time = frames, time
        self.at: dict[int, int] = {}
        """frames that show a joint, by their rows"""
        for frame in np.flatnonzero((frames.time >= time[0]) & (frames.time <= time[-1])):
            if np.isfinite(frames.alpha[frame]).any():
                after = int(np.clip(np.searchsorted(time, frames.time[frame]), 1, len(time) - 1))
                row = after if time[after] - frames.time[frame] < frames.time[frame] - time[after - 1] else after - 1
                self.at[row] = int(frame)

    def told_at(self, row: int, alpha_d: Array | None) -> tuple[Array, Array] | None:
        """Angles (N,), rad, and their sigmas, of the frame at a row; None where there is none.

        alpha_d: of the joints, (N,), rad/s, by which they moved from the frame's time to the row's; None where nothing is known."""
        if row not in self.at:
            return None
        frames, frame = self._frames, self.at[row]
        moved = 0.0 if alpha_d is None else alpha_d * (self._time[row] - frames.time[frame])
        return frames.alpha[frame] + moved, np.hypot(frames.sigma[frame], frames.common[frame])


class _Rows:
    """The rows of a log, which an observer takes one after the other, with frames of a camera where they belong."""

    def __init__(self, observer: Observer, log: Series, seen: _FramesAtRows | None, start: Array | None) -> None:
        self._observer, self._log, self._seen, self._start = observer, log, seen, start
        self._theta, self._f = log.matrix("theta"), log.matrix("f")

    def take(self, row: int) -> Observed:
        """Makes the observer, which has taken the row before, take this one."""
        angles, sigma = self._told_at(row) or (None, None)
        self._observer.step(self._theta[row], self._f[row], float(self._log.time[row]), angles, sigma)
        return self._observer.observed

    def _told_at(self, row: int) -> tuple[Array, Array] | None:
        """Angles (N,), rad, that are told at a row, with their sigmas."""
        if row == 0 and self._start is not None:
            return np.asarray(self._start), np.full(len(self._start), START_SIGMA_RAD)
        return self._seen and self._seen.told_at(row, self._observer.observed.alpha_d if row else None)


class _MotorsAlone:
    """An observer that goes through a log without its frames, and what each of these stands beside it."""

    def __init__(self, observer: Observer, log: Series, seen: _FramesAtRows, start: Array | None) -> None:
        self._observer, self._log, self._seen = observer, log, seen
        self._rows = _Rows(observer, log, None, start)
        self.times: list[float] = []
        """s, of the frames"""
        self.innovations: list[Innovation] = []

    def take(self, row: int) -> None:
        """The next row, and the frame that is at it."""
        observed = self._rows.take(row)
        frame = self._seen.told_at(row, observed.alpha_d)
        if frame and (innovation := self._observer.innovation(*frame)):
            self.times.append(float(self._log.time[row]))
            self.innovations.append(innovation)


def _columns(time: Array, observed: list[Observed], doubted_from: float) -> Series:
    """Angles, rates, and the sigmas of both, at times (T,), s; of a log that is doubted from some time on no sigma is known."""
    n = len(observed[0].alpha)
    sigma = np.sqrt(np.array([np.diag(o.covariance) for o in observed]))
    sigma[time >= doubted_from] = np.nan
    columns = numbered_columns("alpha", np.array([o.alpha for o in observed]))
    columns |= numbered_columns("alpha", np.array([o.alpha_d for o in observed]), "_d")
    columns |= numbered_columns("sigma_alpha", sigma[:, :n])
    columns |= numbered_columns("sigma_alpha", sigma[:, n:], "_d")
    return Series(time, columns)
