"""Clocks that are not aligned."""

from dataclasses import replace

import numpy as np

from diagnosis.check_fault import CheckFault
from diagnosis.effect import Array, Effect, Shape
from diagnosis.hypothesis import Hypothesis
from diagnosis.linearisation import RecordingLinearisation
from diagnosis.shown_by import CABLE_RATE
from identification.residuals import delayed_forces, residual_change
from mechanism.laws import Term
from mechanism.machine import Machine


class ClockOffset(Effect):
    """Frames show what was done later than their stamps say, or motor angles are older than the forces beside them."""

    name = "clock_offset"
    words = "camera, motor angles and forces are not on one clock"
    place = "camera"
    shown_by = CABLE_RATE
    is_clock = True
    terms = (
        Term(
            "late",
            "s",
            low=-0.1,
            high=0.1,
            size=1e-3,
            of="arm",
            would_tell="show the camera a light that the controller switches",
        ),
        Term(
            "stale",
            "s",
            low=-0.1,
            high=0.1,
            size=1e-3,
            of="arm",
            would_tell="show the camera a light that the controller switches",
        ),
    )
    check_fault = CheckFault(
        fix="synchronise again, if need be with a light that the controller switches",
        tolerance=5e-4,
        tolerance_with_baseline=5e-4,
    )
    order = 19

    def columns(self, recording: RecordingLinearisation, shape: Shape) -> Array:
        late, stale = (term.size for term in self.terms)
        frames = (
            recording.sensitivity.residual_change(angle_error=recording.sensitivity.error_of_lag(late))[..., None]
            / late
        )
        s, machine = recording.motor_signals, Machine(recording.signals.arm, recording.laws, recording.values)
        acting = machine.acting_force(delayed_forces(s, recording.delay + stale), s.step)
        later = replace(recording.motor_forces, acting=acting)
        motors = residual_change(s, recording.motor_forces, later, self.terms[1]) / stale
        return np.concatenate([frames, motors], axis=2)

    def added_to(self, h: Hypothesis, amounts: Array, shape: Shape) -> Hypothesis:
        return replace(
            h, frame_lag=h.frame_lag + float(amounts[0]), motor_angle_lag=h.motor_angle_lag + float(amounts[1])
        )
