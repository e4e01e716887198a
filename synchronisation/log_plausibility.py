"""Whether a log can mean what its columns say: angles of the motors in rad, forces on the cables in N, of this arm in this video.

What the video shows of the cables is geometry and owes nothing to the log, so that a log in another unit is known by a factor far
from one. The factor is given a unit's name only where it is that unit's alone; else the number itself is said. Faults that the
clock's own checks name, exchanged columns and senses, are left to them.
"""

import numpy as np
from numpy.typing import NDArray

from identification.dataset.constant_forces import constant_forces
from identification.dataset.series import Series, numbered_columns
from mechanism.arm import Arm
from mechanism.cable_lengths import lengths
from mechanism.description import Neck
from mechanism.neck_template import MOTOR
from synchronisation.angle_meanings import other_meanings, quarter_turns
from synchronisation.angles import Angles
from synchronisation.clocks.coarse_alignment import MIN_OVERLAP_S
from synchronisation.clocks.frame_geometry import cable_winding
from synchronisation.clocks.usable_frames import MIN_FRAMES
from synchronisation.encoder_log import uniformly_sampled
from synchronisation.exchanged_columns import exchanged_columns
from synchronisation.force_plausibility import MAX_UNEXPLAINED_SHARE, WRONG_WAY, WRONG_WAY_SIGMA, check_forces
from synchronisation.gravity_plausibility import other_gravity
from synchronisation.log_regression import (
    MAX_RELATIVE_SIGMA,
    Factors,
    LoggedMotion,
    logged_motion,
    travel_factors,
    unexplained_winding,
)
from synchronisation.log_units import theta_units, unit_of_motors
from synchronisation.unit_words import SURE_TOLERANCE, column_names, times, to_write, unit_named, what_to_write
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import counted

Array = NDArray[np.float64]

MIN_TRAVEL_FACTOR, MIN_TRAVEL_FACTOR_WITHOUT_FORCE, MAX_TRAVEL_FACTOR = 0.6, 0.3, 1.6
"""ratio of a cable's winding to what its motor logs, beyond which theta is refused: elastic cables wind less, and without forces
nobody knows how much less (docs/thresholds.md)"""
TRAVEL_TOLERANCE, TRAVEL_TOLERANCE_WITHOUT_FORCE = 0.2, 0.5
"""log of the ratio between a measured factor and a unit's, within which the unit may be it: elastic cables wind less
(docs/thresholds.md)"""
MIRROR_RATIO = 1.15
"""ratio of what mirrored angles and motors leave unexplained to what the recording leaves as it is: forces are reversed beyond it,
the arm is mirrored beyond its inverse, and between them it may be either (docs/thresholds.md)"""
USUAL_RATES_HZ = (10.0, 12.0, 15.0, 20.0, 24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 90.0, 100.0, 120.0, 240.0)
"""of cameras, that a tracker may have been told wrongly"""
OTHER_MEANING_RATIO = 1.15
"""ratio of what angles leave unexplained as they are to what they leave by another meaning, beyond which that is theirs
(docs/thresholds.md)"""
MIN_RATE_ERROR = 0.02
"""relative: by less a rate is the same (docs/thresholds.md)"""
MIN_LEVER_M = 1e-3
"""m: of a cable that moves any joint (docs/thresholds.md)"""
_TURNED_RAD = 0.3
"""by which joints turn, one after the other, to see whether a cable's length changes"""
MIN_STUCK_S = 1.0
"""s for which an encoder must not move at all, to be called stuck (docs/thresholds.md)"""
STUCK_SHARE, MIN_STUCK_M = 0.4, 5e-3
"""share of a cable's whole way, and m, that it must move meanwhile in the video: elasticity does not do that
(docs/thresholds.md)"""


