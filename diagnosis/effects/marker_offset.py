"""A marker that does not sit as described."""

from dataclasses import replace

import numpy as np

from diagnosis.angle_zeros import angle_errors_of_bars
from diagnosis.check_fault import CheckFault
from diagnosis.effect import Array, Effect, Placement, Shape
from diagnosis.hypothesis import Hypothesis
from diagnosis.linearisation import RecordingLinearisation
from diagnosis.shown_by import JOINT_ANGLE
from identification.residual_sensitivity import AngleError
from mechanism.arm import Arm
from mechanism.description import Neck
from mechanism.laws import Term


class MarkerOffset(Effect):
    """A bar's orientation is read too large: the angle below it too large, the one above too small."""

    name = "marker_offset"
    words = "the markers of a bar are turned against how they are described, or an angle's zero is wrong"
    place = "bar"
    shown_by = JOINT_ANGLE
    has_tolerance = True
    first_index = 0
    terms = (
        Term(
            "turn",
            "rad",
            low=-0.5,
            high=0.5,
            size=0.01,
            of="joint",
            would_tell="hold each joint at a known angle and compare, or put the markers on anew",
        ),
    )
    truth_names = (("turn", "offset"),)
    check_fault = CheckFault(
        fix="set right the angle of the marker in neck.yaml (markers.on_bars), or extract with --placement",
        tolerance=float(np.radians(0.3)),
        tolerance_with_baseline=float(np.radians(0.03)),
    )
    order = 10

    def place_labels(self, arm: Arm) -> tuple[str, ...]:
        return tuple(f"bar {i}" for i in range(arm.N + 1))

    def placements(self, arm: Arm) -> tuple[Placement, ...]:
        # the base bar's marker and the other bars' together tell one thing twice
        single = (self.alone_at(bar, arm) for bar in range(arm.N + 1))
        return (Placement("all", tuple(range(1, arm.N + 1))), *single)

    def tolerances(self, neck: Neck) -> Array:
        return np.full(neck.N + 1, neck.tolerance.marker_angle)

    def columns(self, recording: RecordingLinearisation, shape: Shape) -> Array:
        size = self.terms[0].size
        errors = size * angle_errors_of_bars(recording.signals.arm.N)
        sensitivity = recording.sensitivity
        return (
            np.stack([sensitivity.residual_change(angle_error=AngleError(-error)) for error in errors], axis=-1) / size
        )

    def added_to(self, h: Hypothesis, amounts: Array, shape: Shape) -> Hypothesis:
        return replace(h, angle_error=h.angle_error + amounts @ angle_errors_of_bars(len(h.angle_error)))
