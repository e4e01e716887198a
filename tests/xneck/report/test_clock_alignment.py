"""The clock of a data set fits its cables best."""

import numpy as np

from xneck.recording.recording_result import RecordingResult
from xneck.report.clock_alignment import clock_alignment


def test_the_clock_of_the_record_fits_best(result: RecordingResult) -> None:
    found = clock_alignment(result.data)
    best = found.shifts[np.argmin(np.sqrt(np.mean(found.rms**2, axis=1)))]
    assert abs(best) <= 0.003
    assert np.sqrt(np.mean(found.residual**2)) < 1e-4
