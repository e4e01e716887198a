"""Friction of cables on their pulleys, by Euler and Eytelwein."""

import numpy as np

from mechanism.arm import Array
from mechanism.friction import share_at_rest, turned_over
from mechanism.laws.law import Law, MotorMotion, Sliding, Term, Values

SLIDING_M_S = 1e-3
"""m/s: speed about which friction on a pulley along the arm usually turns over"""
_ABRUPT = 2.7
"""power of its turning over, much as tanh does"""
_SIGMA_MOVED = 0.5
"""share of the angle of wrap that may slide otherwise than by taut strings (docs/thresholds.md)"""
_WOULD_TELL = "vary the tension while the motors turn"


class PulleyFriction(Law):
    """A cable that slides over pulleys by an angle pulls exp(mu angle) times as much where it is drawn to.

    The elastic part of a cable may be behind its pulleys or before them. Behind them, a motor that winds in pulls exp(mu wrap)
    times the cable's tension, one that gives way exp(-mu wrap) times. Before them the motor feels the cable's tension, and at the
    span of each mechanism exp(-sum of ma angle) of it is left, by the direction in which the cable slides over each pulley on the
    way; over a sliding speed of vp it turns over. How much of the angle lies before a span and how much behind it may be another
    than by taut strings, by a share of wm.
    """

    name = "pulley_friction"
    rubs_under_tension = True
    terms = (
        Term("mu", "1/rad", low=0.0, high=0.3, size=0.005, would_tell=_WOULD_TELL),
        Term("ma", "1/rad", low=0.0, high=0.3, size=0.005, would_tell=_WOULD_TELL),
        Term("vp", "m/s", low=1e-4, high=0.02, size=1e-3, of="arm", would_tell=_WOULD_TELL),
        Term("wm", "1", low=-1.0, high=1.0, size=0.1, of="arm", sigma=_SIGMA_MOVED, would_tell=_WOULD_TELL),
    )

    def friction(self, p: Values, at: MotorMotion) -> Array:
        return np.expm1(p["mu"] * at.wrap * at.share(p["cm"])) * at.tension

    def loses(self, p: Values) -> bool:
        return bool(np.any(p["ma"]))

    def loss(self, p: Values, at: Sliding) -> Array:
        return p["ma"] * at.wrap(p["wm"]) * turned_over(at.speed / p["vp"], _ABRUPT)

    def held_loss(self, p: Values, at: Sliding) -> Array:
        return p["ma"] * at.wrap(p["wm"]) * share_at_rest(at.speed / p["vp"])
