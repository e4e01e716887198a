"""What became of one recording of a batch, and the row that the summary has of it."""

from dataclasses import dataclass
from typing import Any

from xneck.report.batch_table import MAIN_PARAMETERS


@dataclass(frozen=True)
class RecordingOutcome:
    """What became of a recording: its record as result.json holds it, or why there is none."""

    name: str
    record: dict[str, Any] | None
    failure: str | None
    """one line, or None where it did not fail"""
    done_before: bool
    """whether an earlier run came to this"""

    def summary_row(self) -> dict[str, Any]:
        """The recording's row of summary.json; the path `report` is relative to it."""
        row: dict[str, Any] = {"done_before": self.done_before, "failure": self.failure}
        if self.record is None:
            return row
        sync, check = self.record["sync"], self.record["check"]
        return row | {
            "report": f"{self.name}/{self.record['report']}",
            "seconds": self.record["seconds"],
            "frames": sync["frames"],
            "frames_used": sync["frames_used"],
            "offset_s": sync["offset_s"],
            "offset_sigma_s": sync["offset_sigma_s"],
            "verdict": check["verdict"],
            "faults": check["faults"],
            "parameters": [p for p in self.record["identify"]["parameters"] if p["name"] in MAIN_PARAMETERS],
            "adequacy": self.record["adequacy"],
            "recovered": self.record["recovered"],
        }
