"""Where the arm stands as the observer begins: at rest where its cables pull it to, unless its motors turn out to move it.

The next row tells how fast they turn. Joints that follow their motors are as fast as cables that keep their lengths make them, and
lag by the cables' damping: so angles and speeds of the joints are correlated with the speeds of the motors from the beginning.
"""

import numpy as np
from numpy.typing import NDArray

from observation.evaluated_equations import EvaluatedEquations

Array = NDArray[np.float64]

NEWTON_STEPS = 60
"""at most, from the told pose to the pose at rest"""
MAX_NEWTON_RAD = 0.1
"""rad, by which one of these steps moves a joint at most"""
AT_REST_RAD = 1e-10
"""rad: a smaller step is the last"""
RANGE_RAD = 2.8
"""rad, of a joint's angle, beyond which the mechanism has no pose"""


def start_at_rest(equations: EvaluatedEquations, state: Array, covariance: Array) -> tuple[Array, Array]:
    """The state (size,) with angles at which the joints' torques vanish, and the covariance (size, size) with theirs.

    Angles follow from motor angles, pre-elongations, what the cables remember, and speeds; `covariance` tells what they are off
    that. Newton's steps begin at the state's own angles, which stay where no rest is found within the range. Raises Refused where a
    mechanism has no pose.
    """
    layout = equations.layout
    n, alpha = layout.N, layout.alpha
    state = state.copy()
    told = state[alpha].copy()
    e = None
    for _ in range(NEWTON_STEPS):
        e = equations.at(state, np.zeros(layout.M), 0.0)
        stiffness = e.by_state[:n, alpha]
        change = -np.linalg.solve(stiffness, e.rates[:n]) if np.linalg.det(stiffness) else np.zeros(n)
        change *= min(1.0, MAX_NEWTON_RAD / max(float(np.max(np.abs(change))), 1e-300))
        state[alpha] += change
        if np.max(np.abs(change)) < AT_REST_RAD:
            break
    assert e is not None
    if not np.all(np.abs(state[alpha]) < RANGE_RAD):
        state[alpha] = told
    by_others = -np.linalg.solve(e.by_state[:n, alpha], e.by_state[:n])
    by_others[:, alpha] = 0.0
    speeds, angles = np.eye(layout.size), np.eye(layout.size)
    speeds[layout.alpha_d, layout.theta_d] = by_others[:, layout.theta]
    angles[alpha] += by_others
    follows = angles @ speeds
    return state, follows @ covariance @ follows.T
