"""Where a fit begins, and that it never ends above."""

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.cause_fit import Trial
from diagnosis.comparison import DELAY_SIGMA
from diagnosis.hypothesis import as_described
from diagnosis.noise_ensemble import read
from diagnosis.nuisances import WALL
from identification.dataset.dataset import DataSet
from identification.dataset.frames import seen_in
from identification.dataset.series import Series, numbered
from tests.identification.test_estimates import recording

LATE_ROWS = 4
"""8 ms: more than forces can be late by what is known of them"""


@pytest.fixture(scope="module")
def stale() -> DataSet:
    """Forces as they were some rows before."""
    data = recording(2000)
    f = data.state.matrix("f")
    held = np.concatenate([np.repeat(f[:1], LATE_ROWS, axis=0), f[:-LATE_ROWS]])
    return replace(data, state=Series(data.state.time, {**data.state.columns, **numbered("f", held)}))


def test_a_delay_begins_within_what_is_known_of_it(stale: DataSet) -> None:
    begun = Trial(as_described(stale.neck), [read(stale, seen_in(stale), 0)]).begin()
    assert abs(begun.end.point.places[0].delay) <= WALL * DELAY_SIGMA * (1 + 1e-9)
    # from within its walls a fit can only leave less
    assert begun.fit.loss <= begun.end.merit * (1 + 1e-9)
