"""The arm's equation of the clock, Z t = M alpha'' + c + g + joint friction: it tells motor viscosity from the offset.

In t = n - fs dry(theta') - fv theta' the force n comes late by a delay. Through the cables alone fv looks like an offset (5 ms
for 0.02 N s/rad); here it turns the joints by Z fv theta', which no friction of the joints does. Masses, springs, a load at the
tip, the base's tilt, the motors' inertia, and joint friction with the speed at which it turns over are nuisances. So are the arm's
geometry and the form of the motors' friction, which the cables' equation holds too: if each had a form of its own, the two would
trade viscosity for the clock. Gains of motors and what cables lose on pulleys along the arm are nuisances of lossy arms alone. Both
sides pass the same filters.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_interp_spline
from scipy.ndimage import minimum_filter1d

from identification.dataset.series import clear_of_gaps
from identification.filters import low_pass
from mechanism.arm import Arm
from mechanism.cable_lengths import Z
from mechanism.dynamics import gravity_and_springs
from synchronisation.clocks.angles_between_frames import missed_by_spline
from synchronisation.clocks.arm_nuisances import (
    joint_dry_friction,
    nuisance_priors,
    parts,
    pulley_losses,
    tilt_torque,
    torque,
    torque_by_free_length,
)
from synchronisation.clocks.frame_geometry import GEOMETRY_STEP, FrameGeometry, changed_geometries
from synchronisation.clocks.signals import LogSignals, cubic_spline
from synchronisation.clocks.unknowns import ClockUnknowns

Array = NDArray[np.float64]

FILTER_RATE_HZ = 100.0
"""Hz: rate at which signals are filtered"""
PRODUCT_RATE_HZ = 25.0
"""Hz: rate at which products of signals are formed"""
FACTOR_CUTOFF_HZ = 8.0
"""Hz: low-pass of every signal before products are formed"""
EQUATION_CUTOFF_HZ = 4.0
"""Hz: low-pass of both sides; vision's noise in alpha'' grows with the square of the frequency"""
PRODUCTS_PER_ROW = 2
"""every so many products there is a row"""
MAX_BRIDGED_S = 0.2
"""s without frames that are bridged"""
MAX_BRIDGED_PERIODS = 1.5
"""periods of the camera without frames that are bridged however long they are: between any two frames the cables tell"""
SETTLING_S = 0.4
"""s left out beside wider gaps and at both ends, where filters settle"""
SLOW_JOINT_RAD_S = 0.02
"""rad/s: friction may hold a slower joint by any torque, so what its rows miss is a class of its own (docs/thresholds.md)"""
_SLOW_PRODUCTS = 5
"""products, about a row, in none of which the joint is slow"""
_OFFSET_STEP_S = 2e-3
"""s: change of the offset whose effect gives its slope"""