def check_log_meaning(neck: Neck, arm: Arm, angles: Angles, log: Series) -> tuple[str, ...]:
    """Warnings; Refused, with what to write into neck.yaml, where theta or f cannot mean what they should.

    Says nothing where log and video do not show one motion, whatever the units, or are too short: the clock's checks say why."""
    ordinary = angles.ordinary
    time, alpha = angles.time[ordinary], angles.alpha[ordinary]
    if len(time) < MIN_FRAMES or min(np.ptp(time), np.ptp(log.time)) < MIN_OVERLAP_S:
        return ()
    _check_levers(arm)
    even = uniformly_sampled(log)
    warnings = (*_example_scales(neck), *_constant_forces(even))
    motion = logged_motion(arm, time, alpha, even)
    if motion is None:
        _check_degrees(arm, time, alpha, even)
        _check_other_meanings(arm, time, alpha, even, np.inf)
        _check_frame_rate(arm, time, alpha, even)
        return warnings
    if np.any(quarter_turns(alpha)):
        _check_other_meanings(arm, time, alpha, even, _unexplained_share(arm, motion))
    _check_stuck(arm, time, alpha, even, motion)
    if exchange := exchanged_columns(arm, motion):
        left, described = 1e3 * exchange.left, 1e3 * exchange.described
        what = f"{exchange.words}: {left:.3f} mm are left unexplained so, {described:.3f} as it is"
        raise Refused("sync", what, exchange.remedy)
    factors, yielding = travel_factors(motion, arm.drum)
    wrong = _wrong_travel(motion, factors)
    if len(wrong):
        _check_theta_units(neck, motion, factors.value, wrong)
        _check_degrees(arm, time, alpha, even)
        what = _travel_words(factors.value, wrong)
        remedy = "check R, rd and theta_scale of these motors in neck.yaml; is one of these cables slack?"
        raise Refused("log", what, remedy)
    if motion.force.shape[1] == 0 or np.any(motion.signs < 0) or not np.all(motion.follows):
        return warnings
    if np.any(yielding > WRONG_WAY_SIGMA) and not np.any(yielding < -WRONG_WAY_SIGMA):
        _check_mirrored(arm, time, alpha, even, factors.unexplained)
    arm, of_gravity = other_gravity(neck, arm, motion)
    return (*warnings, *of_gravity, *check_forces(neck, arm, motion, yielding, _unexplained_shares(arm, motion)))


def _check_levers(arm: Arm) -> None:
    """Refused where a cable is as long whichever joint turns: what its motor does tells nothing of the arm, nor the arm of it."""
    turned = _TURNED_RAD * np.concatenate([-np.eye(arm.N), np.zeros((1, arm.N)), np.eye(arm.N)])
    still = np.flatnonzero(np.ptp(lengths(arm, turned), axis=0) < 2 * MIN_LEVER_M * _TURNED_RAD)
    if len(still):
        raise Refused(
            "neck.yaml",
            f"cables[{still[0]}] moves no joint: along its route it is as long in every pose",
            "does its route lack its end, right or left?",
        )


def _example_scales(neck: Neck) -> tuple[str, ...]:
    """A warning where torques become forces by gear and drum of the example of `xneck init`, which the motors have not."""
    example = MOTOR["R"] / MOTOR["rd"]
    stale = [
        j
        for j, m in enumerate(neck.motors)
        if np.isclose(abs(m.f_scale), example, rtol=1e-5) and not np.isclose(m.R / m.rd, example, rtol=1e-5)
    ]
    if not stale:
        return ()
    motor = neck.motors[stale[0]]
    return (
        f"f_scale of {counted(len(stale), 'motor')} is {example:.6g}, the R / rd of the example that `xneck init` writes, and "
        f"neck.yaml has R / rd = {motor.R / motor.rd:.6g}: if f is the motor's torque, write that",
    )


