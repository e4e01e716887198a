"""Frames that are missing are said once."""

import numpy as np

from xneck.watch.frame_findings import frame_findings


def test_a_gap_that_was_said_by_itself_is_not_counted_again() -> None:
    """Of 30 frames in a second twelve are missing at once, more than one in twenty of the last 5 s."""
    numbers = np.delete(np.arange(150), np.arange(60, 72))
    (finding,) = frame_findings((numbers / 30).tolist())
    assert finding.what == f"12 frames are missing after {59 / 30:.2f} s"


def test_single_frames_that_are_missing_beside_a_gap_are_counted_without_it() -> None:
    numbers = np.delete(np.arange(150), [*range(60, 72), *range(80, 140, 5)])
    gap, share = frame_findings((numbers / 30).tolist())
    assert gap.what.startswith("12 frames are missing after")
    assert share.what == "12 of the last 137 frames are missing"
