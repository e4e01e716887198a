"""A drum, or its gear, that is not as described.

Where the log's forces are torques over the described drum, they are off by as much (diagnosis/force_scale.py)."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from diagnosis.check_fault import CheckFault
from diagnosis.effect import DescriptionEffect, Numbers, Shape
from diagnosis.force_scale import force_scale_columns
from diagnosis.hypothesis import Hypothesis
from diagnosis.linearisation import RecordingLinearisation
from diagnosis.shown_by import DRUM_TURNS
from mechanism.description import Neck
from mechanism.laws import Term
from mechanism.toleranced_numbers import scaled

Array = NDArray[np.float64]


class DrumRadius(DescriptionEffect):
    """A drum, or its gear, that is not as described."""

    name = "drum_radius"
    words = "a drum (or its gear ratio) is not as described"
    place = "motor"
    shown_by = DRUM_TURNS
    may_sit_everywhere = False
    has_tolerance = True
    terms = (
        Term(
            "rd", "1", low=-0.3, high=0.3, size=5e-3, would_tell="measure the drum, and wind every cable far in and out"
        ),
    )
    check_fault = CheckFault(
        fix="measure the drum, rope included, and correct rd (or the gear R, or counts) in neck.yaml",
        tolerance=3e-3,
        tolerance_with_baseline=5e-4,
    )
    order = 9

    def tolerances(self, neck: Neck) -> Array:
        return np.full(neck.M, neck.tolerance.drum)

    def rewritten(self, neck: Neck, place: int, amount: float) -> Neck:
        return scaled("motors", place, ("rd",))(neck, amount)

    def columns(self, recording: RecordingLinearisation, shape: Shape) -> Array:
        of_lengths = super().columns(recording, shape)
        return of_lengths - force_scale_columns(recording, 1.0) if recording.hypothesis.forces_as_drums else of_lengths

    def added_to(self, h: Hypothesis, amounts: Array, shape: Shape) -> Hypothesis:
        h = super().added_to(h, amounts, shape)
        if not h.forces_as_drums:
            return h
        # the drum is then a motor's gain as well
        gain = (1 + h.values.get("g", np.zeros(h.arm.M))) * (1 + amounts) - 1
        return h.with_law("actuator_gain", {"g": gain})

    def true_numbers(self, parameters: Mapping[str, float], truth: Mapping[str, Any], place: int | None) -> Numbers:
        """The truth is a factor."""
        return {("rd", place): parameters["factor"] - 1.0}
