"""Springs that are not as described."""

from diagnosis.effect import OfArm
from mechanism.description import Neck
from mechanism.laws import Term


class SpringStiffness(OfArm):
    """Springs that are not as described."""

    name = "spring_stiffness"
    words = "the springs of a mechanism are not as described"
    place = "mechanism"
    terms = (Term("ks", "1", -0.9, 2.0, 0.02, "joint"),)

    def rewritten(self, neck: Neck, place: int, amount: float) -> Neck:
        mechanisms = list(neck.mechanisms)
        one = mechanisms[place]
        mechanisms[place] = one.model_copy(
            update={"springs": one.springs.model_copy(update={"stiffness": one.springs.stiffness * (1 + amount)})}
        )
        return neck.model_copy(update={"mechanisms": tuple(mechanisms)})
