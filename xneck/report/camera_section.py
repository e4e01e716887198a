"""What a recording's page shows of its camera and its video. Only a recording with a video imports this, and with it OpenCV."""

from identification.dataset.dataset import DataSet
from xneck.recording.camera_stages import VideoResult
from xneck.recording.drawn_video import DrawnVideo
from xneck.report.annotated_frames import frame_cuts
from xneck.report.camera_figures import coverage_and_errors
from xneck.report.camera_tables import camera_rows, marker_rows, picture_rows
from xneck.report.figure_block import FigureBlock
from xneck.report.film import film


def calibration_figure(video: VideoResult) -> FigureBlock | None:
    """The figure of the calibration; None where the camera came as a file."""
    return coverage_and_errors(video.calibration) if video.calibration is not None else None


def camera_section(video: VideoResult, drawn: DrawnVideo, data: DataSet) -> dict[str, object]:
    """The template's values for the sections on the camera and on the frames."""
    return {
        "camera": video.camera,
        "calibration": video.calibration,
        "extraction": video.extraction,
        "camera_rows": camera_rows(video.camera, video.calibration),
        "picture_rows": picture_rows(video.calibration) if video.calibration is not None else [],
        "marker_rows": marker_rows(video.extraction),
        "frame_cuts": frame_cuts(video, drawn),
        "film": film(drawn.overlay, data),
    }
