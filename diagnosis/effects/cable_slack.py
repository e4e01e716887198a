"""A cable that goes slack."""

from diagnosis.effect import OfLaw, of_law


class CableSlack(OfLaw):
    """A cable that goes slack."""

    name = "cable_slack"
    words = "a cable goes slack at times"
    place = "cable"
    law = "cable_slack"
    terms = of_law("cable_slack", "slack")
    by_vision = True
