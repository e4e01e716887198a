"""Friction in the joints of the arm itself."""

import numpy as np

from mechanism.arm import Array
from mechanism.laws.law import Law, Term, Values


class JointFriction(Law):
    """cj s / (1 + |s|^nj)^(1/nj) + dj alpha', N m, with s = alpha'/vj; vj, where the dry part changes sign, is one for all joints.

    nj says how soon the dry part is whole: 1 slowly, 2.7 much as tanh, 8 almost at once.
    """

    name = "joint_friction"
    terms = (
        Term("cj", "N m", 0.0, 1.0, 5e-3, "joint"),
        Term("dj", "N m s/rad", 0.0, 1.0, 5e-3, "joint"),
        Term("vj", "rad/s", 5e-3, 2.0, 0.05, "arm"),
        Term("nj", "1", 0.8, 8.0, 1.0, "arm"),
    )

    def resist(self, p: Values, alpha_d: Array) -> Array:
        s, n = alpha_d / p["vj"], p["nj"]
        return p["cj"] * s / (1 + np.abs(s) ** n) ** (1 / n) + p["dj"] * alpha_d