@dataclass(frozen=True)
class ArmRows:
    """Rows of the arm's equation: K instants, N joints; residual in N m, its slopes by the unknowns."""

    residual: Array
    """(K, N), N m, at fv = fs = 0, the described geometry, no delay and no nuisance"""
    by_offset: Array
    """(K, N)"""
    by_delay: Array
    """(K, N)"""
    by_geometry: Array
    """(K, N, P)"""
    by_fs: Array
    """(K, N, M)"""
    by_fv: Array
    """(K, N, M)"""
    by_form: Array
    """(K, N, M, W): by the forms of the motors' friction, N, which the cables' equation holds too"""
    by_force: Array
    """(K, N, M), m/rad: by the motors' forces"""
    by_nuisance: Array
    """(K, N, Q): parts of the arm, tilt, motors' inertia, gain, losses on pulleys, joints' dry friction, its turning over, viscous,
    constant friction"""
    nuisance_sigma: Array
    """(Q,): standard deviation of each nuisance around zero; infinite where nothing is known"""
    of_lossy: NDArray[np.bool_]
    """(Q,): nuisances of lossy arms alone"""
    time: Array
    """(K,), s, log clock"""
    offset: float
    """s: offset of the clock that the rows were made with"""
    joint_speed: Array
    """(T, N), rad/s: joint speeds where the products are formed"""
    kept: NDArray[np.bool_]
    """(T,): products that are clear of gaps and ends"""
    error_by_noise: Array
    """(N,), N m: what noise of the angles, as it is stated, leaves at the least. With one joint all terms may go to zero together,
    and the error with them"""
    may_be_held: NDArray[np.bool_]
    """(K, N): rows about which the joint hardly moves, so that friction may hold it by any torque; of lossy arms alone"""

    def residual_at(self, unknowns: ClockUnknowns, forms: Array) -> Array:
        """Residuals (K, N), N m, at an estimate near the one that the rows were made with; forms: (M, W), N, of friction."""
        m = len(unknowns.fv)
        fs, nuisances = unknowns.arm_parameters[:m], unknowns.arm_parameters[m:]
        out = self.residual + self.by_offset * (unknowns.offset - self.offset) + self.by_delay * unknowns.delay
        out = out + self.by_geometry @ unknowns.geometry_errors + np.einsum("knmw,mw->kn", self.by_form, forms)
        return out + self.by_fv @ unknowns.fv + self.by_fs @ fs + self.by_nuisance @ nuisances

    def of_sound_arm(self) -> "ArmRows":
        """The same rows where every motor pulls as it is told, cables lose nothing on their way and nothing holds a joint."""
        kept = ~self.of_lossy
        return replace(
            self,
            by_nuisance=self.by_nuisance[..., kept],
            nuisance_sigma=self.nuisance_sigma[kept],
            of_lossy=self.of_lossy[kept],
            may_be_held=np.zeros_like(self.may_be_held),
        )

    def with_joint_width(self, width: float) -> "ArmRows":
        """The same rows where a joint's dry friction turns over at another speed, rad/s."""
        n = self.residual.shape[1]
        nuisance = self.by_nuisance.copy()
        nuisance[..., -4 * n : -2 * n] = _rows_of(joint_dry_friction(self.joint_speed, width), self.kept)
        return replace(self, by_nuisance=nuisance)


@dataclass(frozen=True)
class HeldMotors:
    """Motors that friction holds at rest by any force up to its greatest. What it is, only the cables' elongations tell."""

    motors: NDArray[np.bool_]
    """(M,): which of them"""
    tension: Array
    """(F, M), N: of their cables in each frame, by the elongation"""


@dataclass(frozen=True)
class _Motion:
    """Frames and log signals after the first filter, at the T instants where products are formed."""

    time: Array
    """(T,), s, log clock"""
    seen: BSpline
    """(..., N), rad, over log time: the spline through the frames"""
    told: BSpline
    """(..., N), rad, over log time: the same of the frames with what the cables tell of their noise taken off"""
    missed: tuple[BSpline, BSpline]
    """(..., N), rad: what that spline misses, by the clock as it is and by one whose offset is larger by _OFFSET_STEP_S"""
    force: Array
    """(T, M), N, and so all below: n"""
    dry_friction: Array
    friction_forms: tuple[Array, ...]
    speed: Array
    command_rate: Array
    inertial: Array

    def angles(self, later: bool = False) -> tuple[Array, Array, Array]:
        """alpha, alpha', alpha'' (T, N), by the clock as it is or by the later one."""
        # of two clocks the spline through the frames is one and the same: noise must not enter their difference
        at = self.time - _OFFSET_STEP_S if later else self.time
        a, a_d, a_dd = (self.seen(at, order) + self.missed[later](self.time, order) for order in range(3))
        return a, a_d, a_dd

    def angles_without_noise(self) -> tuple[Array, Array, Array]:
        """alpha, alpha', alpha'' (T, N), as the cables tell them."""
        a, a_d, a_dd = (self.told(self.time, order) + self.missed[0](self.time, order) for order in range(3))
        return a, a_d, a_dd


