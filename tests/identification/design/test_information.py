"""What a motion tells of a stiffness, against what its frames tell one by one."""

import numpy as np
import pytest

from identification.design.information import AngleNoise, fisher_information
from identification.unknowns import unknowns
from tests.identification.test_rows import arm, signals

FRAME_HZ, SIGMA_RAD = 30.0, 2e-3


def test_a_stiffness_is_told_by_as_many_numbers_as_there_are_frames() -> None:
    """Every frame tells the force k x with an error of k sqrt(sum of Z^2) sigma: n of them tell k to that over sqrt(sum of x^2).

    Of one stiffness while all else is known; elongations go to and fro at most 1.5 times a second, far below the cutoff."""
    laws = ("dry_friction", "linear_cable")
    s = signals(np.random.default_rng(3), 10_000)
    rows = s.low_pass.kept
    u = unknowns(arm(), laws, 1)
    p = u.start()
    stiffness = np.array([9000.0, 7000.0, 8500.0, 6000.0])
    p[u.slots["k", None]] = stiffness
    information = fisher_information(s, u, p, AngleNoise(SIGMA_RAD, FRAME_HZ))
    told = np.diag(information)[u.slots["k", None]]

    seconds = float(s.time[rows[-1]] - s.time[rows[0]])
    frames = s.time[rows[0]] + np.arange(round(seconds * FRAME_HZ)) / FRAME_HZ
    levers = s.Z[0]
    for j, k in enumerate(stiffness):
        x = np.interp(frames, s.time, s.x[:, j])
        error = k * np.sqrt(np.sum(levers[:, j] ** 2)) * SIGMA_RAD
        assert 1 / np.sqrt(told[j]) == pytest.approx(error / np.sqrt(np.sum(x**2)), rel=0.03)
