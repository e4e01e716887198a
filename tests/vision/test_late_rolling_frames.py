"""A frame of another moment tells nothing of the motion by which the rows of its neighbours are brought to one moment."""

from typing import Any

import numpy as np
import pytest

from mechanism.description import read_neck
from tests.vision.linkage.test_row_time import swinging
from tests.vision.scene import corners, rolled
from tests.vision.test_extract import CAMERA, R, tracks_of_corners
from vision.extract import ExtractionOptions, extract
from vision.shutter import Shutter
from vision.video import describe_video


def test_late_frames_do_not_bend_their_neighbours(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two of 60 frames were taken 20 ms before their stamps, by a shutter whose rows take 11 ms in all."""
    neck, time, late, row_s = read_neck(R / "neck.yaml"), np.arange(60) / 30, [25, 41], 1.5e-5
    taken = time.copy()
    taken[late] -= 0.02
    tracks = tracks_of_corners(time, rolled(neck, taken, swinging(5), row_s))
    fitted_to: list[np.ndarray] = []

    def stopped_fit(neck: Any, camera: Any, mended: np.ndarray, *others: Any, **more: Any) -> None:
        fitted_to.append(mended)
        raise InterruptedError

    monkeypatch.setattr("vision.extract.track_video", lambda *args: tracks)
    monkeypatch.setattr("vision.recorded_linkage.fit_linkage", stopped_fit)
    options = ExtractionOptions(shutter=Shutter(row_s=row_s), template=False)
    with pytest.raises(InterruptedError):
        extract(describe_video(R / "video.mp4"), CAMERA, neck, options)
    off = np.abs(fitted_to[0] - corners(neck, swinging(5)(time))).max(axis=(1, 2, 3))
    assert np.flatnonzero(np.isnan(off)).tolist() == late
    assert off[[24, 26, 40, 42]].max() < 0.2
