"""What is written after a diagnosis: markers that were turned are where the new description says."""

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.cause import Cause
from diagnosis.compare import compare
from diagnosis.effects import EFFECTS
from diagnosis.extended_model import extended_description
from diagnosis.fit_stage import FitStage
from diagnosis.hypothesis import as_described
from diagnosis.linearisation import base_unknowns, corrected_signals, linearise
from diagnosis.nuisances import nuisances_at
from identification.whitening import Whitener
from mechanism.description import read_neck
from mechanism.tolerance import Tolerance
from tests.identification.test_estimates import recording
from tests.paths import NECK_FILE

SAMPLE = NECK_FILE


@pytest.mark.parametrize("bar", [1, 2, 3])
def test_a_turned_marker_is_described_as_it_sits(bar: int) -> None:
    """Its bar is read anew from what the camera sees of it, and comes out as it stood."""
    exact = read_neck(SAMPLE).model_copy(update={"tolerance": Tolerance(marker_angle=0.0)})
    data, off = replace(recording(2000), neck=exact), 0.03
    h, late = as_described(data.neck), np.zeros(1)
    effect = EFFECTS["marker_offset"]
    where = next(w for w in effect.placements(h.arm) if w.label == f"bar {bar}")
    causes = (Cause(effect, where, np.array([off]), {}),)
    now = compare(
        at := linearise(h, corrected_signals(h, [data], late), base_unknowns(h, 1).start(), late),
        (),
        (),
        nuisances_at(at),
        Whitener(np.ones((7, 1))),
    )
    written = extended_description(FitStage(h, now, causes, (), 0.0, now.fit()))
    assert data.neck.markers is not None
    assert written.markers is not None
    stood = np.array([0.0, 0.1, -0.2, 0.4])  # of every bar
    # the marker is turned by `off`, so that with the old description its bar was read too large by as much
    seen = {
        m.id: stood[m.bar] + m.angle + (off if m.bar == bar else 0.0)
        for m in data.neck.markers.on_bars
        if m.bar is not None
    }
    for m in written.markers.on_bars:
        if m.bar is not None:
            assert seen[m.id] - m.angle == pytest.approx(stood[m.bar], abs=1e-9)
