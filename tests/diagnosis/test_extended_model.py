"""What is written after a diagnosis: markers that were turned are where the new description says."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.cause import Cause
from diagnosis.compare import compare
from diagnosis.effects import EFFECTS
from diagnosis.extended_model import _as_adjusted, extended_description
from diagnosis.fit_stage import FitStage
from diagnosis.hypothesis import as_described
from diagnosis.linearisation import base_unknowns, corrected_signals, linearise
from diagnosis.nuisances import nuisances_at
from identification.dataset.dataset import DataSet
from identification.whitening import Whitener
from mechanism.description import read_neck
from mechanism.tolerance import Tolerance
from tests.identification.test_estimates import recording
from tests.paths import NECK_FILE

EXACT = read_neck(NECK_FILE).model_copy(update={"tolerance": Tolerance(marker_angle=0.0)})
OFF = 0.03
"""rad"""


@pytest.mark.parametrize("bar", [1, 2, 3])
def test_a_turned_marker_is_described_as_it_sits(bar: int) -> None:
    """Its bar is read anew from what the camera sees of it, and comes out as it stood."""
    data = replace(recording(2000), neck=EXACT, provenance={"angles": {"markers": []}})
    written = extended_description(stage_of_a_turned_bar(data, bar), [data])
    assert data.neck.markers is not None
    assert written.markers is not None
    assert written.alpha_zero is None
    stood = np.array([0.0, 0.1, -0.2, 0.4])  # of every bar
    # the marker is turned by `OFF`, so that with the old description its bar was read too large by as much
    seen = {
        m.id: stood[m.bar] + m.angle + (OFF if m.bar == bar else 0.0)
        for m in data.neck.markers.on_bars
        if m.bar is not None
    }
    for m in written.markers.on_bars:
        if m.bar is not None:
            assert seen[m.id] - m.angle == pytest.approx(stood[m.bar], abs=1e-9)


@pytest.mark.parametrize("markers", [True, False])
def test_what_angles_from_elsewhere_read_too_much_is_taken_off_them(markers: bool) -> None:
    """No marker that is described had a part in them: `sync` takes it off, beside what it took off them before."""
    before = (0.0, 0.01, 0.0)
    neck = EXACT.model_copy(update={"alpha_zero": before} | ({} if markers else {"markers": None}))
    data = replace(recording(2000), neck=neck, provenance={"angles": {"source": "angles.csv"}})
    written = extended_description(stage_of_a_turned_bar(data, 2), [data])
    assert written.markers == neck.markers
    np.testing.assert_allclose(written.zero_angles, [0.0, 0.01 + OFF, -OFF], atol=1e-12)


def stage_of_a_turned_bar(data: DataSet, bar: int) -> FitStage:
    """A fit whose cause is that what tells a bar's orientation is turned by OFF."""
    h, late = as_described(data.neck), np.zeros(1)
    effect = EFFECTS["marker_offset"]
    where = next(w for w in effect.placements(h.arm) if w.label == f"bar {bar}")
    causes = (Cause(effect, where, np.array([OFF]), {}),)
    now = compare(
        at := linearise(h, corrected_signals(h, [data], late), base_unknowns(h, 1).start(), late),
        (),
        (),
        nuisances_at(at),
        Whitener(np.ones((7, 1))),
    )
    return FitStage(h, now, causes, (), 0.0, now.fit())


def test_on_the_arm_as_moved_numbers_are_known_as_were_its_own_given() -> None:
    """What is known of the others where some are held is the inverse of their part of the information."""
    rng = np.random.default_rng(3)
    factor = rng.normal(size=(9, 9))
    information = factor @ factor.T + np.eye(9)
    stage: Any = SimpleNamespace(comparison=SimpleNamespace(base_count=2, nuisances=SimpleNamespace(described_count=4)))
    others = [0, 1, 6, 7, 8]
    covariance = np.asarray(np.linalg.inv(information), dtype=np.float64)
    found = _as_adjusted(stage, covariance)[np.ix_(others, others)]
    np.testing.assert_allclose(found, np.linalg.inv(information[np.ix_(others, others)]), rtol=1e-9)
