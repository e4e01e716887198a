"""The small video as a recording's page holds it: inside the page, with the moment of each of its frames on the log's clock."""

import base64
from dataclasses import dataclass

import numpy as np

from identification.dataset.clock_record import log_time
from identification.dataset.dataset import DataSet
from vision.overlay_video import SmallOverlay


@dataclass(frozen=True)
class Film:
    """What the template needs of it."""

    uri: str
    width: int
    height: int
    video_times: str
    """of its frames, s from its beginning, with spaces between; by `log_times` the page's script finds the frame of a moment"""
    log_times: str
    """of the same frames on the log's clock, s"""
    frames: int
    frames_per_s: float


def film(overlay: SmallOverlay, data: DataSet) -> Film:
    """The small video of a recording whose clocks are known."""
    stamps = data.angles.time[overlay.frames]
    begin_to_end = float(stamps[-1] - stamps[0])
    return Film(
        uri="data:video/mp4;base64," + base64.b64encode(overlay.mp4).decode("ascii"),
        width=overlay.width,
        height=overlay.height,
        video_times=_numbers(stamps - stamps[0]),
        log_times=_numbers(log_time(data.clock, stamps)),
        frames=len(stamps),
        frames_per_s=(len(stamps) - 1) / begin_to_end if begin_to_end else 0.0,
    )


def _numbers(values: np.ndarray) -> str:
    return " ".join(f"{value:.3f}" for value in values.tolist())
