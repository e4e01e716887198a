"""Friction in the joints of the arm itself."""

import numpy as np

from mechanism.arm import Array
from mechanism.laws.law import Law, Term, Values

SLOWLY = 0.05
"""rad/s: where a joint's dry friction changes sign"""


class JointFriction(Law):
    """cj tanh(alpha'/0.05) + dj alpha', N m."""

    name = "joint_friction"
    terms = (Term("cj", "N m", 0.0, 1.0, 5e-3, "joint"), Term("dj", "N m s/rad", 0.0, 1.0, 5e-3, "joint"))

    def resist(self, p: Values, alpha_d: Array) -> Array:
        return p["cj"] * np.tanh(alpha_d / SLOWLY) + p["dj"] * alpha_d
