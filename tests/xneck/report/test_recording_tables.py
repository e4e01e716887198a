"""The table of a simulation tells joints in degrees and motors in cable."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from identification.simulation.channels import Channel
from xneck.report.recording_tables import simulated_rows


def test_each_motor_winds_cable_by_its_own_drum() -> None:
    """A tenth of a radian on drums of 0.4 and 0.8 mm a radian."""
    channels = [Channel(name, 0.1, 0.05, "rad", 1.4) for name in ("alpha2", "theta1", "theta2")]
    arm = SimpleNamespace(drum=np.array([0.4e-3, 0.8e-3]))
    result: Any = SimpleNamespace(simulated=SimpleNamespace(channels=channels), data=SimpleNamespace(arm=arm))
    assert [row[:5] for row in simulated_rows(result)] == [
        ("alpha 2", "deg", "5.73", "2.9", "2.00"),
        ("theta 1", "mm of cable", "0.0400", "0.020", "2.00"),
        ("theta 2", "mm of cable", "0.0800", "0.040", "2.00"),
    ]
