"""Motors that follow late."""

from diagnosis.effect import OfLaw, of_law


class ActuatorLag(OfLaw):
    """Motors that follow late."""

    name = "actuator_lag"
    words = "the motors follow their commands late"
    place = "motor"
    law = "actuator_lag"
    terms = of_law("actuator_lag", "taul")
    single = False
