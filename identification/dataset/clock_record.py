"""The record of the camera's clock against the log's in a data set, and frames that were lost without a trace."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, Field

from identification.dataset.series import MAX_TIME_S
from xneck_foundation.strict_yaml import Strict, validate_document

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FrameLoss:
    """Frames that were lost without a trace between two stamps: from there on every stamp is earlier than its frame."""

    time: float
    """s, camera clock: stamp of the first frame after the loss"""
    frames: int
    """how many were lost"""


@dataclass(frozen=True)
class LostFrames:
    """All losses of a recording that left no trace in the stamps."""

    losses: tuple[FrameLoss, ...] = ()
    period: float = 0.0
    """s, of the camera: by so much each lost frame delays all later ones against their stamps"""

    def corrected(self, stamp: Array) -> Array:
        """True times of frames stamped `stamp`, s on the camera's clock, of the same shape."""
        stamp = np.asarray(stamp, dtype=float)
        late = np.zeros(stamp.shape)
        for loss in self.losses:
            late += loss.frames * self.period * (stamp >= loss.time)
        return stamp + late


Seconds = Annotated[float, Field(ge=-MAX_TIME_S, le=MAX_TIME_S)]
Sigma = Annotated[float, Field(ge=0, allow_inf_nan=True)] | None


class _LossRecord(Strict):
    time_s: Seconds
    frames: int


class _Record(Strict):
    """The keys of the record that are computed with; it may have others."""

    model_config = ConfigDict(frozen=True, extra="allow", strict=True)

    offset_s: Seconds = 0.0
    offset_sigma_s: Sigma = None
    skew_ppm: Annotated[float, Field(gt=-1e6, le=1e6)] = 0.0
    skew_sigma_ppm: Sigma = None
    camera_middle_s: Seconds = 0.0
    frame_period_s: Annotated[float, Field(ge=0, le=MAX_TIME_S)] = 0.0
    slips: tuple[_LossRecord, ...] = ()
    log_gaps: tuple[tuple[Seconds, Seconds], ...] = ()


def validate_clock_record(clock: Mapping[str, Any], where: str | Path) -> None:
    """Raises Refused where a record that somebody else wrote does not hold the numbers that are computed with."""
    validate_document(dict(clock), _Record, where)


def log_time(clock: Mapping[str, Any], camera_time: Array) -> Array:
    """Times of frames on the log's clock, s, from their stamps on the camera's, by a synchronisation's record."""
    losses = tuple(FrameLoss(s["time_s"], s["frames"]) for s in clock.get("slips", ()))
    camera_time = LostFrames(losses, clock.get("frame_period_s", 0.0)).corrected(camera_time)
    skew = 1e-6 * clock.get("skew_ppm", 0.0)
    return camera_time + clock["offset_s"] + skew * (camera_time - clock.get("camera_middle_s", 0.0))
