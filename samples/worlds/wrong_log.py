"""A change to a recording that has no fault, and what `sync` makes of it."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from mechanism.description import read_neck
from samples.worlds.changed_recordings import Recording, files_of
from synchronisation.angles import read_angles
from synchronisation.encoder_log import read_log
from synchronisation.synchronise import synchronise
from xneck_foundation.errors import Refused
from xneck_foundation.recovery import collected_recoveries


@dataclass(frozen=True)
class WrongLog:
    """One change to a recording, what it is in words, and how it must end."""

    kind: str
    what: str
    make: Callable[[], Recording]
    ends: str
    """`accepted`, `warned` or `refused`"""
    words: str = ""
    """a regular expression that the sentence must match, with what is to be written"""

    @property
    def is_only_written_otherwise(self) -> bool:
        """Whether it holds what the recording without fault holds: its time, counters, header or topics alone are unusual."""
        same = self.kind in ("time", "header", "topics") or (self.kind == "counter" and "wraps" in self.what)
        return same and self.ends != "refused"


@dataclass(frozen=True)
class Outcome:
    """How a recording went through `sync`."""

    ends: str
    """`accepted`, `warned` or `refused`"""
    sentence: str
    """what the user is told"""
    clock_error_s: float | None = None
    """in the middle of the video"""
    clock_sigma_s: float = 0.0


def outcome_of(wrong: WrongLog, folder: Path) -> Outcome:
    """Writes the files into a folder and synchronises them as `xneck sync` does."""
    recording = wrong.make()
    neck_file, angles_file, log_file = files_of(recording, folder)
    try:
        with collected_recoveries() as recovered:
            neck = read_neck(neck_file)
            log, angles = read_log(log_file, neck), read_angles(angles_file, neck.N)
            data = synchronise(neck, neck_file.read_text(encoding="utf-8"), angles, log, {})
    except Refused as refusal:
        return Outcome("refused", str(refusal).replace(f"{folder}/", ""))
    clock = data.clock
    middle = (angles.time[0] + angles.time[-1]) / 2
    offset = clock["offset_s"] + 1e-6 * clock["skew_ppm"] * (middle - clock["camera_middle_s"])
    warnings = [text.replace(f"{folder}/", "") for text in (*recovered, *clock["warnings"])]
    fault = data.check["faults"][0] if data.check["faults"] else None
    named = f"`check`: {data.check['verdict']}" + (f", {fault['fault']} of {fault['where']}" if fault else "")
    return Outcome(
        "warned" if warnings else "accepted",
        "; ".join([*warnings, named]),
        clock_error_s=offset - recording.offset_s,
        clock_sigma_s=clock["offset_sigma_s"],
    )
