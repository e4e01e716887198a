"""How far a simulated arm is off, by geometry that is written anew here."""

from typing import Any, cast

import numpy as np
import pytest

from diagnosis.arm_error import arm_error
from identification.dataset.series import Series, numbered_columns
from identification.simulation.channels import Channel
from identification.simulation.simulated_recording import SimulatedRecording
from mechanism.arm import Arm, arm_of
from mechanism.description import read_neck
from tests.paths import NECK_FILE

ARM = arm_of(read_neck(NECK_FILE))


def recording(alpha: np.ndarray, measured: np.ndarray, rms: tuple[float, ...], noise: float) -> SimulatedRecording:
    columns = numbered_columns("alpha", alpha) | numbered_columns("alpha", measured, "_measured")
    channels = tuple(Channel(f"alpha{i}", value, noise, "rad", 1.5) for i, value in enumerate(rms, start=1))
    others = (Channel("theta1", 77.0, 88.0, "rad", 1.5),)
    time = 5.0 + 0.002 * np.arange(len(alpha), dtype=np.float64)
    return SimulatedRecording(Series(time, columns), (*channels, *others), 1.0, "f", cast(Any, None))


def tip(alpha: np.ndarray, arm: Arm = ARM) -> np.ndarray:
    """Middle of the top bar: each side by side of the crossed bars, corner by corner, (2,)."""
    left, right = np.array([-arm.b[0] / 2, 0.0]), np.array([arm.b[0] / 2, 0.0])
    for angle, L, b in zip(alpha, arm.L, arm.b, strict=True):
        along = (right - left) / np.linalg.norm(right - left)
        turned = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ along
        # the top bar's middle lies on the bisector, as far as makes a diagonal L long
        way = np.array([[np.cos(angle / 2), -np.sin(angle / 2)], [np.sin(angle / 2), np.cos(angle / 2)]]) @ np.array(
            [-along[1], along[0]]
        )
        low, high = 0.0, 2 * L
        for _ in range(80):
            middle = (low + high) / 2
            top = (left + right) / 2 + middle * way + b / 2 * turned
            low, high = (middle, high) if np.linalg.norm(top - left) < L else (low, middle)
        centre = (left + right) / 2 + low * way
        left, right = centre - b / 2 * turned, centre + b / 2 * turned
    return (left + right) / 2


def test_the_tips_distance_is_that_of_the_linkage_and_the_worst_pose_is_found() -> None:
    rng = np.random.default_rng(0)
    measured = [rng.uniform(-0.4, 0.4, (6, 3)) for _ in range(2)]
    before = [m + rng.normal(0, 0.05, m.shape) for m in measured]
    after = [m + rng.normal(0, 0.005, m.shape) for m in measured]
    before[1][4] += 0.3
    rms = ((0.03, 0.04, 0.05), (0.01, 0.02, 0.02))
    old = [recording(b, m, r, np.nan) for b, m, r in zip(before, measured, rms, strict=True)]
    new = [recording(a, m, (1e-3,) * 3, 2e-3) for a, m in zip(after, measured, strict=True)]
    found = arm_error(old, new, ARM)
    for simulated, told in ((before, found.tip_before), (after, found.tip_after)):
        off = [
            np.linalg.norm(tip(s) - tip(m))
            for ss, mm in zip(simulated, measured, strict=True)
            for s, m in zip(ss, mm, strict=True)
        ]
        assert told == pytest.approx(np.sqrt(np.mean(np.square(off))), rel=1e-9)
    assert (found.worst.recording, found.worst.time) == (1, pytest.approx(5.008))
    np.testing.assert_array_equal(found.worst.before, before[1][4])
    np.testing.assert_array_equal(found.worst.after, after[1][4])
    np.testing.assert_allclose(found.joints_before, np.sqrt(np.mean(np.square(rms), axis=0)))
    np.testing.assert_allclose(found.joints_after, 1e-3)
    np.testing.assert_allclose(found.joints_noise, 2e-3)


def test_a_simulation_that_is_the_measurement_is_off_by_nothing() -> None:
    measured = np.random.default_rng(1).uniform(-0.4, 0.4, (5, 3))
    same = [recording(measured, measured, (0.0,) * 3, 1e-3)]
    assert arm_error(same, same, ARM).tip_before == 0.0


@pytest.mark.parametrize(("noise", "is_noise"), [(0.06, True), (0.045, False)])
def test_where_a_true_model_may_be_further_off_neither_is_told_to_be_better(noise: float, is_noise: bool) -> None:
    measured = np.random.default_rng(1).uniform(-0.4, 0.4, (6, 3))
    rms = (0.03, 0.04, 0.05)
    old, new = recording(measured, measured, (0.01, 0.02, 0.02), np.nan), recording(measured, measured, rms, noise)
    assert arm_error([old], [new], ARM).is_noise == is_noise
