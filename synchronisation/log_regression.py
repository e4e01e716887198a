"""What a log says of a motion that the video shows too, as factors: how far theta moves the cables, and how hard f pulls.

The winding of each cable, which the angles give whatever the log says, is regressed on the motor's travel and its force. The arm's
torques, M alpha'' + c + g, are regressed on Z f of every motor. Friction, elasticity and constants are left open. Neither asks for
more than a rough clock.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series, clear_of_gaps
from identification.filters import low_pass
from mechanism.arm import Arm
from mechanism.cable_lengths import Z
from mechanism.dynamics import gravity_and_springs, terms
from synchronisation.clocks.coarse_alignment import (
    CableSpeeds,
    align_stretched,
    cable_speeds,
    dry_direction,
    force_rates,
)
from synchronisation.clocks.exchanged_labels import MIN_CABLE_CORRELATION, MIN_CORRELATION
from synchronisation.clocks.frame_geometry import cable_winding
from synchronisation.clocks.signals import cubic_spline

Array = NDArray[np.float64]

RATE_HZ = 100.0
"""Hz: rate at which signals are filtered"""
EVERY = 4
"""every so many filtered rows there is a row of the regression"""
CUTOFF_HZ = 4.0
"""Hz: low-pass of all signals"""
SETTLING_S = 0.5
"""s left out at both ends and beside gaps between frames"""
MAX_BRIDGED_S = 0.5
"""s without frames that a spline may bridge"""
BLOCK_S = 1.0
"""s within which residuals may be correlated"""
MAX_RELATIVE_SIGMA = 0.2
"""relative standard deviation of a factor that is believed (docs/thresholds.md)"""
_MIN_SPAN_S = 0.1
"""s: shorter pieces have no speed; the clock says how long they must be"""
_LEAST_STRENGTH, _UNTOLD_SHARE = 1e-10, 1e-3
"""least eigenvalue, relative, of a direction that columns of unit length determine, and share of a column in one that they do not,
from which on it counts as not determined: both are rounding"""


@dataclass(frozen=True)
class Factors:
    """Factors with their standard deviations."""

    value: Array
    sigma: Array
    explained: float
    """share of the variance that the regression explains; of several, the least"""
    unexplained: float
    """RMS of what it leaves, in the unit of what is explained"""


@dataclass(frozen=True)
class LoggedMotion:
    """Video and log at K common instants."""

    alpha: Array
    """(K, N), rad"""
    alpha_d: Array
    alpha_dd: Array
    winding: Array
    """(K, M), m, by the angles"""
    travel: Array
    """(K, M), m, by the log"""
    speed: Array
    """(K, M), rad/s, of the motors"""
    acceleration: Array
    """(K, M), rad/s^2"""
    dry_friction: Array
    """(K, M), ratio"""
    force: Array
    """(K, M), N; (K, 0) where none is logged"""
    time: Array
    """(K,), s, log clock"""
    shift: float
    """s: log time less camera time"""
    signs: Array
    """(M,): 1 or -1, in which sense each motor runs"""
    follows: NDArray[np.bool_]
    """(M,): which cables follow their motors"""


def logged_motion(arm: Arm, time: Array, alpha: Array, log: Series) -> LoggedMotion | None:
    """The motion that frames at `time` (F,), s, with angles (F, N), rad, and a log of even steps show; None where they do not.

    Neither the unit of theta nor its sense matters."""
    if min(np.ptp(time), np.ptp(log.time)) < _MIN_SPAN_S:
        return None
    winding, travel = cable_winding(arm, alpha), arm.drum * log.matrix("theta")
    video, motors = cable_speeds(time, winding), cable_speeds(log.time, travel)
    if min(len(video.values), len(motors.values)) < 2:
        return None
    size = np.std(motors.values, axis=0)
    # each motor as fast as its cable: a log may have its motors in different units
    scale = np.std(video.values, axis=0) / np.where(size > 0, size, 1.0)
    rates = force_rates(log)
    for signs in _senses(video, motors):
        alignment, _ = align_stretched(video, replace(motors, values=motors.values * scale * signs), rates)
        if alignment.correlation >= MIN_CORRELATION:
            break
    else:
        return None
    follows = (alignment.cable_correlation >= MIN_CABLE_CORRELATION) & (size > 0)
    return _at_common_instants(arm, time, alpha, log, alignment.shift, signs, follows)


def travel_factors(motion: LoggedMotion, drum: Array) -> tuple[Factors, Array]:
    """How far each cable winds per travel that its motor logs, (M,), and by how many sigmas it yields the wrong way to its force.

    The second is (M,), zero without forces: cables under more force are longer, so it is far below zero for true ones."""
    m = motion.travel.shape[1]
    value, sigma, yielding, explained, left = np.zeros(m), np.full(m, np.inf), np.zeros(m), np.zeros(m), np.zeros(m)
    for j in range(m):
        columns, winding = _columns_of_winding(motion, j), motion.winding[:, j]
        slopes, errors, explained[j], left[j] = _least_squares(np.stack(columns, axis=-1), winding, motion.time)
        value[j], sigma[j] = slopes[0], errors[0]
        if motion.force.shape[1]:
            # a straight line alone: of a parabola the slope at zero force says nothing of the forces that were
            linear = np.stack([c for k, c in enumerate(columns) if k != 3], axis=-1)
            straight, of_straight, *_ = _least_squares(linear, winding, motion.time)
            yielding[j] = straight[2] / of_straight[2] if of_straight[2] > 0 else 0.0
    return Factors(value, sigma, float(np.min(explained)), float(np.sqrt(np.mean(left**2)))), yielding


def unexplained_winding(motion: LoggedMotion, cables: Sequence[int]) -> Array:
    """RMS of what travel and force leave of these cables' winding, (len(cables),), m."""
    columns = [np.stack(_columns_of_winding(motion, j), axis=-1) for j in cables]
    fits = [_least_squares(c, motion.winding[:, j], motion.time) for j, c in zip(cables, columns, strict=True)]
    return np.array([left for *_, left in fits])


