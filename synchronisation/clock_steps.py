"""Steps of the clock that stamped a log, as where it was set while the experiment ran: stamps leap, and the motors do not.

Between the rows on either side of a leap the motors moved as from any row there to the next. Where rows are missing they moved on
for as long as the stamps say.
"""

import numpy as np

from mechanism.arm import Array

MIN_STEP_ROWS = 0.5
"""rows by which stamps must leap (docs/thresholds.md)"""
MIN_STEP_SIGMAS = 8.0
"""standard deviations of the stamps' steps, by which they must leap too (docs/thresholds.md)"""
MIN_SPEED_COUNTS = 5.0
"""counts that the motors move in a row, all together: slower ones do not tell how long they moved (docs/thresholds.md)"""
MAX_OFF = 0.3
"""of a row's motion: by how much that across a leap may differ from it (docs/thresholds.md)"""
_NORMAL = 1.4826
"""standard deviation over median distance of normal numbers"""
_BESIDE = 5
"""rows on each side whose stamps must follow as usual, so that one late stamp is no leap"""
_MAX_BESIDE = 1 / 3
"""of a leap: by how much their steps may be unlike a row's"""


def clock_steps(time: Array, theta: Array) -> Array:
    """By how much the stamps from each row on lead those before it, (T,), s: zero but at a leap of the clock.

    time: (T,), s; theta: (T, M), in any unit.
    """
    steps = np.zeros(len(time))
    if len(time) < 2 * _BESIDE + 2:
        return steps
    between, moved = np.diff(time), np.diff(theta, axis=0)
    row = float(np.median(between))
    sizes = np.abs(moved)
    count = np.array([np.min(s[s > 0], initial=np.inf) for s in sizes.T])
    unsteady = _NORMAL * float(np.median(np.abs(between - row)))
    for i in np.flatnonzero(between - row > max(MIN_STEP_ROWS * row, MIN_STEP_SIGMAS * unsteady)):
        beside = np.append(between[max(i - _BESIDE, 0) : i], between[i + 1 : i + 1 + _BESIDE])
        if len(beside) < 2 * _BESIDE or np.abs(beside - row).max() > _MAX_BESIDE * (between[i] - row):
            continue
        usual = (moved[i - 1] + moved[i + 1]) / 2
        if np.linalg.norm(usual / count) < MIN_SPEED_COUNTS:
            continue
        if np.linalg.norm((moved[i] - usual) / count) < MAX_OFF * np.linalg.norm(usual / count):
            steps[i + 1] = between[i] - row
    return steps
