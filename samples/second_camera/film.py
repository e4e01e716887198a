"""A world as a video file, in any codec and container that PyAV writes."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import cast

import av
import numpy as np
from av.video.stream import VideoStream
from numpy.typing import NDArray

from samples.second_camera.picture import Studio
from samples.second_camera.world import World

TICKS = 90_000


@dataclass(frozen=True)
class Coding:
    """How pictures are compressed; the container follows from the file's name."""

    codec: str = "libx264"
    options: dict[str, str] = field(default_factory=lambda: {"crf": "23", "preset": "medium"})
    bit_rate: int | None = None
    """bit/s, for codecs without a quality"""


def film(world: World, path: str | Path, coding: Coding = Coding()) -> None:
    """Write the world's pictures at their times. Frames of one time twice over are refused by containers."""
    studio = Studio(world)
    write(path, world.times, (studio.picture(float(t)) for t in world.times), world.lens.size, coding)


def write(
    path: str | Path,
    times: NDArray[np.float64],
    pictures: Iterator[NDArray[np.uint8]],
    size: tuple[int, int],
    coding: Coding,
) -> None:
    """Pictures (h, w, 3), blue, green, red, stamped by times (F,), s."""
    # the second scale is that of the first stamp, by default whole milliseconds
    scales = {"video_track_timescale": str(TICKS), "movie_timescale": str(TICKS)}
    with av.open(str(path), "w", options=scales if str(path).endswith((".mp4", ".mov")) else {}) as container:
        # with its tree of macroblocks x264 writes other bytes now and then
        steady = {"x264-params": "mbtree=0"} if coding.codec == "libx264" else {}
        stream = cast(VideoStream, container.add_stream(coding.codec, rate=30, options=steady | coding.options))
        stream.width, stream.height = size
        stream.pix_fmt = "yuv420p"
        if coding.codec not in ("mpeg4", "mjpeg"):
            stream.time_base = stream.codec_context.time_base = Fraction(1, TICKS)
        if coding.bit_rate:
            stream.bit_rate = coding.bit_rate
        stream.codec_context.thread_count = 1
        base = stream.codec_context.time_base or Fraction(1, 30)
        for t, picture in zip(times, pictures, strict=True):
            frame = av.VideoFrame.from_ndarray(picture, format="bgr24")
            frame.pts, frame.time_base = round(float(t) / float(base)), base
            for packet in stream.encode(frame):
                container.mux(packet)
        for packet in stream.encode():
            container.mux(packet)
