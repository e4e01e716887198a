"""From a recording folder to its angles and its data set, with a video or without one."""

from pathlib import Path
from typing import TYPE_CHECKING

from identification.dataset.dataset import DataSet
from mechanism.description import Neck, read_neck
from synchronisation.angles import Angles, read_angles
from synchronisation.encoder_log import read_log
from synchronisation.synchronise import synchronise
from xneck.recording.progress import StageProgress, no_progress
from xneck.recording.recording_folder import Recording, SharedFiles, read_recording
from xneck_foundation.one_blas_thread import one_blas_thread
from xneck_foundation.provenance import note_inputs, provenance
from xneck_foundation.strict_yaml import read_text

if TYPE_CHECKING:
    from xneck.recording.camera_stages import VideoResult


def recording_angles(
    recording: Recording, neck: Neck, progress: StageProgress = no_progress, watched: Path | None = None
) -> "tuple[Angles, VideoResult | None]":
    """Angles on the camera's clock: as their file has them, or from the video, then with all that was made of it.

    OpenCV and PyAV are imported for a video only. watched: file with tracks that `xneck watch` made of it.
    """
    if recording.angles is not None:
        return read_angles(recording.angles, neck.N), None
    from xneck.recording.camera_stages import process_video

    video = process_video(recording, neck, progress, watched)
    return video.extraction.angles, video


@one_blas_thread
def synchronise_recording(
    folder: str | Path,
    stage: StageProgress = no_progress,
    *,
    neck: str | Path | None = None,
    camera: str | Path | None = None,
) -> DataSet:
    """The data set of a recording folder; its camera is calibrated and its video read on the way, and nothing is written.

    `stage` is called with the name of each stage as it begins. neck, camera: files that recordings share, wherever they lie; they
    take the place of what recording.yaml names. Raises Refused with the file and the reason where one cannot be
    used.

    >>> import xneck
    >>> data = xneck.synchronise("samples/held_out")
    >>> data.state.matrix("alpha").shape[1], data.state.matrix("theta").shape[1]  # joints, motors
    (3, 4)
    >>> data.clock["offset_sigma_s"] < 1e-3  # the camera's clock against the log's
    True
    >>> xneck.synchronise("samples/nowhere")
    Traceback (most recent call last):
    xneck_foundation.errors.Refused: samples/nowhere: does not exist; check the name
    """
    recording = read_recording(folder, SharedFiles(*(None if path is None else Path(path) for path in (neck, camera))))
    inputs = note_inputs(recording.files)
    arm = read_neck(recording.neck)
    log = read_log(recording.log, arm)
    angles, _ = recording_angles(recording, arm, stage)
    stage("sync")
    return synchronise(arm, read_text(recording.neck), angles, log, provenance(inputs))
