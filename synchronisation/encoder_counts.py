"""What a log's motor angles say of the counts that neck.yaml has."""

import numpy as np

from identification.dataset.encoder_steps import SAME_STEP, count_angles
from identification.dataset.series import Series
from mechanism.description import Neck
from xneck_foundation.one_line import counted


def counts_warnings(neck: Neck, log: Series) -> tuple[str, ...]:
    """A warning where motors move in other steps than neck.yaml's counts; the log's are taken. log: in our units."""
    described, steps = neck.count_angles, count_angles(neck, log)
    other = np.flatnonzero(np.abs(steps - described) > SAME_STEP * described)
    if not len(other):
        return ()
    j = int(other[0])
    per_turn = 2 * np.pi / steps[j]
    begin = f"theta{j + 1} moves in steps of {steps[j]:.4g} rad" + (
        f" (as {counted(len(other), 'motor')} do)" if len(other) > 1 else ""
    )
    if abs(per_turn - round(per_turn)) < SAME_STEP:
        which = f"{round(per_turn)} to a turn, where neck.yaml has counts: {neck.motors[j].counts}"
        do = f"write counts: {round(per_turn)} there"
    else:
        which = f"{steps[j] / described[j]:.3g} counts of neck.yaml"
        do = "does the log round its angles, or is theta_scale or counts off?"
    return (f"{begin}, {which}; its noise is taken to be of these: {do}",)
