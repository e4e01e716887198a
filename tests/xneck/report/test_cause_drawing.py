"""The drawing of the arm: its own geometry, its cables' ways, and a mark wherever an effect may sit."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from diagnosis.cause import Cause
from diagnosis.effect import Effect
from diagnosis.effects import EFFECTS
from mechanism.arm import arm_of
from mechanism.cable_lengths import lengths_without_pulleys
from mechanism.description import read_neck
from tests.paths import NECK_FILE
from xneck.report.arm_drawing import drawn_arm
from xneck.report.cause_drawing import cause_places, mark_cause
from xneck.report.recorded_axes import RecordedAxes

ARM = arm_of(read_neck(NECK_FILE))


def test_cables_go_the_way_that_their_lengths_say() -> None:
    """Above the base each is as long as the same cable around pulleys without a radius."""
    drawn = drawn_arm(ARM)
    ways = [drawn.cable(j)[1:] for j in range(ARM.M)]
    long = [float(np.sum(np.linalg.norm(np.diff(way, axis=0), axis=1))) for way in ways]
    np.testing.assert_allclose(long, lengths_without_pulleys(ARM, np.zeros(ARM.N)), rtol=1e-9)


def test_no_cable_crosses_another_below_the_base() -> None:
    drawn = drawn_arm(ARM)
    ends = np.array([drawn.cable(j)[:2, 0] for j in range(ARM.M)])
    sides = ends[np.argsort(ends[:, 0])] > 0
    assert np.all(np.diff(sides[:, 1].astype(int)) >= 0)


@pytest.mark.parametrize("effect", [e for e in EFFECTS.values() if e.place != "camera"], ids=lambda e: e.name)
def test_wherever_an_effect_may_sit_there_is_a_mark_on_the_arm(effect: Effect) -> None:
    """As many as it has places there; of a mechanism its four pulleys or its two springs."""
    each = {"pulleys": 4, "springs": 2}.get(effect.part, 1)
    places = len(effect.place_labels(ARM))
    for where in effect.placements(ARM):
        cause, drawn = Cause(effect, where, np.zeros(len(where.columns)), {}), drawn_arm(ARM)
        axes = RecordedAxes(Figure(), (0.1, 0.1, 0.8, 0.8))
        mark_cause(axes, drawn, cause)
        assert len(cause_places(drawn, cause)) == len({column % places for column in where.columns})
        marks = [mark for mark in axes.marks if mark.name == f"{effect.name}, {where.label}"]
        assert len(marks) == each * len({column % places for column in where.columns})
        assert all(np.all(np.isfinite(mark.columns["x"])) for mark in marks)
