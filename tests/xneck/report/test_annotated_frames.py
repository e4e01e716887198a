"""Annotated frames are cut to the region in which the arm moves."""

import base64
from dataclasses import replace

import cv2
import numpy as np

from xneck.recording.recording_result import RecordingResult
from xneck.report.annotated_frames import frame_cuts


def test_frames_are_cut_to_where_the_markers_were(result: RecordingResult) -> None:
    assert result.video is not None
    assert result.drawn is not None
    extraction = result.video.extraction
    corners = np.full(extraction.corners.shape, np.nan)
    corners[0, 0], corners[5, 1] = (300.0, 200.0), (500.0, 600.0)
    first, last = frame_cuts(replace(result.video, extraction=replace(extraction, corners=corners)), result.drawn)
    packed = np.frombuffer(base64.b64decode(first.uri.split(",")[1]), np.uint8)
    picture = cv2.imdecode(packed, cv2.IMREAD_COLOR)
    assert picture is not None
    assert picture.shape == (400 + 2 * 48, 200 + 2 * 48, 3)  # a margin of 0.12 of the longer side
    assert last.angles[0].startswith("alpha 1: ")
    assert last.angles[0].endswith(" deg")