def arm_equation_rows(
    arm: Arm,
    signals: LogSignals,
    frame_time: Array,
    frames: FrameGeometry,
    turns: Array,
    winding: BSpline,
    cable_error: Array,
    joint_width: float,
    offset: float,
    fs: Array,
    held: HeldMotors,
) -> ArmRows:
    """The equation for frames at `frame_time` (F,), s, on the log's clock.

    turns: (F, N), rad, by which the frames' angles are off what the cables tell; winding: (..., M), m, over log time: travel less
    elongation, which tells the angles between frames; cable_error: (M,), m, of the cables' laws; joint_width: rad/s, speed over
    which a joint's dry friction turns over; offset: s, of the clock that gave frame_time; fs: (M,), N, roughly the motors' dry
    friction, for the slopes by the geometry."""
    motion = _filtered(arm, signals, frame_time, frames.alpha, turns, winding, cable_error, held)
    kept = _clear_of_gaps(motion.time, frame_time)
    a, a_d, a_dd = motion.angles()
    unbalanced = torque(arm, a, a_d, a_dd) - np.einsum("tnm,tm->tn", Z(arm, a), motion.force)
    b, b_d, b_dd = motion.angles(later=True)
    later = torque(arm, b, b_d, b_dd) - np.einsum("tnm,tm->tn", Z(arm, b), motion.force)
    # slopes by numbers of the arm must not hold the noise that residuals hold too: least squares would shrink the arm
    a, a_d, a_dd = motion.angles_without_noise()
    jacobian = Z(arm, a)
    by_part = np.stack([torque(part, a, a_d, a_dd) for part in parts(arm)], axis=-1)
    joint_speed = low_pass(a_d, PRODUCT_RATE_HZ, EQUATION_CUTOFF_HZ)
    per_joint = np.eye(arm.N)
    nuisances = [
        by_part,
        torque_by_free_length(arm, a),
        tilt_torque(arm, a)[..., None],
        jacobian * motion.inertial[:, None, :],
        jacobian * motion.force[:, None, :],
        pulley_losses(arm, jacobian, motion.force, joint_speed),
        joint_dry_friction(joint_speed, joint_width),
        a_d[..., None] * per_joint,
        np.ones_like(a_d)[..., None] * per_joint,
    ]
    nuisance_sigma, of_lossy = nuisance_priors(arm)
    slowest = minimum_filter1d(np.abs(joint_speed), _SLOW_PRODUCTS, axis=0)
    return ArmRows(
        residual=_rows_of(unbalanced, kept),
        by_offset=_rows_of((later - unbalanced) / _OFFSET_STEP_S, kept),
        by_delay=_rows_of(np.einsum("tnm,tm->tn", jacobian, motion.command_rate), kept),
        by_geometry=_rows_of(_torque_by_geometry(arm, motion, fs), kept),
        by_fs=_rows_of(jacobian * motion.dry_friction[:, None, :], kept),
        by_fv=_rows_of(jacobian * motion.speed[:, None, :], kept),
        by_form=_rows_of(np.stack([jacobian * form[:, None, :] for form in motion.friction_forms], axis=-1), kept),
        by_force=_rows_of(jacobian, kept),
        by_nuisance=_rows_of(np.concatenate(nuisances, axis=-1), kept),
        nuisance_sigma=nuisance_sigma,
        of_lossy=of_lossy,
        time=motion.time[::PRODUCTS_PER_ROW][kept[::PRODUCTS_PER_ROW]],
        offset=offset,
        joint_speed=joint_speed,
        kept=kept,
        error_by_noise=_error_by_noise(arm, a, motion.force, _noise_passed(frame_time, frames.noise_factor)),
        may_be_held=(slowest < SLOW_JOINT_RAD_S)[::PRODUCTS_PER_ROW][kept[::PRODUCTS_PER_ROW]],
    )


