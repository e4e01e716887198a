"""A video in a form that every viewer plays: AV1 in mp4, upright and grey as it was measured.

Rerun decodes AV1 by itself but needs an ffmpeg for H.264, and it ignores tags that turn the picture.
"""

import os
from fractions import Fraction
from io import BytesIO
from pathlib import Path

import av
import numpy as np

from vision.video import describe_video, read_frames
from xneck_foundation.usual_priority import keeping_usual_priority

TICKS_PER_S = 90_000
KEY_FRAME_DISTANCE = 30
"""frames from one key frame to the next, which is what a viewer decodes to show one between"""
_ENCODER_OPTIONS = {"preset": "10", "crf": "32", "svtav1-params": "fast-decode=1:lp=1"}
"""fast, at a quality that hides no marker's edge"""


def viewer_video(video: str | Path) -> bytes:
    """The bytes of an mp4 with the same frames. Raises Refused as `frames` does."""
    described, out = describe_video(video), BytesIO()
    os.environ.setdefault("SVT_LOG", "1")  # else the encoder prints its settings to standard error
    with av.open(out, "w", format="mp4") as container:
        stream = container.add_stream("libsvtav1", rate=30, options=_ENCODER_OPTIONS)
        stream.width, stream.height = described.width // 2 * 2, described.height // 2 * 2
        stream.pix_fmt = "yuv420p"
        stream.gop_size = KEY_FRAME_DISTANCE
        stream.codec_context.time_base = Fraction(1, TICKS_PER_S)
        keeping_usual_priority(stream.codec_context.open)
        for frame in read_frames(video):
            # the grey levels as luma, without colour: a conversion of formats would change the contrast
            planes = np.full((stream.height * 3 // 2, stream.width), 128, dtype=np.uint8)
            planes[: stream.height] = frame.grey[: stream.height, : stream.width]
            picture = av.VideoFrame.from_ndarray(planes, format="yuv420p")
            picture.pts = round(frame.time * TICKS_PER_S)
            picture.time_base = Fraction(1, TICKS_PER_S)
            container.mux(stream.encode(picture))
        container.mux(stream.encode(None))
    return out.getvalue()