def _columns_of_winding(motion: LoggedMotion, cable: int) -> list[Array]:
    """What a cable's winding is regressed on, (K,) each: its travel first, a constant, and where forces are known what these do."""
    columns = [motion.travel[:, cable], np.ones(len(motion.time))]
    if motion.force.shape[1]:
        f = motion.force[:, cable]
        columns += [f, f**2, motion.dry_friction[:, cable]]
    return columns


def force_factors(arm: Arm, motion: LoggedMotion) -> Factors:
    """How hard each motor's force pulls per newton that is logged, (M,), by what the described arm needs to move as it does."""
    jacobian, needed = Z(arm, motion.alpha), _needed_torque(arm, motion)
    of_motors = [jacobian * signal[:, None, :] for signal in (motion.force, motion.dry_friction, motion.speed)]
    columns = np.concatenate([*of_motors, _constants(arm, motion)], axis=-1).reshape(-1, 3 * arm.M + arm.N)
    value, sigma, explained, left = _least_squares(columns, needed.ravel(), np.repeat(motion.time, arm.N))
    return Factors(value[: arm.M], sigma[: arm.M], explained, left)


def _needed_torque(arm: Arm, motion: LoggedMotion) -> Array:
    """What cables must do for the described arm to move as it does, its motors' inertia included, (K, N), N m."""
    dynamics = terms(arm, motion.alpha, motion.alpha_d)
    of_motors = arm.motor_inertia / arm.drum * motion.acceleration
    needed = np.einsum("tij,tj->ti", dynamics.M, motion.alpha_dd) + dynamics.c + dynamics.g
    return needed + np.einsum("tij,tj->ti", Z(arm, motion.alpha), of_motors)


def _constants(arm: Arm, motion: LoggedMotion) -> Array:
    """A constant torque of each joint, (K, N, N)."""
    return np.broadcast_to(np.eye(arm.N), (len(motion.time), arm.N, arm.N))


@dataclass(frozen=True)
class GravityFit:
    """The gravity by which an arm moves as it does under its logged forces."""

    gravity: Array
    """(2,), m/s^2"""
    sigma: Array
    left: float
    """RMS of the torques that it leaves unexplained, N m"""
    left_as_described: float
    """RMS of those that the description's gravity leaves"""


def fitted_gravity(arm: Arm, motion: LoggedMotion) -> GravityFit:
    """With the forces' unit, the motors' friction and a constant torque of each joint left open."""
    weightless = replace(arm, gravity=np.zeros(2))
    jacobian, needed = Z(arm, motion.alpha), _needed_torque(weightless, motion)
    of_springs = gravity_and_springs(weightless, motion.alpha)
    by_gravity = np.stack(
        [gravity_and_springs(replace(arm, gravity=axis), motion.alpha) - of_springs for axis in np.eye(2)], axis=-1
    )
    pulled = np.einsum("tij,tj->ti", jacobian, motion.force)[..., None]
    friction = [jacobian * signal[:, None, :] for signal in (motion.dry_friction, motion.speed)]
    open_numbers = np.concatenate([pulled, *friction, _constants(arm, motion)], axis=-1)
    open_numbers = open_numbers.reshape(-1, open_numbers.shape[-1])
    time = np.repeat(motion.time, arm.N)
    columns = np.concatenate([by_gravity.reshape(-1, 2), open_numbers], axis=-1)
    value, sigma, _, left = _least_squares(columns, needed.ravel(), time)
    *_, as_described = _least_squares(open_numbers, (needed + by_gravity @ arm.gravity).ravel(), time)
    return GravityFit(-value[:2], sigma[:2], left, as_described)


