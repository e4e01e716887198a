"""Cables that cannot push, and come taut little by little."""

import numpy as np

from mechanism.arm import Array
from mechanism.laws.law import CableMotion, Law, Term, Values

_WOULD_TELL = "let the tension come near to nothing"


class Slack(Law):
    """slack (0 or 1) times what makes w log(1 + exp(t/w)), w = k xs, of the linear cable's tension t, its damper with it.

    Far below zero that is nothing, far above the linear cable's; within xs of elongation it turns over. A simulation lets no cable
    push, with or without this law.
    """

    name = "cable_slack"
    terms = (
        Term("slack", "1", low=0.0, high=1.5, size=1.0, would_tell=_WOULD_TELL),
        Term("xs", "m", low=1e-6, high=1e-3, size=2e-4, would_tell=_WOULD_TELL),
    )

    def pull(self, p: Values, at: CableMotion, z: Array) -> Array:
        t, w = p["k"] * at.x + p["ca"] * at.x_d, p["k"] * p["xs"]
        return p["slack"] * (np.maximum(-t, 0.0) + w * np.log(1 + np.exp(-np.abs(t) / w)))
