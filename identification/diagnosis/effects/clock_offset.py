"""Clocks that are not aligned."""

from dataclasses import replace

import numpy as np

from identification.diagnosis.effect import Array, Effect, Shape
from identification.diagnosis.hypothesis import Hypothesis
from identification.diagnosis.point import Place
from mechanism.laws import Term


class ClockOffset(Effect):
    """Frames show what was done later than their stamps say."""

    name = "clock_offset"
    words = "camera and log are not on one clock"
    place = "camera"
    of_clock = True
    terms = (Term("late", "s", -0.1, 0.1, 1e-3, "arm"),)

    def columns(self, at: Place, shape: Shape) -> Array:
        size = self.terms[0].size
        return at.slow.change(turned=at.slow.late(size))[..., None] / size

    def added(self, h: Hypothesis, numbers: Array, shape: Shape) -> Hypothesis:
        return replace(h, late=h.late + float(np.sum(numbers)))
