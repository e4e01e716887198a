"""Clocks that are not aligned."""

from dataclasses import replace

import numpy as np

from diagnosis.effect import Array, Effect, Shape
from diagnosis.hypothesis import Hypothesis
from diagnosis.linearisation import RecordingLinearisation
from identification.residuals import forces, on_channels
from mechanism.laws import Term


class ClockOffset(Effect):
    """Frames show what was done later than their stamps say, or motor angles are older than the forces beside them."""

    name = "clock_offset"
    words = "camera, motor angles and forces are not on one clock"
    place = "camera"
    of_clock = True
    terms = (Term("late", "s", -0.1, 0.1, 1e-3, "arm"), Term("stale", "s", -0.1, 0.1, 1e-3, "arm"))

    def columns(self, at: RecordingLinearisation, shape: Shape) -> Array:
        late, stale = (term.size for term in self.terms)
        frames = at.slow.change(turned=at.slow.late(late))[..., None] / late
        acting = forces(at.told, at.laws, at.values, at.x0, at.delay + stale)
        return np.concatenate([frames, on_channels(at.told, at.told_forces, acting, self.terms[1]) / stale], axis=2)

    def added(self, h: Hypothesis, numbers: Array, shape: Shape) -> Hypothesis:
        return replace(h, late=h.late + float(numbers[0]), stale=h.stale + float(numbers[1]))
