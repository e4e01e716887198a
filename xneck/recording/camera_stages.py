"""The stages of a recording that read pixels: its camera, its angles, and frames with the linkage drawn over them.

Only these need OpenCV and PyAV: a recording with angles goes without this module.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibration.camera import Camera
from calibration.camera_file import read_camera, write_camera
from calibration.estimation import Calibration
from mechanism.description import Neck
from synchronisation.angles import write_angles
from vision.extract import Extraction, ExtractionOptions, extract
from vision.linkage.shared_fit import PlacementPrior
from vision.overlay import draw_overlay
from vision.video import Video, describe_video, read_segment
from xneck.recording.calibration_input import calibrate_from_files
from xneck.recording.progress import StageProgress, no_progress
from xneck.recording.recording_folder import Recording
from xneck.recording.watched_tracks import read_watched_tracks

ANNOTATED_FRAMES = 4
"""frames of the report that are spread over the video"""


@dataclass(frozen=True)
class AnnotatedFrame:
    """A frame with its markers, its linkage and its angles drawn over it."""

    index: int
    picture: NDArray[np.uint8]
    """(height, width, 3), BGR"""


@dataclass(frozen=True)
class VideoResult:
    """What the camera's stages made of a recording's video."""

    camera: Camera
    calibration: Calibration | None
    """None where the camera came as a file"""
    extraction: Extraction
    annotated_frames: tuple[AnnotatedFrame, ...]

    def write_files(self, folder: Path) -> None:
        """angles.mcap, and camera.yaml where the camera was calibrated."""
        if self.calibration is not None:
            write_camera(self.camera, folder / "camera.yaml")
        write_angles(self.extraction.angles, folder / "angles.mcap", self.extraction.quality)


def process_video(
    recording: Recording, neck: Neck, progress: StageProgress, watched: Path | None = None
) -> VideoResult:
    """Camera and angles of a recording with a video; `progress` is told of each stage as it begins.

    watched: file with tracks that `xneck watch` made of it, which are gone on from where they still hold."""
    assert recording.video is not None
    camera, calibration = camera_of(recording, progress)
    progress("extract")
    video = describe_video(recording.video)
    options = extraction_options(recording)
    tracked = read_watched_tracks(watched, video, neck, options)
    extraction = extract(video, camera, neck, options, tracked=tracked)
    return VideoResult(camera, calibration, extraction, _annotated_frames(video, neck, camera, extraction))


def extraction_options(recording: Recording) -> ExtractionOptions:
    """How recording.yaml says that angles are read."""
    return ExtractionOptions(
        shutter=recording.shutter,
        placement=PlacementPrior() if recording.estimate_placement else None,
        template=recording.template,
        light=recording.light,
    )


def camera_of(recording: Recording, progress: StageProgress = no_progress) -> tuple[Camera, Calibration | None]:
    """The camera as its file says, or calibrated from the pictures of a board."""
    if recording.camera is not None:
        return read_camera(recording.camera), None
    assert recording.board is not None
    progress("calibrate")
    calibration = calibrate_from_files(recording.pictures, recording.board)
    return calibration.camera, calibration


def _annotated_frames(video: Video, neck: Neck, camera: Camera, extraction: Extraction) -> tuple[AnnotatedFrame, ...]:
    """Frames spread over the video, and the one in which the arm is bent most."""
    count = len(extraction.angles.time)
    bent_most = int(np.nanargmax(np.nan_to_num(np.abs(extraction.angles.alpha)).sum(axis=1)))
    wanted = {*np.linspace(0, count - 1, ANNOTATED_FRAMES, dtype=int).tolist(), bent_most}
    return tuple(
        AnnotatedFrame(frame.index, draw_overlay(frame.grey, frame.index, neck, camera, extraction))
        for segment in video.segments
        if any(segment.first_index <= index < segment.first_index + segment.count for index in wanted)
        for frame in read_segment(video, segment)
        if frame.index in wanted
    )
