"""Recordings of any length from short ones: what they hold, over and over, without coding or computing it anew."""

from pathlib import Path

import av
import numpy as np

from identification.series import Series, numbered
from samples.generator.clocks import Clocks
from samples.generator.prescribed import Prescribed
from vision.angles import Angles

_PAUSE = 3000
"""of the video's time base, between one turn and the next"""


def repeat_video(source: Path, out: Path, times: int) -> None:
    """The video's packets `times` over, one after the other."""
    with av.open(str(out), "w") as target:
        stream, shift = None, 0
        for _ in range(times):
            last = 0
            with av.open(str(source)) as container:
                video = container.streams.video[0]
                stream = stream or target.add_stream_from_template(video)
                for packet in container.demux(video):
                    if packet.pts is None or packet.dts is None:
                        continue
                    last = max(last, packet.pts)
                    packet.pts, packet.dts, packet.stream = packet.pts + shift, packet.dts + shift, stream
                    target.mux(packet)
            shift += last + _PAUSE


def repeat_recording(made: Prescribed, noise: float, times: int) -> tuple[Angles, Series]:
    """Angles, with new noise (rad) in every frame, and log. The arm rests where one turn meets the next; no frame is seen there."""
    row = float(np.median(np.diff(made.log_time)))
    period = len(made.log_time) * row
    clocks: Clocks = made.clocks
    turns = np.arange(times)[:, None]
    frame_time = (made.frame_times + turns * period / (1 + clocks.skew)).ravel()
    alpha = np.tile(made.frame_alpha, (times, 1))
    alpha = alpha + np.random.default_rng(0).normal(0, noise, alpha.shape)
    columns = numbered("theta", np.tile(made.counted, (times, 1))) | numbered("f", np.tile(made.f, (times, 1)))
    log_time = np.round(made.log_time + turns * period, 3).ravel()
    return Angles(frame_time, alpha, np.full(alpha.shape, noise)), Series(log_time, columns)
