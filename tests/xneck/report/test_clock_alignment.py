"""The clock of a data set fits its cables best."""

from dataclasses import replace

import numpy as np
import pytest

from mechanism.cable_lengths import lengths
from mechanism.friction import dry
from xneck.recording.recording_result import RecordingResult
from xneck.report.clock_alignment import clock_alignment


def test_the_clock_of_the_record_fits_best(result: RecordingResult) -> None:
    found = clock_alignment(result.data)
    together = found.shifts[np.argmin(np.sqrt(np.mean(found.rms**2, axis=1)))]
    assert together == pytest.approx(0.0, abs=1e-9)
    assert np.abs(found.shifts[np.argmin(found.rms, axis=0)]).max() < 3e-3, "of each cable"
    assert np.sqrt(np.mean(found.residual**2)) < 4e-5


def test_cables_that_follow_their_force_late_do_not_seem_to_ask_for_another_clock(result: RecordingResult) -> None:
    """By 50 ms, as damped ones do: motors that have wound in what such cables stretch, row by row."""
    data, arm = result.data, result.data.arm
    state, step = data.state, float(data.state.time[1] - data.state.time[0])
    tension = state.matrix("f") - arm.motor_inertia / arm.drum * state.matrix("theta", "_dd")
    tension = tension - 14.0 * dry(state.matrix("theta", "_d"))
    stretched = np.empty_like(tension)
    stretched[0] = tension[0]
    for k in range(1, len(tension)):
        stretched[k] = stretched[k - 1] + step / 0.05 * (tension[k] - stretched[k - 1])
    winding = lengths(arm, np.zeros(arm.N)) - lengths(arm, state.matrix("alpha"))
    theta = (winding + stretched / 8000.0) / arm.drum
    columns = {**state.columns, **{f"theta{j + 1}": theta[:, j] for j in range(arm.M)}}
    found = clock_alignment(replace(data, state=replace(state, columns=columns)))
    assert found.shifts[np.argmin(found.rms, axis=0)] == pytest.approx(0.0, abs=1e-9)
