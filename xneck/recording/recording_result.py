"""Everything of one recording that its report and its viewers' files show."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from identification.dataset.dataset import DataSet
from identification.estimates import Estimates
from identification.fasquelle.method import FasquelleIdentification
from identification.model_file import Model
from identification.simulation.simulated_recording import SimulatedRecording
from synchronisation.angles import Angles
from xneck.recording.recording_folder import Recording

if TYPE_CHECKING:
    from xneck.recording.camera_stages import VideoResult
    from xneck.recording.drawn_video import DrawnVideo


@dataclass(frozen=True)
class RecordingResult:
    """What the stages made of a recording; what does not apply to it is None."""

    name: str
    recording: Recording
    video: "VideoResult | None"
    """None where the angles came as a file"""
    drawn: "DrawnVideo | None"
    """the video with what was found drawn over it; None where the angles came as a file"""
    angles: Angles
    data: DataSet
    fasquelle: FasquelleIdentification
    """parameters and fits by the method of Fasquelle 2021"""
    estimates: Estimates
    model: Model
    simulated: SimulatedRecording | None
    simulation_refused: str | None
    """why there is no simulation"""
    pose_refused: str | None = None
    """why the model does not say how motors tell the joints"""
