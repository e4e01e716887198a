"""The stages of a recording that read pixels: its camera and its angles.

Only these need OpenCV and PyAV: a recording with angles goes without this module.
"""

from dataclasses import dataclass
from pathlib import Path

from calibration.camera import Camera
from calibration.camera_file import read_camera, write_camera
from calibration.estimation import Calibration
from mechanism.description import Neck
from synchronisation.angles import write_angles
from vision.extract import Extraction, ExtractionOptions, extract
from vision.linkage.shared_fit import PlacementPrior
from vision.video import describe_video
from xneck.recording.calibration_input import calibrate_from_files
from xneck.recording.progress import StageProgress, no_progress
from xneck.recording.recording_folder import Recording
from xneck.recording.watched_tracks import read_watched_tracks


@dataclass(frozen=True)
class VideoResult:
    """What the camera's stages made of a recording's video."""

    camera: Camera
    calibration: Calibration | None
    """None where the camera came as a file"""
    extraction: Extraction

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
    return VideoResult(camera, calibration, extraction)


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