def _senses(video: CableSpeeds, motors: CableSpeeds) -> list[Array]:
    """Signs (M,) of the motors that are tried: as logged, and as each correlates where most do."""
    m = video.values.shape[1]
    spectra = []
    length = len(video.values) + len(motors.values) - 1
    for a, b in zip(video.values.T, motors.values.T, strict=True):
        size = np.linalg.norm(a) * np.linalg.norm(b)
        product = np.fft.irfft(np.fft.rfft(b, length) * np.conj(np.fft.rfft(a, length)), length)
        spectra.append(product / size if size > 0 else np.zeros(length))
    lag = int(np.argmax(np.sum(np.abs(spectra), axis=0)))
    return [np.ones(m), np.where(np.array([s[lag] for s in spectra]) < 0, -1.0, 1.0)]


def _at_common_instants(
    arm: Arm, time: Array, alpha: Array, log: Series, shift: float, signs: Array, follows: NDArray[np.bool_]
) -> LoggedMotion | None:
    """Video and log, both filtered alike."""
    at = time + shift
    grid = np.arange(max(at[0], log.time[0]), min(at[-1], log.time[-1]), 1 / RATE_HZ)
    if len(grid) < 2 * SETTLING_S * RATE_HZ + EVERY:
        return None
    wide = np.diff(at) > MAX_BRIDGED_S
    gaps = zip(at[:-1][wide], at[1:][wide], strict=True)
    inside = (grid > grid[0] + SETTLING_S) & (grid < grid[-1] - SETTLING_S)
    kept = np.flatnonzero(inside & clear_of_gaps(grid, gaps, SETTLING_S))[::EVERY]
    if len(kept) < 2:
        return None

    def smooth(values: Array) -> Array:
        return low_pass(values, RATE_HZ, CUTOFF_HZ)

    def slope(values: Array) -> Array:
        return np.gradient(values, 1 / RATE_HZ, axis=0)

    a = smooth(cubic_spline(at, alpha)(grid))
    logged = {stem: log.matrix(stem) for stem in ("theta", "f")}
    theta, force = (
        smooth(np.stack([np.interp(grid, log.time, column) for column in values.T], axis=-1))
        if values.shape[1]
        else np.empty((len(grid), 0))
        for values in logged.values()
    )
    speed = slope(theta * signs)
    dry = smooth(dry_direction(speed))
    return LoggedMotion(
        alpha=a[kept],
        alpha_d=slope(a)[kept],
        alpha_dd=slope(slope(a))[kept],
        winding=cable_winding(arm, a[kept]),
        travel=(arm.drum * theta * signs)[kept],
        speed=speed[kept],
        acceleration=slope(speed)[kept],
        dry_friction=dry[kept],
        force=force[kept],
        time=grid[kept],
        shift=shift,
        signs=signs,
        follows=follows,
    )


def _least_squares(columns: Array, values: Array, time: Array) -> tuple[Array, Array, float, float]:
    """Coefficients of columns (K, P), their standard deviations, explained share of values (K,), and RMS of what is left.

    Residuals may be correlated within blocks of time (K,), s: the covariance is that of fits without one block each. In short
    logs few blocks hold what tells a column, and residuals are far smaller than errors there. The standard deviation of what
    the columns do not determine is infinite."""
    size = np.linalg.norm(columns, axis=0)
    unit = columns / np.where(size > 0, size, 1.0)
    coefficients = np.asarray(np.linalg.lstsq(unit, values, rcond=1e-5)[0], dtype=float)
    residual = values - unit @ coefficients
    strength, directions = np.linalg.eigh(unit.T @ unit)
    known = strength > _LEAST_STRENGTH * strength[-1]
    # a column that others make up, such as a force that never changes beside the constant, is not told at all
    told = np.all(np.abs(directions[:, ~known]) < _UNTOLD_SHARE, axis=1)
    changes = _without_each_block(unit @ directions[:, known], residual, time) @ directions[:, known].T
    # a single block tells nothing of what another one would say
    is_told = told & (len(changes) > 1)
    sigma = np.where(is_told, np.linalg.norm(changes, axis=0), np.inf)
    variance = float(np.sum((values - values.mean()) ** 2))
    explained = 1 - float(residual @ residual) / variance if variance > 0 else 0.0
    size = np.where(size > 0, size, 1.0)
    return coefficients / size, sigma / size, explained, float(np.sqrt(np.mean(residual**2)))


def _without_each_block(columns: Array, residual: Array, time: Array) -> Array:
    """Changes of coefficients of columns (K, P), which leave residuals (K,), without each block of time, (B, P).

    Their squares sum up to the variance."""
    block = ((time - time[0]) // BLOCK_S).astype(int)
    begins = np.flatnonzero(np.diff(block, prepend=-1))
    ends = np.append(begins[1:], len(block))
    scores = np.add.reduceat(columns * residual[:, None], begins, axis=0)
    parts = np.stack([columns[b:e].T @ columns[b:e] for b, e in zip(begins, ends, strict=True)])
    others = np.linalg.pinv(columns.T @ columns - parts, rcond=_LEAST_STRENGTH, hermitian=True)
    changes = -np.einsum("bij,bj->bi", others, scores)
    count = len(begins)
    return np.sqrt((count - 1) / count) * (changes - changes.mean(axis=0))