def _constant_forces(log: Series) -> tuple[str, ...]:
    """A warning where some logged force never changes; Refused where none does, or one is nothing, which holds no cable taut."""
    constant = constant_forces(log)
    if constant is None:
        return ()
    if constant.tell_nothing:
        raise Refused(
            "log",
            f"{constant.words}, which says nothing of how far a cable stretches",
            "log the commanded forces, or leave f1..M out: then the clock is good to milliseconds and nothing can be identified",
        )
    cables = "its cable stretches" if len(constant.motors) == 1 else "their cables stretch"
    return (f"{constant.words}: was it commanded so? How far {cables} is not told",)


def _check_degrees(arm: Arm, time: Array, alpha: Array, log: Series) -> None:
    """Refused where log and video show one motion once the angles are taken for degrees."""
    motion = logged_motion(arm, time, np.radians(alpha), log)
    if motion is None or not np.all(motion.follows):
        return
    if not len(_wrong_travel(motion, travel_factors(motion, arm.drum)[0])):
        raise Refused(
            "angles", "alpha is in degrees: only so do video and log show one motion", "multiply alpha1..N by 0.0174533"
        )


def _check_other_meanings(arm: Arm, time: Array, alpha: Array, log: Series, left: float) -> None:
    """Refused where angles and log show one motion only if the angles are not those from bar to bar, or from another zero.

    left: the share that is left unexplained where they are; infinite where they show no one motion."""
    others = [(_share_if(arm, time, other.alpha, log), other) for other in other_meanings(alpha)]
    least, best = min(others, key=lambda of: of[0], default=(np.inf, None))
    if best is not None and least < MAX_UNEXPLAINED_SHARE and OTHER_MEANING_RATIO * least < left:
        how = "only so they move" if np.isinf(left) else "so they move more nearly"
        raise Refused("sync", f"{best.words}: {how} as the log does", best.remedy)


def _check_frame_rate(arm: Arm, time: Array, alpha: Array, log: Series) -> None:
    """Refused where angles and log show one motion only if frames follow each other at another one of a camera's usual rates."""
    step = float(np.median(np.diff(time)))
    factors = {rate: 1 / (rate * step) for rate in USUAL_RATES_HZ if abs(1 / (rate * step) - 1) > MIN_RATE_ERROR}
    left, rate = min((_share_if(arm, by * time, alpha, log), rate) for rate, by in factors.items())
    if left < MAX_UNEXPLAINED_SHARE:
        rows, by = 1 / float(np.median(np.diff(log.time))), factors[rate]
        raise Refused(
            "sync",
            f"frames are {1 / step:.4g} a second by their times, and move as the log does only if they are {rate:g}",
            f"if the camera took {rate:g}, multiply their times by {by:.4g}; if the log's rows are {rows * by:.4g} a second and "
            f"not {rows:.4g}, multiply its times by {1 / by:.4g}",
        )


def _share_if(arm: Arm, time: Array, alpha: Array, log: Series) -> float:
    """What travel and force leave of cables' winding if angles and times are these; infinite for two motions."""
    motion = logged_motion(arm, time, alpha, log)
    return np.inf if motion is None else _unexplained_share(arm, motion)


def _unexplained_share(arm: Arm, motion: LoggedMotion) -> float:
    """What travel and force leave of a cable's winding, over the winding itself: of the worst cable."""
    return float(np.max(_unexplained_shares(arm, motion)))


def _unexplained_shares(arm: Arm, motion: LoggedMotion) -> Array:
    """The same of each cable, (M,)."""
    return unexplained_winding(motion, range(arm.M)) / np.std(motion.winding, axis=0)


def _check_mirrored(arm: Arm, time: Array, alpha: Array, log: Series, unexplained: float) -> None:
    """Refused where angles and motors are mirrored both: slow cables then seem to yield the wrong way, as with forces reversed.

    unexplained: m, RMS, that the recording leaves as it is."""
    turned = Series(log.time, {**log.columns, **numbered_columns("theta", -log.matrix("theta"))})
    motion = logged_motion(arm, time, -alpha, turned)
    if motion is None:
        return
    mirrored = travel_factors(motion, arm.drum)[0].unexplained
    if mirrored > MIRROR_RATIO * unexplained:
        return
    both = f"{1e3 * mirrored:.3f} mm are left unexplained instead of {1e3 * unexplained:.3f}"
    if mirrored < unexplained / MIRROR_RATIO:
        raise Refused(
            "sync",
            f"log and video fit better with all signs turned, of alpha and of theta: {both}",
            "check theta_sign of every motor, and whether the picture is mirrored",
        )
    raise Refused(
        "sync",
        f"{WRONG_WAY}: either all f have the wrong sign, or all theta and alpha ({both})",
        "check f_scale and theta_sign of every motor, and whether the picture is mirrored",
    )


