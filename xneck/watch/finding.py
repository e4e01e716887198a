"""One thing that is wrong with a recording, since when, and when it was said."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any, Literal

ClockName = Literal["camera", "log"]


@dataclass(frozen=True)
class Finding:
    """What is wrong, and from when on."""

    kind: str
    """marker_lost, overexposed, underexposed, flicker, signs_or_units, signs_or_labels, periodic_motion, small_motion,
    lost_frames, repeated_frames, lost_frames_untraced, log_gap, log_stopped, log, video"""
    onset_s: float
    """s, on `clock`"""
    clock: ClockName
    """whose time the onset is"""
    what: str
    do: str = ""
    where: str = ""
    """the marker, the cable or the moment: the same kind is said again for another one only"""

    def as_json(self, said_s: float) -> dict[str, Any]:
        """The finding, said when the file of its clock had come to `said_s`, s."""
        return {"event": "finding", **asdict(self), "said_s": said_s}


class Findings:
    """All findings so far, each once."""

    def __init__(self) -> None:
        self.all: list[Finding] = []
        self._said: set[tuple[str, str]] = set()

    def new(self, findings: Iterable[Finding]) -> list[Finding]:
        """Those that were not there before."""
        new = []
        for finding in findings:
            key = (finding.kind, finding.where)
            if key not in self._said:
                self._said.add(key)
                new.append(finding)
        self.all += new
        return new
