"""Windows of a recording: which of them are whole."""

import numpy as np
import pytest

from identification.dataset.dataset import DataSet
from identification.dataset.series import Series, numbered_columns
from identification.simulation.windows import windows_of
from mechanism.description import read_neck
from tests.paths import NECK_FILE

STEP = 0.01
ROWS = 50


def recording(gaps: tuple[tuple[float, float], ...], bridged: tuple[int, ...] = ()) -> DataSet:
    """Half a second, with gaps of its log, s, and rows for which vision missed a joint."""
    missed = np.zeros((ROWS, 3))
    missed[list(bridged), 1] = 1.0
    state = Series(STEP * np.arange(ROWS, dtype=float), numbered_columns("bridged", missed))
    empty = Series(np.zeros(0), {})
    clock = {"log_gaps": gaps}
    return DataSet(
        neck=read_neck(NECK_FILE), neck_yaml="", state=state, fasquelle=empty, angles=empty, log=empty, clock=clock
    )


@pytest.mark.parametrize(
    ("gaps", "bridged", "whole"),
    [
        ((), (), [True, True, True, True, True]),
        (((0.145, 0.255),), (), [True, False, False, True, True]),
        (((0.135, 0.375),), (), [True, False, False, False, True]),
        (((0.445, 0.475), (0.025, 0.035)), (), [False, True, True, True, False]),
        ((), (29,), [True, True, False, True, True]),
    ],
)
def test_a_window_that_a_gap_touches_is_not_whole(
    gaps: tuple[tuple[float, float], ...], bridged: tuple[int, ...], whole: list[bool]
) -> None:
    """Windows of a tenth of a second: those in which a gap begins and ends, and those between."""
    windows = windows_of(recording(gaps, bridged), 0.1)
    assert windows.complete().tolist() == whole
    numbers = [number if complete else -1 for number, complete in enumerate(whole)]
    assert windows.number_of_rows().tolist() == np.repeat(numbers, 10).tolist()