def _check_stuck(arm: Arm, time: Array, alpha: Array, log: Series, motion: LoggedMotion) -> None:
    """Refused where an encoder holds still while the video shows its cable move."""
    at = time + motion.shift
    winding = cable_winding(arm, alpha)
    for j, theta in enumerate(log.matrix("theta").T):
        way = max(STUCK_SHARE * float(np.ptp(winding[:, j])), MIN_STUCK_M)
        still = np.diff(np.r_[False, np.diff(theta) == 0, False].astype(int))
        for begin, end in zip(np.flatnonzero(still > 0), np.flatnonzero(still < 0), strict=True):
            first, last = log.time[begin], log.time[end]
            inside = (at >= first) & (at <= last)
            if last - first < MIN_STUCK_S or not inside.any():
                continue
            if (moved := float(np.ptp(winding[inside, j]))) > way:
                raise Refused(
                    "log",
                    f"theta{j + 1} does not change from {first:.1f} s to {last:.1f} s, while the video shows cable {j + 1} move by "
                    f"{1e3 * moved:.0f} mm: its encoder is stuck",
                    "see to the encoder, and record again, or cut log and angles there",
                )


def _wrong_travel(motion: LoggedMotion, factors: Factors) -> NDArray[np.intp]:
    """The motors, counted from 0, that surely move their cables by another factor than one."""
    least = MIN_TRAVEL_FACTOR if motion.force.shape[1] else MIN_TRAVEL_FACTOR_WITHOUT_FORCE
    believed = motion.follows & (factors.value > 0) & (factors.sigma < MAX_RELATIVE_SIGMA * np.abs(factors.value))
    return np.flatnonzero(believed & ((factors.value < least) | (factors.value > MAX_TRAVEL_FACTOR)))


def _check_theta_units(neck: Neck, motion: LoggedMotion, factor: Array, wrong: NDArray[np.intp]) -> None:
    """Refused where the motors that move their cables by another factor than one all have their drums described twice as large, or
    their angles in one other unit."""
    tolerance = TRAVEL_TOLERANCE if motion.force.shape[1] else TRAVEL_TOLERANCE_WITHOUT_FORCE
    measured = np.array([factor[j] * neck.motors[j].theta_scale for j in wrong])
    if np.all(np.abs(np.log(2 * factor[wrong])) < SURE_TOLERANCE):
        drums = "the drum" if len(wrong) == 1 else "these drums"
        raise Refused(
            "log",
            f"{_travel_words(factor, wrong)}, as where motors[].rd is the diameter of {drums}",
            "write the radius into neck.yaml; if it is one, is R or theta_scale off by a factor of two?",
        )
    if units := unit_of_motors(measured, [theta_units(neck.motors[j]) for j in wrong], tolerance):
        named = unit_named("theta", wrong, units, measured, neck.M)
        written = to_write("theta_scale", wrong, [unit.scale for unit in units], neck.M)
        do = what_to_write(written, "theta_scale", units, measured)
        raise Refused("log", f"{named}: {_travel_words(factor, wrong)}", do)


def _travel_words(factor: Array, motors: NDArray[np.intp]) -> str:
    """How far motors would move their cables, against what the video shows."""
    cables = "its cable" if len(motors) == 1 else "their cables"
    return f"{column_names('theta', motors)} would move {cables} {times(1 / factor[motors])} as far as the video shows"
