"""A recording's row in the table of a batch."""

import pytest

from xneck.report.batch_table import COLUMNS, row_cells
from xneck.report.model_adequacy import ModelAdequacy, model_adequacy


def test_a_clock_offset_is_in_seconds_and_its_sigma_in_milliseconds() -> None:
    cells = dict(zip(COLUMNS, row_cells("monday", row(None)), strict=True))
    assert cells["clock offset"] == "3.9885 s ± 0.050 ms"
    assert cells["frames"] == "299 of 300"


@pytest.mark.parametrize(("ratio", "said"), [(1.234, "1.2 × noise"), (101.4, "101 × noise")])
def test_the_table_says_at_how_many_times_noise_the_model_simulates(ratio: float, said: str) -> None:
    adequacy = ModelAdequacy(ratio, 1.7, "the angle of motor 4").as_json()
    assert adequacy["explains"] is (ratio < 3)
    assert dict(zip(COLUMNS, row_cells("day1", row(adequacy)), strict=True))["model"] == said


def test_what_could_not_be_simulated_is_said_so() -> None:
    assert model_adequacy(None) is None
    assert dict(zip(COLUMNS, row_cells("day1", row(None)), strict=True))["model"] == "not simulated"


def row(adequacy: dict[str, object] | None) -> dict[str, object]:
    return {
        "failure": None,
        "done_before": False,
        "faults": [],
        "recovered": [],
        "frames": 300,
        "frames_used": 299,
        "offset_s": 3.9885,
        "offset_sigma_s": 5e-5,
        "verdict": "consistent",
        "parameters": [],
        "seconds": 12.0,
        "adequacy": adequacy,
    }
