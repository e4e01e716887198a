"""Cables that cannot push: what a linear cable says of one that is longer than its way is taken back."""

import numpy as np

from mechanism.arm import Array
from mechanism.laws.law import CableMotion, Law, Term, Values


class Slack(Law):
    """slack (0 or 1) times what the linear cable, its damper with it, falls below zero.

    A simulation lets no cable push, with or without this law.
    """

    name = "cable_slack"
    terms = (Term("slack", "1", low=0.0, high=1.5, size=1.0, would_tell="let the tension come near to nothing"),)

    def pull(self, p: Values, at: CableMotion, z: Array) -> Array:
        return p["slack"] * np.maximum(-(p["k"] * at.x + p["ca"] * at.x_d), 0.0)
