"""Friction in the joints of the arm itself."""

import numpy as np

from mechanism.arm import Array
from mechanism.laws.law import Law, Term, Values


class JointFriction(Law):
    """cj tanh(alpha'/vj) + dj alpha', N m; vj, where the dry part changes sign, is one for all joints."""

    name = "joint_friction"
    terms = (
        Term("cj", "N m", 0.0, 1.0, 5e-3, "joint"),
        Term("dj", "N m s/rad", 0.0, 1.0, 5e-3, "joint"),
        Term("vj", "rad/s", 5e-3, 2.0, 0.05, "arm"),
    )

    def resist(self, p: Values, alpha_d: Array) -> Array:
        return p["cj"] * np.tanh(alpha_d / p["vj"]) + p["dj"] * alpha_d
