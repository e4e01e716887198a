"""A base that is not level."""

import numpy as np

from diagnosis.effect import Array, DescriptionEffect
from diagnosis.shown_by import LEAN
from mechanism.description import Neck
from mechanism.laws import Term
from mechanism.toleranced_numbers import tilted


class BaseTilt(DescriptionEffect):
    """The base leans counter-clockwise: gravity leans the other way in its frame."""

    name = "base_tilt"
    words = "the base is not level"
    place = "base"
    shown_by = LEAN
    has_tolerance = True
    terms = (
        Term(
            "tilt",
            "rad",
            low=-0.5,
            high=0.5,
            size=0.01,
            of="arm",
            would_tell="put a spirit level on the base, or turn the base by a known angle and record again",
        ),
    )
    order = 6

    def tolerances(self, neck: Neck) -> Array:
        return np.full(1, neck.tolerance.tilt)

    def rewritten(self, neck: Neck, place: int, amount: float) -> Neck:
        return tilted(neck, amount)
