"""The whole way for one recording folder: calibrate, extract, sync, check, identify, simulate."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibration.camera import Camera
from calibration.camera_file import write_camera
from calibration.estimation import Calibration
from identification.dataset.dataset import DataSet
from identification.dataset.dataset_file import write_dataset
from identification.estimates import Estimates, estimate
from identification.fasquelle.method import Identification, identify
from identification.files import joint_state
from identification.model_file import Model, model_of, write_model
from identification.simulation.simulated import Simulated, simulate_recording
from mechanism.description import Neck, read_neck
from synchronisation.angles import Angles, read_angles, write_angles
from synchronisation.encoder_log import read_log
from synchronisation.synchronise import synchronise
from vision.extract import Extraction
from vision.overlay import draw
from vision.video import Video, frames_of
from xneck.recording.recording_folder import Recording
from xneck.recording.stages import Stage, camera_of, extraction_of, silent
from xneck_foundation.errors import Refused
from xneck_foundation.provenance import provenance
from xneck_foundation.strict_yaml import read_text

SHOWN_FRAMES = 4


@dataclass(frozen=True)
class Result:
    """Everything of one recording that its report shows; what did not apply is None."""

    name: str
    recording: Recording
    camera: Camera | None
    calibration: Calibration | None
    extraction: Extraction | None
    pictures: tuple[tuple[int, NDArray[np.uint8]], ...]
    """annotated frames: index and BGR picture"""
    angles: Angles
    data: DataSet
    identification: Identification
    estimates: Estimates
    model: Model
    simulated: Simulated | None
    simulation_refused: str | None


def run_recording(recording: Recording, out: Path, stage: Stage = silent) -> Result:
    """All stages in order, their files into the folder `out`; `stage` is told of each as it begins."""
    neck = read_neck(recording.neck)
    camera = calibration = extraction = None
    pictures: tuple[tuple[int, NDArray[np.uint8]], ...] = ()
    log = read_log(recording.log, neck)
    if recording.angles is not None:
        angles = read_angles(recording.angles, neck.N)
    else:
        camera, calibration = camera_of(recording, stage)
        if calibration is not None:
            write_camera(camera, out / "camera.yaml")
        video, extraction = extraction_of(recording, neck, camera, stage)
        angles = extraction.angles
        write_angles(angles, out / "angles.mcap", extraction.quality)
        pictures = _annotated(video, neck, camera, extraction)
    stage("sync")
    origin = provenance(recording.files)
    data = synchronise(neck, read_text(recording.neck), angles, log, origin)
    write_dataset(data, out / "dataset.mcap")
    stage("identify")
    found = identify([data])
    estimates = estimate([data])
    model = model_of(estimates.parameters, estimates.laws, origin, estimates.covariance)
    write_model(model, out / "model.yaml")
    stage("simulate")
    simulated, why = None, None
    try:
        simulated = simulate_recording(data, model)
        joint_state.write(out / "simulated.mcap", {"simulated": simulated.series}, {"provenance": origin})
    except Refused as refused:  # a model that cannot be simulated is a result, not the end of the report
        why = str(refused)
    return Result(
        recording.folder.name, recording, camera, calibration, extraction, pictures, angles, data, found,
        estimates, model, simulated, why,
    )  # fmt: skip


def _annotated(
    video: Video, neck: Neck, camera: Camera, extraction: Extraction
) -> tuple[tuple[int, NDArray[np.uint8]], ...]:
    """Frames spread over the video, and the one in which the arm is bent most."""
    count = len(extraction.angles.time)
    bent = int(np.nanargmax(np.nan_to_num(np.abs(extraction.angles.alpha)).sum(axis=1)))
    wanted = {*np.linspace(0, count - 1, SHOWN_FRAMES, dtype=int).tolist(), bent}
    return tuple(
        (frame.index, draw(frame.grey, frame.index, neck, camera, extraction))
        for segment in video.segments
        if any(segment.before <= index < segment.before + segment.count for index in wanted)
        for frame in frames_of(video, segment)
        if frame.index in wanted
    )
