"""Frames whose stamps are late or early are told so, and by how much."""

import numpy as np
import pytest

from observation.frame_consistency import frame_consistency
from observation.observer import Innovation
from xneck_foundation.errors import Refused


@pytest.mark.parametrize(("late_s", "says"), [(0.02, "20 ms late"), (-0.03, "30 ms early")])
def test_frames_of_another_clock_are_said_to_be_late_or_early(late_s: float, says: str) -> None:
    """A frame that is stamped late shows where the joints were before its stamp."""
    rate = 2 * np.pi * np.array([0.3, 0.5])
    stamps = np.arange(0.0, 20.0, 0.1).tolist()
    innovations = [
        Innovation(
            alpha=0.3 * np.sin(rate * t),
            alpha_d=0.3 * rate * np.cos(rate * t),
            beside=0.3 * (np.sin(rate * (t - late_s)) - np.sin(rate * t)),
            variance=np.full(2, 1e-3**2),
        )
        for t in stamps
    ]
    found = frame_consistency(stamps, innovations)
    assert found is not None
    with pytest.raises(Refused, match=f"their times are about {says} on this log's clock"):
        found.check()
