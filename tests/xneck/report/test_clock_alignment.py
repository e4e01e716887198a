"""The clock of a data set fits its cables best."""

import numpy as np
import pytest

from tests.hidden_arms import seen_arms
from xneck.recording.recording_result import RecordingResult
from xneck.report.clock_alignment import clock_alignment


def test_the_clock_of_the_record_fits_best(result: RecordingResult) -> None:
    found = clock_alignment(result.data)
    together = found.shifts[np.argmin(np.sqrt(np.mean(found.rms**2, axis=1)))]
    assert together == pytest.approx(0.0, abs=1e-9)
    assert np.abs(found.shifts[np.argmin(found.rms, axis=0)]).max() < 3e-3, "of each cable"
    assert np.sqrt(np.mean(found.residual**2)) < 4e-5


def test_cables_that_follow_their_force_late_do_not_seem_to_ask_for_another_clock() -> None:
    """By damping and creep; the clock of this arm is the true one to hundredths of a millisecond, one cable tells it to 5."""
    found = clock_alignment(seen_arms()["cogging"].synchronised(0))
    together = found.shifts[np.argmin(np.sqrt(np.mean(found.rms**2, axis=1)))]
    assert together == pytest.approx(0.0, abs=1e-9)
    assert np.abs(found.shifts[np.argmin(found.rms, axis=0)]).max() < 5e-3
