"""A recording's row in the table of a batch."""

from xneck.report.batch_table import COLUMNS, row_cells


def test_a_clock_offset_is_in_seconds_and_its_sigma_in_milliseconds() -> None:
    row = {
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
        "adequacy": None,
    }
    cells = dict(zip(COLUMNS, row_cells("monday", row), strict=True))
    assert cells["clock offset"] == "3.9885 s ± 0.050 ms"
    assert cells["frames"] == "299 of 300"
