"""Speeds of motors within the rows of a log: exact where nothing is smoothed away, and near the truth where friction turns over.

The motors are integrated here by another rule at a twentieth of a row, and their angles counted.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from identification.dataset.half_row_speeds import HalfRowSpeeds, unrefined_speeds
from identification.decimation import decimating_filter
from identification.motor_drive import STEPS_PER_ROW, MotorDrive
from identification.motor_speeds import motor_speeds
from mechanism.arm import Arm, arm_of
from mechanism.description import read_neck
from mechanism.laws import MotorMotion
from mechanism.machine import Machine
from state_estimation.smoother import smooth_signal
from tests.identification.test_estimates import FILE

Array = NDArray[np.float64]
ROW, FINE = 0.002, 20
FS, CM = np.array([11.0, 14.0, 17.0, 19.0]), 0.5
COUNT = 2 * np.pi / 2048
WIDTHS = np.array([0.02, 0.03, 0.05, 0.1])
"""rad, over which bristles bend where motors have some"""
BENT = np.array([0.8, -0.5, 0.3, -0.9])
"""how far, of their greatest bend, they are bent where the recording begins"""


def arm() -> Arm:
    return arm_of(read_neck(FILE))


def machine(fs: Array = FS) -> Machine:
    return Machine(arm(), ("dry_friction",), {"fs": fs, "cm": np.array([CM])})


def bristly() -> Machine:
    """All of the friction bends bristles before it slides."""
    names = ("dry_friction", "presliding_friction")
    return Machine(arm(), names, {"fs": FS, "cm": np.array([CM]), "fp": FS, "wp": WIDTHS, "bend0": BENT})


@dataclass(frozen=True)
class Turned:
    """Motors that turn round often, at the rows: counted angles and commands; and their true speeds on a finer grid."""

    theta: Array
    """(T, M), not rounded"""
    f: Array
    speed: Array
    """((T - 1) FINE + 1, M)"""
    friction: Array
    """of the same shape, N"""

    @property
    def counted(self) -> Array:
        return np.round(self.theta / COUNT) * COUNT

    @property
    def friction_over_rows(self) -> Array:
        """Mean dry friction from half a row before each inner row to half a row after it, (T - 2, M), N."""
        area = np.vstack([np.zeros(4), np.cumsum((self.friction[1:] + self.friction[:-1]) / 2, axis=0)]) / FINE
        return area[FINE // 2 + FINE :: FINE][: len(self.theta) - 2] - area[FINE // 2 :: FINE][: len(self.theta) - 2]


@cache
def turned(seed: int, seconds: float = 6.0, bristles: bool = False) -> Turned:
    """By Heun's rule under a controller that sees counts and is fed most of the friction; tension has little above 3 Hz."""
    rng, a = np.random.default_rng(seed), arm()
    rows, step, rate = round(seconds / ROW) + 1, ROW / FINE, a.drum / a.motor_inertia
    time = step * np.arange((rows - 1) * FINE + 1)
    hertz = np.concatenate([rng.uniform(0.2, 2.5, (4, 4)), rng.uniform(3.0, 8.0, (2, 4))])
    size = np.concatenate([np.full((4, 4), 6.0), np.full((2, 4), 0.03)])
    tension = 50 + np.sum(
        size * np.sin(2 * np.pi * hertz * time[:, None, None] + rng.uniform(0, 6, hertz.shape)), axis=1
    )
    wanted = 30 * np.sin(2 * np.pi * 0.9 * time[::FINE, None] + rng.uniform(0, 6, 4)) * np.sin(0.7 * time[::FINE, None])
    theta, speed, bend, rubs = (np.zeros((len(time), 4)) for _ in range(4))
    bend[0], rubs[0] = BENT, FS * BENT * bristles
    f, counted = np.zeros((rows, 4)), np.zeros((2, 4))

    def friction(v: Array, z: Array) -> Array:
        return FS * z if bristles else FS * 2 / np.pi * np.arctan(CM * v)

    def rise(v: Array, z: Array, i: int, force: Array) -> Array:
        return rate * (force - friction(v, z) - tension[i])

    def bending(v: Array, z: Array) -> Array:
        return (v - np.abs(v) * z) / WIDTHS

    for n in range(rows):
        i = n * FINE
        counted = np.stack([counted[1], np.round(theta[i] / COUNT) * COUNT])
        error, error_d = wanted[n] - counted[1], -(counted[1] - counted[0]) / ROW
        f[n] = 50 + 9 * error + 0.12 * error_d + 0.8 * FS * np.tanh(error)
        if n == rows - 1:
            break
        for k in range(i, i + FINE):
            first, bends = rise(speed[k], bend[k], k, f[n]), bending(speed[k], bend[k])
            then = speed[k] + step * first
            bent = bend[k] + step * bends
            speed[k + 1] = speed[k] + step * (first + rise(then, bent, k + 1, f[n])) / 2
            bend[k + 1] = bend[k] + step * (bends + bending(then, bent)) / 2
            theta[k + 1] = theta[k] + step * (speed[k] + speed[k + 1]) / 2
            rubs[k + 1] = friction(speed[k + 1], bend[k + 1])
    return Turned(theta[::FINE], f, speed, rubs)


