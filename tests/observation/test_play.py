"""Play between a motor and its drum: while the motor turns one way the drum lies against its flank, and nothing draws it away."""

import numpy as np

from mechanism.arm import arm_of
from observation.observer import Observer
from tests.observation.arms import SEEDS, case, with_laws

PLAY_M = 3e-4
ROWS, SETTLED, ARRIVING = 1500, 700, 15


def played(travel: np.ndarray) -> np.ndarray:
    """The play operator's place of the drum between its flanks, -1 ... 1, along the cable's travel (T, M), m."""
    place = np.zeros_like(travel)
    for row, step in enumerate(np.diff(travel, axis=0), start=1):
        place[row] = np.clip(place[row - 1] + step / (PLAY_M / 2), -1, 1)
    return place


def speed(theta: np.ndarray) -> np.ndarray:
    """Of the motors, rad/s, over 20 ms about each row."""
    return np.gradient(np.apply_along_axis(np.convolve, 0, theta, np.ones(11) / 11, "same"), 2e-3, axis=0)


def test_the_drum_stays_at_its_flank_while_its_motor_turns_on() -> None:
    of = with_laws(case(SEEDS[0]), ["backlash"], {"play": PLAY_M, "pb": 0.5})
    observer = Observer(of.neck, of.model)
    theta, f = of.log.matrix("theta"), of.log.matrix("f")
    expected = played(arm_of(of.neck).drum * theta[:ROWS])
    layout = observer.numbers.layout
    place, sigma = np.zeros((ROWS, of.neck.M)), np.zeros((ROWS, of.neck.M))
    for row in range(ROWS):
        observer.step(theta[row], f[row])
        place[row] = observer.state[layout.memory]
        sigma[row] = np.sqrt(np.diag(observer.covariance)[layout.memory])
    at_flank = (np.abs(expected[:ROWS]) == 1) & (np.abs(speed(theta[:ROWS])) > 2.0)
    # for as many rows, not only now: the observer may reach the flank some rows later
    at_flank[ARRIVING:] &= at_flank[:-ARRIVING]
    at_flank[:SETTLED] = False
    assert at_flank.mean() > 0.2
    assert np.mean(place[at_flank] == expected[at_flank]) > 0.99
    assert np.median(sigma[at_flank]) == 0.0
