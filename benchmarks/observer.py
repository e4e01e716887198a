"""Joints told by motors alone, on held-out recordings of arms off their drawing, beside rigid cables and an unscented filter.

Each arm of samples/forward_arms is recorded twice for a minute. The first recording goes through `synchronise`, `identify` and
`calibrate_pose`; of the second the observer is given the log. Rigid cables are Fasquelle's own way: the angles at which cable
lengths fit the motors best, with the mean elongation of the first recording. The unscented filter is filterpy's, on the same
equations, noises and numbers, on the first seconds only, as it takes long.
"""

import ctypes
import shutil
import subprocess
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np
from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter
from numpy.typing import NDArray

from benchmarks.table import Claim, Table
from identification.dataset.dataset import DataSet
from identification.dataset.frames import FrameAngles
from identification.dataset.series import Series, numbered_columns
from identification.estimates import estimate
from identification.model_file import Model, model_of
from identification.pose_calibration import calibrated_model
from mechanism.arm import arm_of
from mechanism.cable_lengths import geometry_of_poses, lengths
from mechanism.description import Neck
from observation.c_source import c_source
from observation.health import verdict
from observation.observed_log import observe_log
from observation.observer import Observer
from samples.forward_arms import Settings, make_arms
from samples.forward_arms import arms as forward_arms
from samples.forward_arms.drawing import neck as neck_of
from synchronisation.angles import Angles
from synchronisation.synchronise import synchronise
from xneck_foundation.errors import Refused
from xneck_foundation.strict_yaml import validate_document

Array = NDArray[np.float64]

FIRST_COUNTED = 5200
"""nothing was set on these arms or on any after them; 5120, 5127, 5130, 5159, 5191, 5194 and 5196 were looked into"""
SEEDS = range(FIRST_COUNTED, FIRST_COUNTED + 20)
SETTINGS = Settings(seconds=60.0, drawing_off=1.0, noise_deg=0.02)
SLOW = Settings(
    seconds=60.0, drawing_off=1.0, noise_deg=0.02, motion="slow", tension="constant", recordings=1, first_recording=2
)
JUDGED_AFTER_S, JUDGED_HZ = 1.0, 50.0
UNSCENTED_S = 2.0
FRAME_EVERY_S = 1.0
TIMED_ROWS = 2000
COLUMNS = ("deg median", "deg worst", "% in .1", "% in .15", "deg/s worst", "NEES", "NEES rate")
LIMIT_DEG, LIMIT_95_DEG, LIMIT_RATE_DEG_S, LIMIT_STEP_US = 0.1, 0.15, 1.5, 300.0


@dataclass(frozen=True)
class Judged:
    """RMS errors of the joints (N,), deg and deg/s, and NEES per dimension of angles and of rates."""

    angle: Array
    rate: Array
    nees: float
    rate_nees: float


def description(arm: forward_arms.Arm) -> Neck:
    """neck.yaml of an arm, as drawn."""
    return validate_document(neck_of(arm.drawing), Neck, f"arm {arm.seed}")


def data_set(neck: Neck, recording: forward_arms.Recording) -> DataSet:
    """A recording as `sync` makes it."""
    film = recording.film
    return synchronise(
        neck, "", Angles(film.stamp, film.seen, np.full_like(film.seen, film.noise)), log_of(recording), {}
    )


def log_of(recording: forward_arms.Recording) -> Series:
    """What the controller wrote."""
    return Series(recording.time, numbered_columns("theta", recording.theta) | numbered_columns("f", recording.f))


def identified(data: DataSet) -> Model:
    """As `xneck identify` writes it."""
    fit = estimate([data])
    return calibrated_model(model_of(fit.parameters, fit.laws, {}, fit.covariance), [data]).model


def truth_of(recording: forward_arms.Recording) -> tuple[Array, Array]:
    """Angles and rates in the log's rows."""
    truth = recording.truth.within_log()
    rows = slice(None, None, truth.per_row)
    return truth.alpha[rows], truth.alpha_d[rows]


def judge(seen: Series, truth: tuple[Array, Array]) -> Judged:
    """Against the truth of its rows."""
    step = float(np.median(np.diff(seen.time)))
    rows = slice(round(JUDGED_AFTER_S / step), None, round(1 / (JUDGED_HZ * step)))
    out, nees = [], []
    for suffix, true in zip(("", "_d"), truth, strict=True):
        error = (seen.matrix("alpha", suffix) - true[: len(seen)])[rows]
        sigma = seen.matrix("sigma_alpha", suffix)[rows]
        out.append(np.degrees(np.sqrt(np.mean(error**2, axis=0))))
        nees.append(float(np.mean((error / sigma) ** 2)))
    return Judged(out[0], out[1], nees[0], nees[1])


