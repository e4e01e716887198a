"""Friction of the arm itself."""

from diagnosis.effect import LawEffect, law_terms
from diagnosis.shown_by import JOINT_SPEED


class JointFriction(LawEffect):
    """Friction of the arm itself."""

    name = "joint_friction"
    words = "the joints rub"
    place = "mechanism"
    part = "joint"
    shown_by = JOINT_SPEED
    law = "joint_friction"
    terms = law_terms("joint_friction", "cj", "dj")
    shape_terms = law_terms("joint_friction", "vj", "nj")
    start_shapes = tuple({"vj": v, "nj": 2.0} for v in (0.02, 0.1))
    may_sit_alone = False
    order = 11
