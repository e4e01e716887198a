"""The check of a data set as its file holds it, made by `sync` or by hand."""

from dataclasses import replace

import numpy as np

from identification.dataset.dataset import DataSet
from identification.dataset.frames import FrameAngles, frame_angles
from identification.dataset.series import Series
from mechanism.arm import Arm
from state_estimation.motors import motors_in
from synchronisation.check.check import Baseline, Check, baseline_of, check_elongations, not_healthy
from synchronisation.check.faults import EXCHANGES
from synchronisation.check.residual_clock import find_clock_fault, shifted_frames
from synchronisation.clocks.late_forces import with_acting_forces
from synchronisation.clocks.usable_frames import GAP_MARGIN_S
from xneck_foundation.errors import Refused
from xneck_foundation.one_blas_thread import one_blas_thread
from xneck_foundation.one_line import counted

MAX_MEASURED_ANEW = 0.1
"""share of a length by which two descriptions of one arm may differ: one was measured anew since (docs/thresholds.md)"""
ANOTHER_BASELINE = "give a healthy recording of the arm that is checked"


@one_blas_thread
def check_dataset(data: DataSet, baseline: DataSet | None = None, where: str = "baseline") -> Check:
    """Checks a data set, by itself or against a `baseline`: a data set of the same arm that is known to be healthy.

    Both are computed with the checked data set's neck.yaml. Where the clocks of frames and log differ, that is the first fault, and
    the others are those that remain once it is put right. Raises Refused where a data set holds no forces, without which nothing
    says how far the cables stretch, and where the baseline is of another arm or not healthy; `where` names it then.

    >>> import xneck
    >>> result = xneck.check(xneck.read_dataset("monday.mcap"))
    >>> result.verdict, result.faults
    ('consistent', ())
    """
    for given, name in ((data, "check"), (baseline, where)):
        if given is not None and "f1" not in given.state.columns:
            raise Refused(name, "the data set holds no forces f", "log the force command of every motor")
    arm = data.arm
    fv = np.array([np.nan if motor.fv is None else motor.fv for motor in data.neck.motors])
    healthy: Baseline | None = None
    if baseline is not None:
        _check_same_arm(arm, baseline.arm, where)
        frames = _logged_frames(baseline)
        state = _acting_state(baseline)
        healthy = baseline_of(arm, state, frames, _clock_sigma(baseline), where, data.neck.tolerance)
        clock_fault = find_clock_fault(arm, frames, motors_in(state), fv)
        if clock_fault is not None:
            raise not_healthy(where, clock_fault)
    frames, state = _logged_frames(data), _acting_state(data)
    check = check_elongations(arm, state, frames, _clock_sigma(data), healthy, data.neck.tolerance)
    if check.faults and check.faults[0]["fault"] in EXCHANGES:
        return check
    clock_fault = find_clock_fault(arm, frames, motors_in(state), fv)
    if clock_fault is None:
        return check
    shifted = shifted_frames(frames, clock_fault)
    remaining = check_elongations(arm, state, shifted, clock_fault["sigma"], healthy, data.neck.tolerance)
    return replace(remaining, faults=(clock_fault, *remaining.faults))


def _check_same_arm(arm: Arm, other: Arm, where: str) -> None:
    """Refused where two arms have not the same parts, or a length that no measuring would mend so far."""
    if (arm.N, arm.M) != (other.N, other.M):
        parts = [f"{counted(one.N, 'joint')} and {counted(one.M, 'cable')}" for one in (other, arm)]
        raise Refused(where, f"is of another arm: of {parts[0]}, not of {parts[1]}", ANOTHER_BASELINE)
    for field, words in (("L", "L"), ("b", "b"), ("r", "r"), ("drum", "rd / R")):
        here, there = getattr(arm, field), getattr(other, field)
        worst = int(np.argmax(np.abs(there / here - 1)))
        if abs(there[worst] / here[worst] - 1) > MAX_MEASURED_ANEW:
            sizes = f"{words} {worst + 1} is {there[worst]:.4g} m, not {here[worst]:.4g} m"
            raise Refused(where, f"is of another arm: in its neck.yaml {sizes}", ANOTHER_BASELINE)


def _logged_frames(data: DataSet) -> FrameAngles:
    """The frames of a data set that are clear of the gaps of its log."""
    return frame_angles(data).clear_of(data.clock.get("log_gaps", ()), GAP_MARGIN_S)


def _acting_state(data: DataSet) -> Series:
    """The state with forces where they act, as far as the clock's record tells."""
    return with_acting_forces(data.state, float(data.clock.get("force_delay_s") or 0.0))


def _clock_sigma(data: DataSet) -> float:
    return float(data.clock.get("offset_sigma_s") or 0.0)
