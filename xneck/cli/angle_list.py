"""Joint angles as an option of the command line gives them: numbers with commas between them."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from xneck_foundation.errors import Refused
from xneck_foundation.one_line import counted
from xneck_foundation.spelling import quoted

_EXAMPLES = {"deg": "20,-10,5", "rad": "0.3,-0.2,0.1"}


def angle_list(option: str, text: str, joints: int, unit: Literal["deg", "rad"]) -> NDArray[np.float64]:
    """Joint angles (N,), rad, from the base up; one number stands for all joints.

    option: its name, such as `--alpha`. Raises Refused unless they are numbers in the unit, one for each joint or one for all,
    and short of the mechanisms' singular pose at 180 deg.
    """
    numbers = f"write numbers in {unit} such as {_EXAMPLES[unit]}"
    try:
        given = np.array([float(word) for word in text.split(",")])
    except ValueError:
        raise Refused(option, f"{quoted(text)} is no list of numbers", numbers) from None
    if len(given) not in (1, joints):
        what = f"{counted(len(given), 'angle')} for {counted(joints, 'joint')}"
        raise Refused(option, what, "give one for each joint, or one for all")
    alpha = np.radians(given) if unit == "deg" else given
    if not np.all(np.abs(alpha) < np.pi):
        worst = given[int(np.argmin(np.abs(alpha) < np.pi))]
        raise Refused(option, f"{worst:g} {unit} is not within +-180 deg, where a mechanism is singular", numbers)
    return np.resize(alpha, joints)
