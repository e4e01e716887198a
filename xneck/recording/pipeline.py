"""All stages of one recording in order, and their files: calibrate, extract, sync, check, identify, simulate."""

from pathlib import Path
from typing import TYPE_CHECKING

from identification.dataset.dataset_file import write_dataset
from identification.estimates import estimate
from identification.fasquelle.method import fasquelle_identification
from identification.files import joint_state
from identification.model_file import write_model
from identification.pose_calibration import calibrated_model
from identification.simulation.simulated_recording import simulate_recording
from mechanism.description import Neck, read_neck
from synchronisation.encoder_log import read_log
from synchronisation.synchronise import synchronise
from xneck.recording.progress import StageProgress, no_progress
from xneck.recording.recording_folder import Recording
from xneck.recording.recording_result import RecordingResult
from xneck.recording.result_files import OVERLAY, WATCHED_TRACKS
from xneck.recording.stages import recording_angles
from xneck_foundation.errors import Refused
from xneck_foundation.provenance import note_inputs, provenance
from xneck_foundation.strict_yaml import read_text

if TYPE_CHECKING:
    from xneck.recording.camera_stages import VideoResult
    from xneck.recording.drawn_video import DrawnVideo


def run_stages(recording: Recording, out: Path, progress: StageProgress = no_progress) -> RecordingResult:
    """All stages in order, their files into the folder `out`; `progress` is called with the name of each as it begins."""
    inputs = note_inputs(recording.files)
    neck = read_neck(recording.neck)
    log = read_log(recording.log, neck)
    angles, video = recording_angles(recording, neck, progress, out / WATCHED_TRACKS)
    drawn = None
    if video is not None:
        video.write_files(out)
        drawn = _drawn_video(recording, neck, video, out / OVERLAY)
    progress("sync")
    origin = provenance(inputs)
    data = synchronise(neck, read_text(recording.neck), angles, log, origin)
    write_dataset(data, out / "dataset.mcap")
    progress("identify")
    fasquelle = fasquelle_identification([data])
    estimates = estimate([data])
    posed = calibrated_model(estimates.model.model_copy(update={"provenance": origin}), [data])
    model = posed.model
    write_model(model, out / "model.yaml")
    progress("simulate")
    simulated, reason = None, None
    try:
        simulated = simulate_recording(data, model)
        joint_state.write(out / "simulated.mcap", {"simulated": simulated.series}, {"provenance": origin})
    except Refused as refused:  # a model that cannot be simulated is a result, not the end of the report
        reason = str(refused)
    return RecordingResult(
        name=recording.folder.name,
        recording=recording,
        video=video,
        drawn=drawn,
        angles=angles,
        data=data,
        fasquelle=fasquelle,
        estimates=estimates,
        model=model,
        simulated=simulated,
        simulation_refused=reason,
        pose_refused=posed.refused,
    )


def _drawn_video(recording: Recording, neck: Neck, video: "VideoResult", file: Path) -> "DrawnVideo":
    """The video with what was found drawn over it, of which the whole in small goes into `file`."""
    from xneck.recording.drawn_video import draw_video  # needs OpenCV

    assert recording.video is not None
    drawn = draw_video(recording.video, neck, video)
    drawn.write_file(file)
    return drawn