def _filtered(
    arm: Arm,
    signals: LogSignals,
    frame_time: Array,
    alpha: Array,
    turns: Array,
    winding: BSpline,
    cable_error: Array,
    held: HeldMotors,
) -> _Motion:
    """Angles and log signals over their common time, through the first filter."""
    first, last = max(frame_time[0], signals.time[0]), min(frame_time[-1], signals.time[-1])
    grid = np.arange(first, last, 1 / FILTER_RATE_HZ)
    every = round(FILTER_RATE_HZ / PRODUCT_RATE_HZ)

    rests = signals.at_rest(grid) & held.motors

    def filtered(values: Array) -> Array:
        return low_pass(values, FILTER_RATE_HZ, FACTOR_CUTOFF_HZ)[::every]

    def sampled(curve: BSpline) -> Array:
        return filtered(curve(grid))

    def smooth(values: Array) -> BSpline:
        return cubic_spline(grid, low_pass(values, FILTER_RATE_HZ, FACTOR_CUTOFF_HZ))

    def missed(later: float) -> BSpline:
        return smooth(missed_by_spline(arm, grid, frame_time + later, alpha, winding, cable_error))

    return _Motion(
        time=grid[::every],
        seen=smooth(cubic_spline(frame_time, alpha)(grid)),
        told=smooth(cubic_spline(frame_time, alpha + turns)(grid)),
        missed=(missed(0.0), missed(_OFFSET_STEP_S)),
        force=filtered(np.where(rests, make_interp_spline(frame_time, held.tension, k=1)(grid), signals.force(grid))),
        dry_friction=filtered(~rests * signals.dry_friction(grid)),
        friction_forms=tuple(filtered(~rests * form(grid)) for form in signals.friction_forms),
        speed=filtered(~rests * signals.speed(grid)),
        command_rate=sampled(signals.command.derivative()),
        inertial=sampled(signals.inertial),
    )


def _noise_passed(frame_time: Array, factor: Array) -> Array:
    """What makes the angles' noise that passes the filters, rad, of independent noise of unit variance, (N, N).

    factor: the same of each frame's, (F, N, N)."""
    share = min(2 * EQUATION_CUTOFF_HZ * float(np.median(np.diff(frame_time))), 1.0)
    return np.linalg.cholesky(share * np.mean(factor @ np.swapaxes(factor, 1, 2), axis=0))


def _error_by_noise(arm: Arm, a: Array, force: Array, noise: Array) -> Array:
    """Standard deviation of the torque, (N,), N m, that noise of angles makes by the arm's stiffness alone.

    noise: what makes it of independent noise of unit variance, (N, N), rad."""

    def held(alpha: Array) -> Array:
        return gravity_and_springs(arm, alpha) - np.einsum("tnm,tm->tn", Z(arm, alpha), force)

    described = held(a)
    changes = [held(a + step) - described for step in noise.T]
    return np.sqrt(np.sum(np.mean(np.square(changes), axis=1), axis=0))


def _torque_by_geometry(arm: Arm, motion: _Motion, fs: Array) -> Array:
    """Slope of the equation by each number of the geometry, (T, N, P), N m."""
    tension = motion.force - fs * motion.dry_friction
    a, a_d, a_dd = motion.angles_without_noise()

    def unbalanced(other: Arm, at: Array) -> Array:
        return torque(other, at, a_d, a_dd) - np.einsum("tnm,tm->tn", Z(other, at), tension)

    described = unbalanced(arm, a)
    changes = [unbalanced(other.arm, a + other.turn) - described for other in changed_geometries(arm)]
    return np.stack(changes, axis=-1) / GEOMETRY_STEP


def _rows_of(values: Array, kept: NDArray[np.bool_]) -> Array:
    """Products (T, ...) through the last filter, at the rows (K, ...)."""
    filtered = low_pass(values, PRODUCT_RATE_HZ, EQUATION_CUTOFF_HZ)
    return filtered[::PRODUCTS_PER_ROW][kept[::PRODUCTS_PER_ROW]]


def _clear_of_gaps(time: Array, frame_time: Array) -> NDArray[np.bool_]:
    """Which times (T,), s, are clear of both ends and of gaps between frames at frame_time (F,), s."""
    steps = np.diff(frame_time)
    wide = steps > max(MAX_BRIDGED_S, MAX_BRIDGED_PERIODS * float(np.median(steps)))
    gaps = zip(frame_time[:-1][wide], frame_time[1:][wide], strict=True)
    inside = (time > time[0] + SETTLING_S) & (time < time[-1] - SETTLING_S)
    return inside & clear_of_gaps(time, gaps, SETTLING_S)
