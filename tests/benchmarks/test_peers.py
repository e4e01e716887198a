"""Peers and limits are what they are said to be."""

import numpy as np
import pytest

from benchmarks.apriltag import apriltags
from benchmarks.opencv import searching
from samples.worlds.clock_worlds import NOISE_RAD, offset_bound
from tests.paths import SAMPLES
from vision.video import read_frames

VIDEO = SAMPLES / "recording/video.mp4"


@pytest.mark.parametrize("decimate", [1.0, 2.0])
def test_apriltags_corners_come_in_opencvs_order_and_pixels(decimate: float) -> None:
    """Within what either is off by. A corner that was taken for another would be 60 px away, other pixels 0.7 px on the mean."""
    grey = np.ascontiguousarray(next(read_frames(VIDEO)).grey)
    theirs = dict(apriltags("apriltag_36h11", decimate)(grey))
    opencv = searching("apriltag_36h11", "SUBPIX")(grey)
    assert theirs.keys() == opencv.keys() == {0, 1, 2, 3}
    off = np.array([theirs[i] - opencv[i] for i in opencv])
    assert np.abs(off).max() < 1
    assert np.linalg.norm(off.mean(axis=(0, 1))) < 0.2


def test_the_bound_of_an_offset_is_reached_where_all_else_is_known() -> None:
    """By least squares for offset and skew, on a motion that quickens so that both are tied."""
    time = np.linspace(3.0, 13.0, 300)
    speed = np.stack([np.cos(time), 0.3 * (time - 3.0)], axis=-1)
    about = (time - 8.0)[:, None]
    J = np.stack([speed.ravel(), (speed * about).ravel()], axis=-1)
    noise = np.random.default_rng(1).normal(0, NOISE_RAD, (J.shape[0], 4000))
    offset = np.linalg.lstsq(J, noise, rcond=None)[0][0]
    # the spread of 4000 draws is itself known to 1.1 %
    assert np.std(offset) == pytest.approx(offset_bound(time, speed), rel=0.05)
    assert np.std(offset) > 1.1 * NOISE_RAD / np.linalg.norm(speed), "the skew costs something here"
