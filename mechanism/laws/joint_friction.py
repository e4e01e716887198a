"""Friction in the joints of the arm itself."""

import numpy as np

from mechanism.arm import Array
from mechanism.friction import share_at_rest, turned_over
from mechanism.laws.law import JointMotion, Law, Term, Values

_WOULD_TELL = "swing the joints fast, with cables of little friction"


class JointFriction(Law):
    """cj s / (1 + |s|^nj)^(1/nj) + dj alpha', N m, with s = alpha'/vj; vj, where the dry part changes sign, is one for all joints.

    nj says how soon the dry part is whole: 1 slowly, 2.7 much as tanh, 8 almost at once.
    """

    name = "joint_friction"
    terms = (
        Term("cj", "N m", low=0.0, high=10.0, size=5e-3, of="joint", would_tell=_WOULD_TELL),
        Term("dj", "N m s/rad", low=0.0, high=10.0, size=5e-3, of="joint", would_tell=_WOULD_TELL),
        Term("vj", "rad/s", low=5e-3, high=2.0, size=0.05, of="arm", would_tell=_WOULD_TELL),
        Term("nj", "1", low=0.8, high=8.0, size=1.0, of="arm", would_tell=_WOULD_TELL),
    )

    def resistance(self, p: Values, at: JointMotion) -> Array:
        return p["cj"] * turned_over(at.alpha_d / p["vj"], p["nj"]) + p["dj"] * at.alpha_d

    def held_torque(self, p: Values, at: JointMotion) -> Array:
        return np.maximum(p["cj"], 0.0) * share_at_rest(at.alpha_d / p["vj"])
