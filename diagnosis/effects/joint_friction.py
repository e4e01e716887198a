"""Friction of the arm itself."""

from diagnosis.effect import OfLaw, of_law


class JointFriction(OfLaw):
    """Friction of the arm itself."""

    name = "joint_friction"
    words = "the joints rub"
    place = "joint"
    law = "joint_friction"
    terms = of_law("joint_friction", "cj", "dj")
    forms = of_law("joint_friction", "vj", "nj")
    shapes = tuple({"vj": v, "nj": 2.0} for v in (0.02, 0.1))
    single = False
