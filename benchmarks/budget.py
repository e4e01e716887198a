"""What each stage between the arm and its equations adds: true motions with one imperfection at a time.

Arms are integrated forward under a controller on counted angles, by a generator that shares no code with what reads them. A
recording is put together from their truth, with one thing as a lab has it; true numbers of the base laws then close the equations
but for that. Residuals are judged as `diagnose` judges them: motors' equations below 8 Hz, the arm's below 4 Hz, with angles that
nothing smoothed. `over noise` is the residual over what noise of 0.02 deg in the angles alone leaves. The last rows have everything
but noise, on arms of other kinds.
"""

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from benchmarks.table import Table
from benchmarks.tuned_seeds import FIRST_COUNTED_FORWARD_ARM
from diagnosis.judged_rows import judged
from identification.dataset.dataset import DataSet, state_series
from identification.dataset.frames import FrameAngles, spline_through_frames
from identification.dataset.half_row_speeds import HalfRowSpeeds, unrefined_speeds
from identification.dataset.series import Series, numbered_columns
from identification.motor_speeds import motor_speeds
from identification.residuals import law_forces, residuals_of
from identification.signals import signals_of
from mechanism.arm import arm_of
from mechanism.description import Neck
from mechanism.machine import Machine
from samples.forward_arms.arms import Arm, Recording, make_arms
from samples.forward_arms.drawing import neck
from samples.forward_arms.plant import ROW
from samples.forward_arms.settings import Settings
from state_estimation.motors import motors_of
from state_estimation.state import estimate_by_vision

Array = NDArray[np.float64]
Angles = tuple[Array, Array, Array]

SEEDS = range(FIRST_COUNTED_FORWARD_ARM, FIRST_COUNTED_FORWARD_ARM + 4)
SECONDS, EDGE_S = 15.0, 0.5
LAWS = ("dry_friction", "linear_cable")
NOISES_DEG = (0.005, 0.01, 0.02, 0.05, 0.1, 0.3)
REFERENCE_DEG = 0.02
BASE = Settings(base="exact", seconds=SECONDS, recordings=1)
KINDS = {
    "cables of 20 N s/m": replace(BASE, damping=(20.0, 21.0)),
    "cables of 800 N s/m": replace(BASE, damping=(790.0, 800.0)),
    "slow motion": replace(BASE, motion="slow"),
    "constant tension": replace(BASE, tension="constant"),
    "encoders of 8192 counts": replace(BASE, counts=8192),
    "commands late by 1 ms, known": replace(BASE, delay=1e-3),
    "commands late by 0.2 ms from row to row": replace(BASE, jitter=2e-4),
    "friction by a hyperbola": replace(BASE, base="near"),
    "friction that bends first": replace(BASE, base="presliding"),
}


@dataclass(frozen=True)
class Reading:
    """What is known of a recording at the log's rows within the video; all true to begin with."""

    arm: Arm
    recording: Recording
    inside: NDArray[np.bool_]
    angles: Angles
    """those that load the arm and stretch the cables"""
    theta: Angles
    speeds: HalfRowSpeeds
    delay: float = 0.0

    @property
    def described(self) -> Neck:
        """The arm as drawn."""
        return Neck.model_validate_json(json.dumps(neck(self.arm.drawing)))

    def residuals(self) -> Array:
        """Of the equations with true numbers, as they are judged, (C, S)."""
        plant, time = self.arm.plant, self.recording.time[self.inside]
        described, arm = self.described, arm_of(self.described)
        state = state_series(arm, time, self.angles, self.theta, self.recording.f[self.inside])
        columns = dict(state.columns) | numbered_columns("bridged", np.zeros_like(self.angles[0]))
        for suffix, values in zip(("", "_d", "_dd"), self.angles, strict=True):
            columns |= numbered_columns("vision", values, suffix)
        series = Series(time, columns)
        data = DataSet(
            neck=described, neck_yaml="", state=series, fasquelle=series, angles=series, log=series, speeds=self.speeds
        )
        s = signals_of(data, load_by_frames=True)
        values = {"fs": plant.dry, "cm": np.array([0.5]), "k": plant.stiffness, "ca": plant.damping}
        return judged(residuals_of(s, law_forces(s, LAWS, values, plant.x0 - arm.x0, self.delay)), s)


def measure() -> Table:
    """4 arms of 15 s; RMS over channels and arms, in N and mN m."""
    truths = list(_readings(BASE))
    seen = [_with_frames(r, _seen).residuals() for r in truths]
    noise = {
        deg: _rms([_with_frames(r, _noisy(deg)).residuals() - s for r, s in zip(truths, seen, strict=True)])
        for deg in NOISES_DEG
    }
    reference = noise[REFERENCE_DEG]
    rows = [_row(f"noise of {deg} deg alone", level, reference) for deg, level in noise.items()]
    for label, change in IMPERFECTIONS.items():
        rows.append(_row(label, _rms([change(r).residuals() for r in truths]), reference))
    for label, settings in KINDS.items():
        level = _rms([_as_read(r).residuals() for r in _readings(settings)])
        rows.append(_row(f"all but noise: {label}", level, reference))
    columns = ("motor N", "arm mN m", "motor over noise", "arm over noise")
    return Table("Budget: what each stage adds to the equations", columns, tuple(rows))


def _row(label: str, level: tuple[float, float], noise: tuple[float, float]) -> tuple[str, tuple[float | None, ...]]:
    return label, (level[0], 1e3 * level[1], level[0] / noise[0], level[1] / noise[1])


