"""A motor that pulls in another proportion."""

from diagnosis.effect import OfLaw, of_law


class ActuatorGain(OfLaw):
    """A motor that pulls in another proportion."""

    name = "actuator_gain"
    words = "a motor pulls more or less than it is told, in proportion"
    place = "motor"
    law = "actuator_gain"
    terms = of_law("actuator_gain", "g")
