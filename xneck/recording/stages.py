"""What a recording folder holds, read: its camera, its angles, its data set."""

from collections.abc import Callable
from pathlib import Path

from calibration.camera import Camera
from calibration.camera_file import read_camera
from calibration.estimation import Calibration
from identification.dataset.dataset import DataSet
from mechanism.description import Neck, read_neck
from synchronisation.angles import read_angles
from synchronisation.encoder_log import read_log
from synchronisation.synchronise import synchronise
from vision.extract import Extraction, extract
from vision.video import Video, describe
from xneck.recording.board_pictures import calibrate_from
from xneck.recording.recording_folder import Recording, read_recording
from xneck_foundation.provenance import provenance
from xneck_foundation.strict_yaml import read_text

Stage = Callable[[str], object]
"""is told of each stage by its command's name as it begins"""


def silent(stage: str) -> None:
    """Nobody is told."""


def camera_of(recording: Recording, stage: Stage = silent) -> tuple[Camera, Calibration | None]:
    """Of a recording with a video: the camera as its file says, or calibrated from the pictures of a board."""
    if recording.camera is not None:
        return read_camera(recording.camera), None
    assert recording.board is not None
    stage("calibrate")
    calibration = calibrate_from(recording.pictures, recording.board)
    return calibration.camera, calibration


def extraction_of(recording: Recording, neck: Neck, camera: Camera, stage: Stage = silent) -> tuple[Video, Extraction]:
    """Of a recording with a video: the angles that it shows."""
    assert recording.video is not None
    stage("extract")
    video = describe(recording.video)
    return video, extract(
        video, camera, neck, recording.shutter, recording.placement, recording.template, light=recording.light
    )


def synchronise_recording(folder: str | Path, stage: Stage = silent) -> DataSet:
    """The data set of a recording folder; its camera is calibrated and its video read on the way, and nothing is written.

    `stage` is told of each stage as it begins. Raises Refused with the file and the reason where one cannot be used.

    >>> import xneck
    >>> data = xneck.synchronise("samples/held_out")
    >>> data.state.matrix("alpha").shape[1], data.state.matrix("theta").shape[1]  # joints, motors
    (3, 4)
    >>> data.clock["offset_sigma_s"] < 1e-3  # the camera's clock against the log's
    True
    >>> xneck.synchronise("samples/nowhere")
    Traceback (most recent call last):
    xneck_foundation.errors.Refused: samples/nowhere: has no recording.yaml; write one with the keys video, log, camera, neck
    """
    recording = read_recording(folder)
    neck = read_neck(recording.neck)
    log = read_log(recording.log, neck)
    if recording.angles is not None:
        angles = read_angles(recording.angles, neck.N)
    else:
        camera, _ = camera_of(recording, stage)
        angles = extraction_of(recording, neck, camera, stage)[1].angles
    stage("sync")
    return synchronise(neck, read_text(recording.neck), angles, log, provenance(recording.files))