def rigid_angles(neck: Neck, calibration: DataSet, theta: Array) -> Array:
    """Angles by cable lengths alone, (T, N), rad: elongations are the mean ones of a recording that was seen."""
    arm = arm_of(neck)
    elongation = calibration.state.matrix("x").mean(axis=0)
    wound = elongation - arm.x0 - arm.drum * theta
    alpha = np.zeros((len(theta), arm.N))
    rest = lengths(arm, np.zeros(arm.N))
    for _ in range(12):
        g = geometry_of_poses(arm, alpha)
        missing = wound - (g.length - rest)
        alpha = np.clip(alpha - np.einsum("tij,tj->ti", _pseudo_inverse(g.Z), missing), -1.5, 1.5)
    return alpha


def _pseudo_inverse(Z: Array) -> Array:
    """(Z Z^T)^-1 Z, (T, N, M)."""
    return np.linalg.solve(np.einsum("tij,tkj->tik", Z, Z), Z)


def unscented(neck: Neck, model: Model, log: Series) -> tuple[Array, float]:
    """Angles (T, N), rad, by filterpy's unscented filter on the observer's own equations and noises, and its time of a step, s."""
    observer = Observer(neck, model)
    theta, f = log.matrix("theta"), log.matrix("f")
    observer.step(theta[0], f[0])
    layout, numbers, h = observer.numbers.layout, observer.numbers, float(np.median(np.diff(log.time)))

    still = np.zeros(layout.size)

    def moved(x: Array, dt: float, since: float, force: Array) -> Array:
        return x + observer.prediction.step(x, still, force, dt, since).change

    points = MerweScaledSigmaPoints(layout.size, alpha=1.0, beta=2.0, kappa=0.0)
    ukf = UnscentedKalmanFilter(layout.size, layout.M, h, lambda x: x[layout.theta], moved, points)
    ukf.x, ukf.P, ukf.R = observer.state.copy(), _positive(observer.covariance), np.diag(numbers.theta_sigma**2)
    angles, begin = [ukf.x[layout.alpha] + ukf.x[layout.pose_error]], perf_counter()
    for row in range(1, len(theta)):
        ukf.Q = observer.prediction.noise(observer.prediction.step(ukf.x, still, f[row - 1], h, row * h))
        ukf.predict(since=row * h, force=f[row - 1])
        ukf.update(theta[row])
        ukf.P = _positive(ukf.P)
        angles.append(ukf.x[layout.alpha] + ukf.x[layout.pose_error])
    return np.array(angles), (perf_counter() - begin) / (len(theta) - 1)


def _positive(covariance: Array) -> Array:
    """Without what rounding leaves below zero: filterpy takes its Cholesky factor, and pre-elongations are all but exact."""
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-18))
    symmetric = (covariance + covariance.T) / 2
    size, vectors = np.linalg.eigh(symmetric / np.outer(scale, scale))
    root = scale[:, None] * vectors * np.sqrt(np.maximum(size, 1e-9))
    return root @ root.T


def step_times(neck: Neck, model: Model, log: Series) -> tuple[Array, Array | None]:
    """Times of each step of Python and of exported C, us; None where there is no compiler."""
    theta, f = np.ascontiguousarray(log.matrix("theta")), np.ascontiguousarray(log.matrix("f"))
    observer, python = Observer(neck, model), []
    for row in range(TIMED_ROWS):
        begin = perf_counter()
        observer.step(theta[row], f[row])
        python.append(perf_counter() - begin)
    compiler = next(filter(None, map(shutil.which, ("cc", "gcc", "clang"))), None)
    if compiler is None:
        return 1e6 * np.array(python), None
    with tempfile.TemporaryDirectory() as folder:
        source, library = Path(folder) / "observer.c", Path(folder) / "observer.so"
        source.write_text(c_source(observer))
        subprocess.run(
            [compiler, "-std=c99", "-O2", "-shared", "-fPIC", str(source), "-o", str(library), "-lm"], check=True
        )
        c, memory, own = ctypes.CDLL(str(library)), (ctypes.c_double * 20_000)(), []
        c.xneck_observer_begin(memory, None)
        pointer = ctypes.POINTER(ctypes.c_double)
        for row in range(TIMED_ROWS):
            given = (theta[row].ctypes.data_as(pointer), f[row].ctypes.data_as(pointer))
            begin = perf_counter()
            c.xneck_observer_step(memory, ctypes.c_double(2e-3), *given)
            own.append(perf_counter() - begin)
    return 1e6 * np.array(python), 1e6 * np.array(own)


def frames_of(recording: forward_arms.Recording) -> FrameAngles:
    """One frame of the camera a second, on the log's clock."""
    film = recording.film
    each = max(1, round(FRAME_EVERY_S / float(np.median(np.diff(film.log_time)))))
    seen = film.seen[::each]
    return FrameAngles(film.log_time[::each], seen, np.full_like(seen, film.noise), np.zeros_like(seen))