def _rms(residuals: list[Array]) -> tuple[float, float]:
    """Of the motors' channels and of the arm's; all arms have four motors."""
    motor, arm = (np.concatenate([r[part].ravel() for r in residuals]) for part in (slice(0, 4), slice(4, None)))
    return float(np.sqrt(np.mean(motor**2))), float(np.sqrt(np.mean(arm**2)))


def _readings(settings: Settings) -> Iterator[Reading]:
    for arm in make_arms(SEEDS, settings):
        (recording,) = arm.recordings
        truth, time, film = recording.truth.within_log(), recording.time, recording.film
        rows, half = slice(None, None, truth.per_row), truth.per_row // 2
        inside = (time >= film.log_time[0] + EDGE_S) & (time <= film.log_time[-1] - EDGE_S)
        step = ROW / truth.per_row
        theta_dd = np.gradient(truth.theta_d, step, axis=0)
        first = recording.truth.logged.start
        at = first + truth.per_row * np.arange(len(time))
        whole = recording.truth.theta
        before, after = (whole[at] - whole[at - half]) / (ROW / 2), (whole[at + half] - whole[at]) / (ROW / 2)
        count = 2 * np.pi / arm.plant.counts
        yield Reading(
            arm=arm,
            recording=recording,
            inside=inside,
            angles=(truth.alpha[rows][inside], truth.alpha_d[rows][inside], truth.alpha_dd[rows][inside]),
            theta=(truth.theta[rows][inside], truth.theta_d[rows][inside], theta_dd[rows][inside]),
            speeds=replace(unrefined_speeds(before[inside], count), mean=np.stack([before[inside], after[inside]])),
            delay=settings.delay,
        )


def _friction_at_rows(r: Reading) -> Reading:
    return replace(r, speeds=unrefined_speeds(r.theta[1], 2 * np.pi / r.arm.plant.counts))


def _counted(r: Reading) -> Reading:
    """Motor angles by splines through counts, and friction at their speed in the rows."""
    log = Series(r.recording.time, numbered_columns("theta", r.recording.theta) | numbered_columns("f", r.recording.f))
    count = 2 * np.pi / r.arm.plant.counts
    m = motors_of(log, count)
    return replace(
        r,
        theta=(m.theta[r.inside], m.theta_d[r.inside], m.theta_dd[r.inside]),
        speeds=unrefined_speeds(m.theta_d[r.inside], count),
    )


def _counted_with_laws(r: Reading) -> Reading:
    """Motor angles by splines through counts, friction at the speeds that the motors' equations tell within the rows."""
    r, plant = _counted(r), r.arm.plant
    described = arm_of(r.described)
    machine = Machine(described, ("dry_friction",), {"fs": plant.dry, "cm": np.array([0.5])})
    f = r.recording.f[r.inside]
    return replace(r, speeds=motor_speeds(described, machine, r.theta[0], f, ROW, 2 * np.pi / plant.counts))


def _instants(r: Reading) -> tuple[Array, Array]:
    truth, film = r.recording.truth, r.recording.film
    return film.log_time, CubicHermiteSpline(truth.time, truth.alpha, truth.alpha_d)(film.log_time)


def _seen(r: Reading) -> tuple[Array, Array]:
    return r.recording.film.log_time, r.recording.film.mean


def _late(seconds: float) -> Callable[[Reading], tuple[Array, Array]]:
    def frames(r: Reading) -> tuple[Array, Array]:
        time, mean = _seen(r)
        return time + seconds, mean

    return frames


def _noisy(deg: float) -> Callable[[Reading], tuple[Array, Array]]:
    def frames(r: Reading) -> tuple[Array, Array]:
        time, mean = _seen(r)
        return time, mean + np.radians(deg) * np.random.default_rng(r.arm.seed).standard_normal(mean.shape)

    return frames


def _with_frames(r: Reading, frames: Callable[[Reading], tuple[Array, Array]]) -> Reading:
    time, alpha = frames(r)
    return replace(r, angles=spline_through_frames(time, alpha, r.recording.time[r.inside]))


def _smoothed(r: Reading) -> Reading:
    """By the smoother that vision alone has, as noise of 0.02 deg has it smooth."""
    time, alpha = _noisy(REFERENCE_DEG)(r)
    frames = FrameAngles(time, alpha, np.full_like(alpha, np.radians(REFERENCE_DEG)), np.zeros_like(alpha))
    priors = estimate_by_vision(frames, r.recording.time[r.inside]).priors
    smooth = estimate_by_vision(replace(frames, alpha=_seen(r)[1]), r.recording.time[r.inside], priors)
    return replace(r, angles=(smooth.alpha, smooth.alpha_d, smooth.alpha_dd))


def _as_read(r: Reading) -> Reading:
    return _with_frames(_counted_with_laws(r), _seen)


IMPERFECTIONS: dict[str, Callable[[Reading], Reading]] = {
    "nothing: true states in rows and half rows": lambda r: r,
    "friction at the rows' speed": _friction_at_rows,
    "counts: splines, friction at the rows' speed": _counted,
    "counts: speeds by the motors' equations": _counted_with_laws,
    "frames, without exposure": lambda r: _with_frames(r, _instants),
    "frames, means over the exposure": lambda r: _with_frames(r, _seen),
    "frames, smoothed as vision alone is at 0.02 deg": _smoothed,
    "clock off by 0.1 ms": lambda r: _with_frames(r, _late(1e-4)),
    "commands taken to be 0.1 ms late": lambda r: replace(r, delay=1e-4),
    "all but noise": _as_read,
}
