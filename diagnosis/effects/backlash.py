"""Play between motor and drum."""

from diagnosis.effect import LawEffect, law_terms
from diagnosis.shown_by import REVERSALS


class Backlash(LawEffect):
    """Play between motor and drum."""

    name = "backlash"
    words = "there is play between a motor and its drum"
    place = "motor"
    shown_by = REVERSALS
    law = "backlash"
    terms = law_terms("backlash", "play")
    shape_terms = law_terms("backlash", "pb")
    start_shapes = tuple({"pb": v} for v in (0.5, 1.0))
    order = 5