def speeds_of(made: Turned, theta: Array, fs: Array = FS) -> HalfRowSpeeds:
    return motor_speeds(arm(), machine(fs), theta, made.f, ROW, np.full(4, COUNT))


def friction_error(made: Turned, mean: Array) -> Array:
    """RMS error of dry friction within the equations' band, (M,), N."""
    return band_error(made, FS * (2 / np.pi * np.arctan(CM * mean)).mean(axis=0))


def bristles_error(made: Turned, speeds: HalfRowSpeeds) -> Array:
    """The same of friction that bends bristles."""
    memory = bristly().memory_on_path(speeds.path(ROW))
    return band_error(made, FS * memory[..., 0].reshape(-1, 2, 4).mean(axis=1))


def band_error(made: Turned, friction: Array) -> Array:
    error = friction[1:-1] - made.friction_over_rows
    return np.sqrt(np.mean(decimating_filter(ROW, np.ones(len(error), bool))(error.T) ** 2, axis=1))


def spline_speeds(made: Turned) -> Array:
    """Speeds of a spline through the counts, at the rows, (T, M), rad/s."""
    sigma, time = np.full(len(made.theta), COUNT / np.sqrt(12)), ROW * np.arange(len(made.theta), dtype=float)
    return np.stack([smooth_signal(time, c, sigma, time, 0.01).d1 for c in made.counted.T], axis=-1)


def test_friction_at_reversals_comes_nearer_to_the_truth_than_by_a_spline() -> None:
    """On motors that turn round several times a second: half of what a spline through the counts leaves, at most."""
    made = turned(1)
    reversals = np.sum(np.diff(np.sign(made.speed[::FINE]), axis=0) != 0, axis=0)
    assert reversals.min() > 10
    by_spline = friction_error(made, unrefined_speeds(spline_speeds(made), np.full(4, COUNT)).mean)
    by_equation = friction_error(made, speeds_of(made, made.counted).mean)
    assert np.sqrt(np.mean(by_equation**2)) < np.sqrt(np.mean(by_spline**2)) / 2


def test_friction_that_bends_comes_nearer_to_the_truth_than_by_a_spline() -> None:
    """Bristles make friction depend on all of the path: half of what a spline through the counts leaves, at most."""
    made = turned(1, bristles=True)
    by_equation = motor_speeds(arm(), bristly(), made.counted, made.f, ROW, np.full(4, COUNT))
    by_spline = unrefined_speeds(spline_speeds(made), np.full(4, COUNT))
    one, other = (np.sqrt(np.mean(bristles_error(made, speeds) ** 2)) for speeds in (by_equation, by_spline))
    assert one < other / 2


