"""Pulleys that are not as described."""

import numpy as np

from diagnosis.check_fault import CheckFault
from diagnosis.effect import Array, DescriptionEffect
from diagnosis.shown_by import JOINT_ANGLE
from mechanism.description import Neck
from mechanism.laws import Term


class PulleyRadius(DescriptionEffect):
    """Pulleys that are not as described."""

    name = "pulley_radius"
    words = "the pulleys of a mechanism are not as described"
    place = "mechanism"
    part = "pulleys"
    shown_by = JOINT_ANGLE
    has_tolerance = True
    terms = (
        Term(
            "r",
            "m",
            low=-0.005,
            high=0.005,
            size=1e-4,
            of="joint",
            would_tell="measure the pulleys, and bend every joint as far as it goes",
        ),
    )
    truth_names = (("r", "off"),)
    check_fault = CheckFault(
        fix="measure the pulley, half the rope included, and correct r in neck.yaml",
        tolerance=8e-5,
        tolerance_with_baseline=2e-5,
    )
    order = 8

    def tolerances(self, neck: Neck) -> Array:
        return neck.tolerance.pulley * np.array([mechanism.r for mechanism in neck.mechanisms])

    def rewritten(self, neck: Neck, place: int, amount: float) -> Neck:
        mechanisms = list(neck.mechanisms)
        mechanism = mechanisms[place]
        mechanisms[place] = mechanism.model_copy(update={"r": mechanism.r + amount})
        return neck.model_copy(update={"mechanisms": tuple(mechanisms)})
