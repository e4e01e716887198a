"""A drum, or its gear, that is not as described."""

from diagnosis.effect import OfArm
from mechanism.description import Neck
from mechanism.laws import Term


class DrumRadius(OfArm):
    """A drum, or its gear, that is not as described."""

    name = "drum_radius"
    words = "a drum (or its gear ratio) is not as described"
    place = "motor"
    terms = (Term("rd", "1", -0.3, 0.3, 5e-3),)

    def rewritten(self, neck: Neck, place: int, amount: float) -> Neck:
        motor = neck.motors[place]
        motors = list(neck.motors)
        motors[place] = motor.model_copy(update={"rd": motor.rd * (1 + amount)})
        return neck.model_copy(update={"motors": tuple(motors)})
