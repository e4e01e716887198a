"""A marker that does not sit as described."""

from dataclasses import replace

import numpy as np

from diagnosis.effect import Array, Effect, Shape, Where
from diagnosis.hypothesis import Hypothesis
from diagnosis.linearisation import RecordingLinearisation
from identification.residual_sensitivity import Turned
from mechanism.arm import Arm
from mechanism.laws import Term


class MarkerOffset(Effect):
    """A bar's orientation is read too large: the angle below it too large, the one above too small."""

    name = "marker_offset"
    words = "the markers of a bar are turned against how they are described, or an angle's zero is wrong"
    place = "bar"
    first = 0
    terms = (Term("turn", "rad", -0.5, 0.5, 0.01, "joint"),)

    def labels(self, arm: Arm) -> tuple[str, ...]:
        return tuple(f"bar {i}" for i in range(arm.N + 1))

    def wheres(self, arm: Arm) -> tuple[Where, ...]:
        # the base bar's marker and the other bars' together tell one thing twice
        own = tuple(Where(label, (i,)) for i, label in enumerate(self.labels(arm)))
        return (Where("all", tuple(range(1, arm.N + 1))), *own)

    def columns(self, at: RecordingLinearisation, shape: Shape) -> Array:
        size = self.terms[0].size
        read = size * _on_joints(at.signals.arm.N)
        return np.stack([at.slow.change(turned=Turned(-row)) for row in read], axis=-1) / size

    def added(self, h: Hypothesis, numbers: Array, shape: Shape) -> Hypothesis:
        return replace(h, misread=h.misread + numbers @ _on_joints(len(h.misread)))


def _on_joints(joints: int) -> Array:
    """What one radian of each bar, from the base's on, does to each angle, (N + 1, N)."""
    bars = np.eye(joints + 1)
    return bars[:, 1:] - bars[:, :-1]
