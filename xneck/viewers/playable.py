"""A video as every viewer plays it: AV1 in mp4, upright and grey as it was measured.

Rerun's own decoder knows AV1 alone; for H.264 it needs an ffmpeg, and tags that turn the picture it does not heed.
"""

import os
from fractions import Fraction
from io import BytesIO
from pathlib import Path

import av
import numpy as np

from vision.video import describe, frames

TICKS = 90_000
"""a second"""
KEY_FRAMES = 30
"""frames from one key frame to the next: what a viewer decodes to show one in the middle"""
_OPTIONS = {"preset": "10", "crf": "32", "svtav1-params": "fast-decode=1:lp=1"}
"""quick, and without marks that are seen beside the lines drawn over it"""


def playable(video: str | Path) -> bytes:
    """The mp4 of a video, frame for frame. Raises Refused as `frames` does."""
    described, out = describe(video), BytesIO()
    os.environ.setdefault("SVT_LOG", "1")  # else the encoder tells all its settings on standard error
    with av.open(out, "w", format="mp4") as container:
        stream = container.add_stream("libsvtav1", rate=30, options=_OPTIONS)
        stream.width, stream.height = described.width // 2 * 2, described.height // 2 * 2
        stream.pix_fmt = "yuv420p"
        stream.gop_size = KEY_FRAMES
        stream.codec_context.time_base = Fraction(1, TICKS)
        for frame in frames(video):
            # the luma as it was read, and no colour: a conversion of formats would change the contrast
            planes = np.full((stream.height * 3 // 2, stream.width), 128, dtype=np.uint8)
            planes[: stream.height] = frame.grey[: stream.height, : stream.width]
            picture = av.VideoFrame.from_ndarray(planes, format="yuv420p")
            picture.pts = round(frame.time * TICKS)
            picture.time_base = Fraction(1, TICKS)
            container.mux(stream.encode(picture))
        container.mux(stream.encode(None))
    return out.getvalue()
