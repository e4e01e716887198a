"""Play between a motor and its drum: while the motor turns one way the drum lies against its flank, and nothing draws it away."""

from dataclasses import dataclass

import numpy as np

from identification.pose_calibration import calibrated_model
from mechanism.arm import arm_of
from mechanism.description import Neck
from observation.observed_log import observe_log
from observation.observer import Observer
from samples.forward_arms import Settings, make_arms
from samples.forward_arms.drawing import neck as neck_of
from samples.forward_arms.laws import Law, Snapshot
from samples.forward_arms.plant import Plant
from tests.observation.arms import SEEDS, SETTLED, Case, base_model, case, dataset, second_recording, with_laws
from xneck_foundation.strict_yaml import validate_document

PLAY_M, PLAYING_SEED = 3e-4, 5012
ROWS, ARRIVED, ARRIVING = 1500, 700, 15


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
    at_flank[:ARRIVED] = False
    assert at_flank.mean() > 0.2
    assert np.mean(place[at_flank] == expected[at_flank]) > 0.99
    assert np.median(sigma[at_flank]) == 0.0


@dataclass(frozen=True)
class Gap(Law):
    """A drum that lags behind its motor by up to half of `width` (m) either way, and is taken along at its flanks.

    dragged: share of the motor's speed that the cable's damper (N s/m each) feels while the drum lags further."""

    width: float
    dragged: float
    damping: np.ndarray

    def memory_rows(self, plant: Plant) -> int:
        return plant.M

    def tension(self, s: Snapshot) -> np.ndarray:
        stands = self.memory_d(s) * self.width / 2
        return -s.stiffness * s.memory * self.width / 2 - (1 - self.dragged) * self.damping * stands

    def memory_d(self, s: Snapshot) -> np.ndarray:
        rate = s.drum / s.gear * s.theta_d / (self.width / 2)
        return np.where(s.memory * np.sign(rate) < 1, rate, 0.0)


def arm_with_play(dragged: float) -> Case:
    """An arm off its drawing whose drums have play, and its model, of numbers 20 % off, calibrated on a first recording."""
    settings = Settings(seconds=14.0, drawing_off=1.0, noise_deg=0.02, step=2e-3, base="exact", counts=65536)
    bare = next(iter(make_arms([PLAYING_SEED], settings))).plant
    law = Gap(PLAY_M, dragged, bare.damping)
    arm = next(iter(make_arms([PLAYING_SEED], settings, hidden=[(law,)])))
    neck = validate_document(neck_of(arm.drawing), Neck, "neck.yaml")
    told = Case(neck, base_model(neck, arm.drawing.stiffness), *second_recording(arm.recordings[1]))
    told = with_laws(told, ["backlash"], {"play": 0.8 * PLAY_M, "pb": 0.9})
    posed = calibrated_model(told.model, [dataset(neck, arm.recordings[0], PLAYING_SEED)])
    assert posed.refused is None
    return Case(neck, posed.model, told.log, told.alpha, told.alpha_d)


def test_joints_of_an_arm_with_play_are_told_with_their_rates() -> None:
    """Its cables' dampers feel nothing of motors that cross over. Joints jolt where a drum arrives at its flank, some rows sooner
    or later than the observer thinks: rates are off by more than sigma there.

    Errors of angles are those of a few numbers of each joint, as in test_sigma.py."""
    of = arm_with_play(dragged=0.0)
    seen = observe_log(of.neck, of.model, of.log).series
    for suffix, truth, limit, most in (("", of.alpha, 0.1, 2.7), ("_d", of.alpha_d, 1.5, 20.0)):
        error = (seen.matrix("alpha", suffix) - truth[: len(seen)])[SETTLED:]
        sigma = seen.matrix("sigma_alpha", suffix)[SETTLED:]
        assert np.degrees(np.sqrt(np.mean(error**2, axis=0))).max() < limit
        assert np.mean((error / sigma) ** 2) < most
