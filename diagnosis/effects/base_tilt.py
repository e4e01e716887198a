"""A base that is not level."""

import numpy as np

from diagnosis.effect import OfArm
from mechanism.description import Neck
from mechanism.laws import Term


class BaseTilt(OfArm):
    """The base leans counter-clockwise: gravity leans the other way in its frame."""

    name = "base_tilt"
    words = "the base is not level"
    place = "base"
    terms = (Term("tilt", "rad", -0.5, 0.5, 0.01, "arm"),)

    def rewritten(self, neck: Neck, place: int, amount: float) -> Neck:
        g = complex(*neck.gravity) * np.exp(-1j * amount)
        return neck.model_copy(update={"gravity": (float(g.real), float(g.imag))})
