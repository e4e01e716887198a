"""Whether logged forces are those on the cables in N, by what the described arm needs to move as it does.

Friction on pulleys and loads that nobody described make the needed force smaller than the logged one. Nothing but wrong numbers
makes it larger by more than a drawing's tolerances, so that a smaller factor above one is doubted than below.
"""

import numpy as np
from numpy.typing import NDArray

from mechanism.arm import Arm
from mechanism.description import Motor, Neck
from synchronisation.log_regression import MAX_RELATIVE_SIGMA, LoggedMotion, force_factors
from synchronisation.log_units import Unit, force_units, unit_of_motors
from synchronisation.unit_words import column_names, comes_to, is_sure, times, to_write, unit_named, what_to_write
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

MIN_FORCE_FACTOR, MAX_FORCE_FACTOR = 0.1, 4.0
"""ratio of the force that the described arm needs to the logged one, beyond which f is refused (docs/thresholds.md)"""
MIN_LIKELY_FACTOR, MAX_LIKELY_FACTOR = 0.65, 1.2
"""the same ratio, of all motors, beyond which a warning says so; f is refused where all are in another unit (docs/thresholds.md)"""
MIN_FACTOR_ALONE, MAX_FACTOR_ALONE = 0.5, 2.0
"""the same ratio of one motor, beyond which it may be refused alone (docs/thresholds.md)"""
MAX_FORCE_RATIO = 3.0
"""ratio of one motor's force factor to that of the others, or its inverse, beyond which that f is refused (docs/thresholds.md)"""
FORCE_TOLERANCE = 0.35
"""log of the ratio between a measured factor and a unit's, within which the unit may be it: friction and a load that nobody
described make a factor smaller by as much (docs/thresholds.md)"""
MAX_UNEXPLAINED_SHARE = 0.25
"""of a cable's winding: what travel and force leave at most of one that runs as described, or where angles or times are read
otherwise than they are said to be (docs/thresholds.md)"""
MIN_EXPLAINED = 0.6
"""share of the variance that the forces must explain of what the arm needs, before a factor is believed (docs/thresholds.md)"""
WRONG_WAY_SIGMA = 5.0
"""standard deviations by which a cable must yield the wrong way, before its force's sign is wrong (docs/thresholds.md)"""

WRONG_WAY = "cables would be the shorter the more they are pulled"


def check_forces(neck: Neck, arm: Arm, motion: LoggedMotion, yielding: Array, unexplained: Array) -> tuple[str, ...]:
    """Warnings; Refused where forces have the wrong sign, or are in another unit, or a cable does not run as described.

    yielding: (M,), by how many sigmas each cable is the shorter the more it is pulled; unexplained: (M,), the share of its winding
    that travel and force leave."""
    factors = force_factors(arm, motion)
    factor, size = factors.value, np.abs(factors.value)
    reliable = factors.explained > MIN_EXPLAINED and bool(np.all(factors.sigma < MAX_RELATIVE_SIGMA * size))
    wrong_sign = (yielding > WRONG_WAY_SIGMA) | (reliable & (factor < 0))
    warnings = _check_units(neck, size, wrong_sign) if reliable else ()
    led_otherwise = wrong_sign & (unexplained > MAX_UNEXPLAINED_SHARE)
    if led_otherwise.any():
        j = int(np.argmax(led_otherwise))
        raise Refused(
            "log",
            f"theta{j + 1} and f{j + 1} leave {100 * unexplained[j]:.0f} % of cable {j + 1}'s way unexplained, and it seems pushed",
            f"is cables[{j}].route in neck.yaml as the cable runs, and are theta{j + 1} and f{j + 1} of its motor?",
        )
    if wrong_sign.any():
        wrong = np.flatnonzero(wrong_sign)
        what = f"{column_names('f', wrong)} {'has' if len(wrong) == 1 else 'have'} the wrong sign: {WRONG_WAY}"
        raise Refused("log", what, to_write("f_scale", wrong, [-neck.motors[j].f_scale for j in wrong], neck.M))
    return warnings


def _check_units(neck: Neck, factor: Array, wrong_sign: NDArray[np.bool_]) -> tuple[str, ...]:
    """A warning; Refused where forces are in another unit. factor: (M,), size of what the arm needs over what is logged."""
    beyond = _surely_beyond(factor)
    common = float(np.median(factor))
    if not len(beyond) and MIN_LIKELY_FACTOR <= common <= MAX_LIKELY_FACTOR:
        return ()
    motors = beyond if len(beyond) else np.arange(len(factor))
    scales = np.array([neck.motors[j].f_scale for j in motors])
    measured = factor[motors] * np.abs(scales)
    units = unit_of_motors(measured, [_other_units(neck.motors[j]) for j in motors], FORCE_TOLERANCE)
    is_other = bool(units) and is_sure(units, measured) and common > MAX_LIKELY_FACTOR
    named = unit_named("f", motors, units, measured, neck.M) if units else ""
    do = f"say in neck.yaml what its unit is in N on the cable: motors[].f_scale, which {comes_to(measured)}"
    if units:
        signs = np.sign(scales) * np.where(wrong_sign[motors], -1, 1)
        signed = [float(sign * unit.scale) for sign, unit in zip(signs, units, strict=True)]
        do = what_to_write(to_write("f_scale", motors, signed, neck.M), "f_scale", units, measured)
    if len(beyond) or is_other:
        what = f"the arm needs {times(factor[motors])} the force of {column_names('f', motors)} to move as it does"
        if np.any(wrong_sign[motors]):
            what += f", and {column_names('f', motors[wrong_sign[motors]])} the other way round"
        raise Refused("log", f"{named}: {what}" if named else what, do)
    needs = f"the arm as described needs {times(factor)} the logged forces to move as it does"
    if not named:
        return (f"{needs}: is f in N on the cable, and are masses and springs in neck.yaml right?",)
    return (f"{needs}: {named}, or masses and springs in neck.yaml are not right; {do}",)


def _surely_beyond(factor: Array) -> NDArray[np.intp]:
    """The motors, counted from 0, whose force is no force in N; those that are doubtful are so with them."""
    doubtful = (factor < MIN_FACTOR_ALONE) | (factor > MAX_FACTOR_ALONE)
    to_others = factor / np.median(factor)
    alone = np.maximum(to_others, 1 / to_others) > MAX_FORCE_RATIO
    beyond = (factor < MIN_FORCE_FACTOR) | (factor > MAX_FORCE_FACTOR)
    return np.flatnonzero(beyond | (doubtful & (alone | beyond.any())))


def _other_units(motor: Motor) -> list[Unit]:
    """Units of a motor's force but the one that neck.yaml says it has."""
    return [unit for unit in force_units(motor) if not np.isclose(unit.scale, abs(motor.f_scale), rtol=1e-3)]
