"""Where a fit begins, and that it never ends above."""

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.cause_fit import CauseFitter
from diagnosis.hypothesis import as_described
from diagnosis.noise_ensemble import noise_ensemble
from diagnosis.nuisances import NUISANCE_BOUND
from identification.dataset.dataset import DataSet
from identification.dataset.frames import frame_angles
from identification.dataset.series import Series, numbered_columns
from identification.unknowns import DELAY_SIGMA_S
from tests.identification.test_estimates import recording

LATE_ROWS = 4
"""8 ms: more than forces can be late by what is known of them"""


@pytest.fixture(scope="module")
def stale() -> DataSet:
    """Forces as they were some rows before."""
    data = recording(2000)
    f = data.state.matrix("f")
    held = np.concatenate([np.repeat(f[:1], LATE_ROWS, axis=0), f[:-LATE_ROWS]])
    return replace(data, state=Series(data.state.time, {**data.state.columns, **numbered_columns("f", held)}))


def test_a_delay_begins_within_what_is_known_of_it(stale: DataSet) -> None:
    stage = CauseFitter(as_described(stale.neck), [noise_ensemble(stale, frame_angles(stale), 0)]).base_model()
    assert abs(stage.comparison.linearisation.recordings[0].delay) <= NUISANCE_BOUND * DELAY_SIGMA_S * (1 + 1e-9)
    # from within its bounds a fit can only leave less
    assert stage.fit.loss <= stage.comparison.profiled_loss * (1 + 1e-9)
