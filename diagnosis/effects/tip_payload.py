"""A load at the tip."""

from diagnosis.effect import DescriptionEffect
from diagnosis.shown_by import LEAN
from mechanism.description import Neck
from mechanism.laws import Term


class TipPayload(DescriptionEffect):
    """A point mass in the middle of the last bar."""

    name = "tip_payload"
    words = "the arm carries something at its tip"
    place = "tip"
    shown_by = LEAN
    has_tolerance = True
    terms = (
        Term(
            "m",
            "kg",
            low=-0.05,
            high=2.0,
            size=0.02,
            of="arm",
            would_tell="weigh what sits at the tip, or record again with a known weight on it",
        ),
    )
    truth_names = (("m", "mass"),)
    order = 7

    def rewritten(self, neck: Neck, place: int, amount: float) -> Neck:
        last = neck.mechanisms[-1]
        top = last.top
        mass = top.mass + amount
        x, y = top.com
        around = (x**2 + y**2) * top.mass * amount / mass
        loaded = top.model_copy(
            update={
                "mass": mass,
                "com": (x * top.mass / mass, y * top.mass / mass),
                "inertia": max(top.inertia + around, 0.0),
            }
        )
        return neck.model_copy(update={"mechanisms": (*neck.mechanisms[:-1], last.model_copy(update={"top": loaded}))})
