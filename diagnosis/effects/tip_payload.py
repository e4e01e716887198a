"""A load at the tip."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.effect import Effect, Shape
from diagnosis.hypothesis import Hypothesis
from diagnosis.linearisation import RecordingLinearisation
from diagnosis.shown_by import LEAN
from mechanism.arm import arm_of
from mechanism.description import Neck
from mechanism.laws import Term

Array = NDArray[np.float64]

_WOULD_TELL = "weigh what sits at the tip, or record again with a known weight on it"
_MAX_OFFSET_M, _OFFSET_SIGMA_M = 0.1, 0.02
"""m: how far off the middle of the last bar a load may be, and is by one sigma (docs/thresholds.md)"""


class TipPayload(Effect):
    """A point mass on the last bar, near its middle."""

    name = "tip_payload"
    words = "the arm carries something at its tip"
    place = "tip"
    shown_by = LEAN
    has_tolerance = True
    terms = (Term("m", "kg", low=-0.05, high=2.0, size=0.02, of="arm", would_tell=_WOULD_TELL),)
    shape_terms = tuple(
        Term(
            name,
            "m",
            low=-_MAX_OFFSET_M,
            high=_MAX_OFFSET_M,
            size=0.01,
            of="arm",
            sigma=_OFFSET_SIGMA_M,
            would_tell="measure where on the last bar it sits",
        )
        for name in ("xm", "ym")
    )
    start_shapes = ({"xm": 0.0, "ym": 0.0},)
    truth_names = (("m", "mass"),)
    order = 7

    def columns(self, recording: RecordingLinearisation, shape: Shape) -> Array:
        (size,) = self.sizes(recording.signals.arm)
        loaded = with_load(recording.hypothesis.neck, size, *_place(shape))
        return recording.sensitivity.residual_change(arm=arm_of(loaded))[..., None] / size

    def shape_columns(self, recording: RecordingLinearisation, amounts: Array, shape: Shape) -> Array:
        (mass,), place = amounts, np.array(_place(shape))
        unloaded = with_load(recording.hypothesis.neck, -mass, *place)
        changes = [
            recording.sensitivity.residual_change(arm=arm_of(with_load(unloaded, mass, *(place + step)))) / step.sum()
            for step in np.diag([term.size for term in self.shape_terms])
        ]
        return np.stack(changes, axis=-1)

    def added_to(self, h: Hypothesis, amounts: Array, shape: Shape) -> Hypothesis:
        return replace(h, neck=with_load(h.neck, float(amounts[0]), *_place(shape)))


def _place(shape: Shape) -> tuple[float, float]:
    """Where a load sits from the middle of the last bar, m: along it to the right, and up."""
    x, y = (float(np.squeeze(shape[name])) for name in ("xm", "ym"))
    return x, y


def with_load(neck: Neck, mass: float, x: float, y: float) -> Neck:
    """neck.yaml with a point mass (kg) more, m from the middle of the last bar; a negative one is taken off."""
    last = neck.mechanisms[-1]
    top = last.top
    whole, (x0, y0) = top.mass + mass, top.com
    around = ((x - x0) ** 2 + (y - y0) ** 2) * top.mass * mass / whole
    loaded = top.model_copy(
        update={
            "mass": whole,
            "com": ((x0 * top.mass + x * mass) / whole, (y0 * top.mass + y * mass) / whole),
            "inertia": max(top.inertia + around, 0.0),
        }
    )
    return neck.model_copy(update={"mechanisms": (*neck.mechanisms[:-1], last.model_copy(update={"top": loaded}))})
