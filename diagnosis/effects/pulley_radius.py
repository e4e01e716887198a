"""Pulleys that are not as described."""

from diagnosis.effect import OfArm
from mechanism.description import Neck
from mechanism.laws import Term


class PulleyRadius(OfArm):
    """Pulleys that are not as described."""

    name = "pulley_radius"
    words = "the pulleys of a mechanism are not as described"
    place = "mechanism"
    terms = (Term("r", "m", -0.005, 0.005, 1e-4, "joint"),)

    def rewritten(self, neck: Neck, place: int, amount: float) -> Neck:
        mechanisms = list(neck.mechanisms)
        one = mechanisms[place]
        mechanisms[place] = one.model_copy(update={"r": one.r + amount})
        return neck.model_copy(update={"mechanisms": tuple(mechanisms)})
