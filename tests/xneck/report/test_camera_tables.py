"""A parameter of the lens that was held fixed says so."""

from xneck.recording.recording_result import RecordingResult
from xneck.report.camera_tables import camera_rows


def test_a_lens_parameter_that_was_held_says_so(result: RecordingResult) -> None:
    assert result.video is not None
    calibration = result.video.calibration
    assert calibration is not None
    rows = {name: value for name, value, _ in camera_rows(calibration.camera, calibration)}
    assert ("held fixed" in rows["k3"]) == ("k3" not in calibration.free)
    assert "±" in rows["fx"]
