"""A motor that pulls without being told."""

from diagnosis.effect import OfLaw, of_law


class ActuatorOffset(OfLaw):
    """A motor that pulls without being told."""

    name = "actuator_offset"
    words = "a motor pulls by a constant force more or less than it is told"
    place = "motor"
    law = "actuator_offset"
    terms = of_law("actuator_offset", "fo")