def measure(seeds: Iterable[int] = SEEDS) -> Table:
    """Shares of arms within limits, errors, NEES, health, and times of a step; an arm that is refused is within none."""
    seeds = list(seeds)
    refused: list[str] = []
    ours: list[Judged] = []
    with_frames: list[Judged] = []
    slow: list[Judged] = []
    rigid, peer, own_beside_peer, peer_times, quiet = [], [], [], [], []
    python: Array | None = None
    c: Array | None = None
    slow_arms = make_arms(seeds, SLOW)
    for arm, slow_arm in zip(make_arms(seeds, SETTINGS), slow_arms, strict=True):
        neck = description(arm)
        try:
            data = data_set(neck, arm.recordings[0])
            model = identified(data)
        except Refused as reason:
            refused.append(f"arm {arm.seed} ({reason})")
            continue
        log, truth = log_of(arm.recordings[1]), truth_of(arm.recordings[1])
        seen = observe_log(neck, model, log)
        ours.append(judge(seen.series, truth))
        quiet.append(verdict(seen.health) == "as identified")
        with_frames.append(judge(observe_log(neck, model, log, frames_of(arm.recordings[1])).series, truth))
        slowly = slow_arm.recordings[0]
        slow.append(judge(observe_log(neck, model, log_of(slowly)).series, truth_of(slowly)))
        rigid.append(_rms(rigid_angles(neck, data, log.matrix("theta")) - truth[0]))
        part = log.part(log.time < log.time[0] + UNSCENTED_S)
        if len(peer) < 3:
            angles, seconds = unscented(neck, model, part)
            peer.append(_rms(angles - truth[0][: len(part)]))
            own_beside_peer.append(_rms(seen.series.matrix("alpha")[: len(part)] - truth[0][: len(part)]))
            peer_times.append(seconds)
        if python is None:
            python, c = step_times(neck, model, log)
    assert python is not None
    return _table(ours, with_frames, slow, rigid, (peer, own_beside_peer, peer_times), quiet, (python, c), refused)


def _rms(error: Array) -> float:
    return float(np.degrees(np.sqrt(np.mean(error**2))))


def judged_row(runs: list[Judged], refused: int) -> tuple[float, ...]:
    """Of arms that were told, with the shares of all, those that were refused among them: COLUMNS."""
    worst = np.array([r.angle.max() for r in runs])
    count = len(runs) + refused
    return (
        float(np.median(worst)),
        float(worst.max()),
        float(100 * np.sum(worst <= LIMIT_DEG) / count),
        float(100 * np.sum(worst <= LIMIT_95_DEG) / count),
        float(max(r.rate.max() for r in runs)),
        float(np.mean([r.nees for r in runs])),
        float(np.mean([r.rate_nees for r in runs])),
    )


def _table(
    ours: list[Judged],
    with_frames: list[Judged],
    slow: list[Judged],
    rigid: list[float],
    unscented_runs: tuple[list[float], list[float], list[float]],
    quiet: list[bool],
    times: tuple[Array, Array | None],
    refused: list[str],
) -> Table:
    nothing = (None,) * 5
    peer, beside, seconds = unscented_runs
    python, c = times
    rows: list[tuple[str, tuple[float | None, ...]]] = [
        ("motors alone", judged_row(ours, len(refused))),
        ("one frame a second", judged_row(with_frames, len(refused))),
        ("slow motion, constant tension", judged_row(slow, len(refused))),
        ("rigid cables", (float(np.median(rigid)), max(rigid), *nothing)),
        (f"unscented filter, {UNSCENTED_S:g} s", (float(np.median(peer)), max(peer), *nothing)),
        (f"ours in the same {UNSCENTED_S:g} s", (float(np.median(beside)), max(beside), *nothing)),
    ]
    notes = [
        f"Refused: {'; '.join(refused) or 'none'}.",
        f"{sum(quiet)} of {len(quiet)} recordings in which nothing changed are said to be as identified.",
        f"A step of Python takes {np.median(python):.0f} us, {np.percentile(python, 99):.0f} in 99 of 100, the unscented filter's "
        f"{1e6 * np.median(seconds):.0f}"
        + ("." if c is None else f", of C {np.median(c):.0f}, {np.percentile(c, 99):.0f} in 99 of 100."),
    ]
    on = f"{len(ours)} arms off their drawing, held out"
    claims = (
        Claim("worst joint's rms, median of arms, deg", on, rows[0][1][0], ("rigid cables", rows[3][1][0])),
        Claim(
            "time of a step in Python, 99th percentile, us",
            "one core",
            float(np.percentile(python, 99)),
            None,
            ("needed", LIMIT_STEP_US),
        ),
    )
    return Table(
        f"Joints by motors alone, {len(ours) + len(refused)} arms of 60 s", COLUMNS, tuple(rows), claims, tuple(notes)
    )
