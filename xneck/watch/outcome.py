"""What a recording will give: its clock with sigma, and which parameters it identifies, from its newest part."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from calibration.camera import Camera
from identification.dataset.series import Series
from identification.estimates import estimate
from identification.identifiability import Identifiability
from mechanism.description import Neck
from synchronisation.encoder_log import motor_log
from synchronisation.synchronise import synchronise
from vision.extract import ExtractionOptions
from xneck.recording.recording_folder import Recording
from xneck.watch.video_watch import SeenFrame
from xneck.watch.window_angles import window_angles
from xneck_foundation.errors import Refused
from xneck_foundation.parameter import Parameter
from xneck_foundation.recovery import collected_recoveries
from xneck_foundation.strict_yaml import read_text

MAX_FRAME_HZ = 60.0
"""frames a second that are used at most"""


@dataclass(frozen=True)
class Outcome:
    """What the newest part of a recording gives, and what `run` would refuse of it."""

    seconds: float
    """s of video that it was told from"""
    clock: dict[str, Any] | None = None
    """as `sync` has it; None where it cannot be told"""
    check: str | None = None
    """the check's verdict"""
    refused: str | None = None
    """why there is no clock, or nothing was identified"""
    parameters: tuple[tuple[Parameter, Identifiability], ...] = field(default=())

    def as_json(self) -> dict[str, Any]:
        """Ready for JSON."""
        return {
            "seconds": self.seconds,
            "clock": self.clock
            and {
                key: self.clock[key]
                for key in ("offset_s", "offset_sigma_s", "skew_ppm", "skew_sigma_ppm", "frames_lost", "warnings")
            },
            "check": self.check,
            "refused": self.refused,
            "parameters": [
                {
                    "name": p.name,
                    "index": p.index,
                    "value": p.value,
                    "unit": p.unit,
                    "sigma": p.sigma,
                    "identified": judged.identified,
                    "why": judged.why,
                }
                for p, judged in self.parameters
            ],
        }


def outcome_of(
    recording: Recording,
    neck: Neck,
    camera: Camera,
    options: ExtractionOptions,
    frames: Sequence[SeenFrame],
    rows: Series | None,
) -> Outcome:
    """The outcome of frames and rows as the log's file has them."""
    if len(frames) < 2 or rows is None:
        missing = "video" if len(frames) < 2 else "log"
        return Outcome(0.0, refused=f"nothing of the {missing} was read")
    seconds, clock, check = frames[-1].time - frames[0].time, None, None
    try:
        with collected_recoveries():
            log = motor_log(rows, neck, recording.log)
            angles = window_angles(neck, camera, options, frames, str(recording.video), MAX_FRAME_HZ)
            data = synchronise(neck, read_text(recording.neck), angles, log, {})
            clock, check = dict(data.clock), data.check["verdict"]
            return Outcome(seconds, clock, check, None, estimate([data]).with_identifiability)
    except Refused as refusal:
        return Outcome(seconds, clock, check, str(refusal))
    except np.linalg.LinAlgError as error:
        return Outcome(seconds, clock, check, f"the equations of these data cannot be solved ({error})")
