"""Play between motor and drum."""

from diagnosis.effect import OfLaw, of_law


class Backlash(OfLaw):
    """Play between motor and drum."""

    name = "backlash"
    words = "there is play between a motor and its drum"
    place = "motor"
    law = "backlash"
    terms = of_law("backlash", "play")
    forms = of_law("backlash", "pb")
    shapes = tuple({"pb": v} for v in (0.5, 1.0))
