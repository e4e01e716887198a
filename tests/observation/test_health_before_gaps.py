"""What changes in an arm just before its log has a gap is told."""

import numpy as np
import pytest

from observation.health import HealthMonitor, verdict


def test_what_changes_in_the_last_seconds_before_a_gap_is_told() -> None:
    """A whole window from 2 to 10 s, and 8 N that are missing in the 4 s behind it, where 1 N was left."""
    noise = np.random.default_rng(2)
    monitor = HealthMonitor(np.ones(4), np.full(4, 15.0))
    for now in np.arange(0.0, 14.0, 0.01).tolist():
        error = 0.3 * noise.standard_normal(4) + (8.0 if now > 10.1 else 0.0)
        monitor.add(now, error, np.full(4, 50.0 * np.sign(np.sin(3 * now))))
    assert verdict(monitor) == "as identified"
    monitor.restart()
    assert (verdict(monitor), monitor.gaps) == ("changed", 1)
    assert {found.motor for found in monitor.findings} == {1, 2, 3, 4}
    assert [found.time for found in monitor.findings] == pytest.approx([10.0] * 4, abs=0.02)
