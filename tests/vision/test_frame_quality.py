"""Gaps are stated with their frames and their cause."""

import numpy as np

from vision.frame_quality import angle_gaps, frame_quality
from vision.markers.tracking import DOUBLED, NOT_FOUND, TRACKED
from vision.markers.video_tracking import MarkerTracks

TIME = np.arange(30, dtype=float) / 30
IDS = [7, 8, 9]


def test_each_gap_names_its_frames_angles_and_marker() -> None:
    alpha = np.zeros((30, 2))
    alpha[5:8, 1] = np.nan
    alpha[20:] = np.nan
    status = np.full((30, 3), TRACKED, dtype=np.int8)
    status[5:8, 2] = NOT_FOUND
    status[20:, 0] = DOUBLED
    first, second = angle_gaps(TIME, alpha, IDS, status)
    assert (first["first_frame"], first["last_frame"], first["angles"]) == (5, 7, ["alpha2"])
    assert first["cause"].startswith("marker 9 not found")
    assert (second["first_frame"], second["last_frame"], second["angles"]) == (20, 29, ["alpha1", "alpha2"])
    assert second["cause"] == "marker 7 in view twice"
    assert angle_gaps(TIME, np.zeros((30, 2)), IDS, status) == []


def test_blur_is_the_way_during_the_exposure() -> None:
    """A marker moving at 300 px/s smears by 1.2 px in 4 ms; one that is not seen smears nothing."""
    corners = np.zeros((30, 3, 4, 2))
    corners[:, 1, :, 0] = 300 * TIME[:, None]
    corners[:, 2] = np.nan
    nothing = np.zeros((30, 3), dtype=np.float32)
    status = np.zeros((30, 3), dtype=np.int8)
    seen = MarkerTracks(
        time=TIME,
        corners=corners,
        covariance=None,
        status=status,
        hidden=nothing,
        clipped=nothing,
        fell_back=nothing.astype(bool),
        row_shift=nothing,
        prints=np.empty((0, 4)),
        foreign_ids=(),
    )
    found = frame_quality(seen, IDS, np.zeros(30), 0.004)
    np.testing.assert_allclose(found.columns["blur_px"], 1.2, rtol=1e-9)
    assert set(found.columns) == {"residual_px", "blur_px", "how_id7", "how_id8", "how_id9"}