def test_speeds_do_not_depend_on_where_the_search_for_them_begins() -> None:
    """With bristles, from the counts and from the true angles: within a tenth of what rounding leaves unknown."""
    made, step = turned(2, bristles=True), ROW / STEPS_PER_ROW
    rows = np.arange(STEPS_PER_ROW * (len(made.theta) - 1) + 1) / STEPS_PER_ROW
    held = np.repeat(made.f[:-1], STEPS_PER_ROW, axis=0)
    a, still = arm(), np.zeros_like(held)
    inertia = np.broadcast_to(a.motor_inertia / a.drum, (4,))
    drive = MotorDrive(bristly(), held, inertia, step, MotorMotion(still, still, still))
    true = np.vstack([np.zeros(4), np.cumsum((made.speed[1:] + made.speed[:-1]) / 2, axis=0)]) * ROW / FINE
    starts = [
        np.stack([np.interp(rows, np.arange(len(c)), c) for c in made.counted.T], axis=-1),
        true[:: FINE // STEPS_PER_ROW],
    ]
    sigma = np.full(4, COUNT / np.sqrt(12))
    one, other = (
        np.diff(drive.smoothed(s, np.full((4, 1), bend), made.counted, sigma, np.full(4, 15.0)).angles, axis=0)
        for s, bend in zip(starts, (0.5, -0.5), strict=True)
    )
    hertz = np.linspace(0.05, 60, 1200)
    unknown = HalfRowSpeeds(np.zeros((2, 1, 4)), np.full(4, 15.0), sigma)
    speed_sigma = np.sqrt(np.trapezoid(unknown.error_density(hertz, ROW), hertz, axis=0))
    assert np.all(np.sqrt(np.mean((one - other) ** 2, axis=0)) / step < speed_sigma / 10)


def test_what_rounding_leaves_unknown_of_speeds_is_as_large_as_said() -> None:
    """Error over sigma where motors are not about to turn round: there friction tells nothing of the speed."""
    ratios = []
    for seed in (1, 2):
        made = turned(seed)
        got = speeds_of(made, made.counted)
        hertz = np.linspace(0.05, 60, 1200)
        sigma = np.sqrt(np.trapezoid(got.error_density(hertz, ROW), hertz, axis=0))
        error = got.mean.mean(axis=0) - made.speed[::FINE]
        fast = np.abs(made.speed[::FINE]) > 5
        fast[:100] = fast[-100:] = False
        ratios.append([np.sqrt(np.mean(error[fast[:, j], j] ** 2)) / sigma[j] for j in range(4)])
    # some 60 independent errors of each motor
    assert 0.75 < np.sqrt(np.mean(np.square(ratios))) < 1.4


def test_motion_under_a_straight_tension_is_exact() -> None:
    """Unrounded cubics: theta'' is straight, the command held, so that the tension has no second difference to be smoothed away."""
    time = ROW * np.arange(800)
    theta = np.outer(40 * time**3 - 30 * time**2 + 3 * time, [1.0, -1.0, 0.5, 2.0])
    f = np.full((800, 4), 60.0)
    got = motor_speeds(arm(), machine(np.zeros(4)), theta, f, ROW, np.full(4, COUNT))
    half = (time[:, None] + np.array([-0.5, 0.5]) * ROW / 2).T[..., None]
    exact = (120 * half**2 - 60 * half + 3) * np.array([1.0, -1.0, 0.5, 2.0]) + 10 * ROW**2 / 4 * np.array(
        [1.0, -1.0, 0.5, 2.0]
    )
    np.testing.assert_allclose(got.mean[:, 2:-2], exact[:, 2:-2], atol=2e-6)


def test_coarser_counts_lower_the_cutoff() -> None:
    made = turned(2)
    fine, coarse = (
        motor_speeds(arm(), machine(), np.round(made.theta / c) * c, made.f, ROW, np.full(4, c)).cutoff
        for c in (COUNT / 8, COUNT * 2)
    )
    assert coarse.mean() < fine.mean()


def test_friction_that_is_a_little_off_costs_little() -> None:
    """Friction is fitted before speeds are: a hundredth of it, several of its sigmas."""
    made = turned(1)
    right, wrong = (friction_error(made, speeds_of(made, made.counted, FS * share).mean) for share in (1.0, 0.99))
    assert np.sqrt(np.mean(wrong**2)) < 1.5 * np.sqrt(np.mean(right**2))


def test_commands_act_as_the_machine_says() -> None:
    """Motors that give two thirds of what the log says: with that law speeds are those of motors that were told so much less."""
    made = turned(2)
    laws = Machine(arm(), ("dry_friction", "actuator_gain"), {"fs": FS, "cm": np.array([CM]), "g": np.full(4, 0.5)})
    told = motor_speeds(arm(), laws, made.counted, 1.5 * made.f, ROW, np.full(4, COUNT))
    np.testing.assert_allclose(told.mean, speeds_of(made, made.counted).mean, atol=1e-6)
