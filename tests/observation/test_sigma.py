"""Sigma is what errors are: no narrower, and no wider; and each part of it is what it comes from."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from identification.model_file import pose_machine
from mechanism.cable_lengths import geometry_of_poses
from mechanism.dynamics import terms
from observation.filter_numbers import X0_DRIFT_M, filter_numbers
from observation.observed_log import observe_log
from observation.observer import Observer
from observation.resting_arm import compliance, missing_torque
from tests.observation.arms import SEEDS, SETTLED, Case, case
from tests.similar_arms import similar_neck, stronger_model, with_forces
from xneck_foundation.errors import Refused

NO_PLAY = np.empty(0)
"""sides of the drums of arms without play"""


def test_errors_are_as_large_as_sigma() -> None:
    """Mean squares of errors over variances of two arms, each joint.

    Errors of angles are those of a few numbers all along: at least two of each joint (an offset, and a slope along the pose), or
    twelve of both arms, whose mean square is in 0.2 ... 2.7 of its expectation in 997 of 1000. Those of rates vary from row to row.
    """
    squares: dict[str, list[float]] = {"": [], "_d": []}
    for seed in SEEDS:
        of = case(seed)
        seen = observe_log(of.neck, of.model, of.log).series
        for suffix, truth in (("", of.alpha), ("_d", of.alpha_d)):
            error, sigma = seen.matrix("alpha", suffix) - truth[: len(seen)], seen.matrix("sigma_alpha", suffix)
            squares[suffix].append(float(np.mean((error / sigma)[SETTLED:] ** 2)))
    assert 0.2 < np.mean(squares[""]) < 2.7
    assert 0.3 < np.mean(squares["_d"]) < 2.0


def test_a_log_that_begins_in_motion_is_honest_from_its_first_row() -> None:
    """Errors of 0.1 deg and more at the first row are gone within 0.2 s, and no joint is off by more than four sigmas."""
    of = case(SEEDS[0])
    first = int(np.argmax(np.abs(of.alpha_d).max(axis=1) > 0.5))
    theta, f = of.log.matrix("theta")[first:], of.log.matrix("f")[first:]
    observer = Observer(of.neck, of.model)
    for row in range(200):
        alpha, alpha_d, covariance = observer.step(theta[row], f[row])
        error = np.concatenate([alpha - of.alpha[first + row], alpha_d - of.alpha_d[first + row]])
        assert np.abs(error / np.sqrt(np.diag(covariance))).max() < 4
        if row >= 100:
            assert np.degrees(np.abs(error[:3])).max() < 0.05


def poses(of: Case) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Angles, motor angles, speeds of joints and rates of elongation of some rows, speeds drawn."""
    rng, rows = np.random.default_rng(2), slice(500, 4000, 350)
    alpha, theta = of.alpha[rows], of.log.matrix("theta")[rows]
    return alpha, theta, 0.5 * rng.standard_normal(alpha.shape), 0.01 * rng.standard_normal(theta.shape)


def test_what_is_missing_is_that_of_the_equations_of_motion() -> None:
    of = case(SEEDS[0])
    observer, machine = Observer(of.neck, of.model), pose_machine(of.model, of.neck)
    layout = observer.numbers.layout
    alpha, theta, alpha_d, x_d = poses(of)
    missing, _ = missing_torque(machine, alpha, theta, alpha_d, x_d)
    travel_d = x_d + np.einsum("pij,pi->pj", geometry_of_poses(machine.arm, alpha).Z, alpha_d)
    for row in range(len(alpha)):
        state = layout.vector(
            alpha=alpha[row], alpha_d=alpha_d[row], theta=theta[row], theta_d=travel_d[row] / machine.arm.drum,
            x0=machine.arm.x0,
        )  # fmt: skip
        e = observer.prediction.equations.at(state, np.zeros(layout.M), 0.0)
        c = terms(machine.arm, alpha[row][None], alpha_d[row][None]).c[0]
        np.testing.assert_allclose(e.elongation_d, x_d[row], rtol=0, atol=1e-9)
        np.testing.assert_allclose(e.rates[: layout.N], missing[row] - c, rtol=1e-9, atol=1e-9)


def test_unknown_damping_is_unknown_angle_where_tensions_change() -> None:
    """A model of which damping alone is unknown: angles at rest are known, and where a cable stretches its torque moves them."""
    of = case(SEEDS[0])
    assert of.model.pose is not None
    pose, sigma = of.model.pose, 20.0
    place = next(i for i, n in enumerate(pose.numbers) if (n.name, n.index) == ("ca", 2))
    numbers = tuple(n.model_copy(update={"sigma": sigma if i == place else 0.0}) for i, n in enumerate(pose.numbers))
    covariance = np.zeros((len(numbers), len(numbers)))
    covariance[place, place] = sigma**2
    rows = tuple(tuple(row) for row in covariance.tolist())
    known = of.model.model_copy(update={"pose": pose.model_copy(update={"numbers": numbers, "covariance": rows})})
    error, machine = filter_numbers(of.neck, known).pose_error, pose_machine(of.model, of.neck)
    alpha, theta, *_ = poses(of)
    tension = missing_torque(machine, alpha, theta)[1]
    stretching = np.array([0.0, 0.01, 0.0, 0.0])
    Z = geometry_of_poses(machine.arm, alpha).Z
    expected = np.einsum("pij,pj->pi", compliance(machine, alpha, theta), Z[:, :, 1] * sigma * stretching[1])
    for row in range(len(alpha)):
        at = error.at(alpha[row], float(tension[row]), np.zeros(3), stretching, NO_PLAY)
        still = error.at(alpha[row], float(tension[row]), np.zeros(3), np.zeros(4), NO_PLAY)
        # linear in the rate all over the range, with a compliance that depends on the pose
        scale = np.abs(expected[row]).max()
        np.testing.assert_allclose(np.sqrt(np.sum(at**2, axis=1)), np.abs(expected[row]), rtol=0, atol=0.35 * scale)
        assert np.sqrt(np.sum(still**2, axis=1)).max() < 0.35 * scale


@pytest.mark.parametrize("force", [0.03, 30.0])
def test_an_arm_of_the_same_size_is_observed_the_same_whatever_its_forces(force: float) -> None:
    """Nothing is much or little in newtons: with as many times the forces, angles and their sigmas are what they were."""
    of = case(SEEDS[0])
    log = of.log.part(slice(None, 1000))
    seen = observe_log(of.neck, of.model, log).series
    neck, model = similar_neck(of.neck, 1.0, force), stronger_model(of.model, force)
    same = observe_log(neck, model, with_forces(log, force)).series
    for name, column in seen.columns.items():
        largest = np.abs(column).max()
        np.testing.assert_allclose(same.columns[name], column, rtol=0, atol=1e-3 * largest, err_msg=name)


def test_motor_angles_are_as_sure_as_the_log_that_was_calibrated_with() -> None:
    """Where the model does not say, as the description's counts are."""
    of = case(SEEDS[0])
    assert of.model.pose is not None
    counted = of.model.pose.residual.count_rad
    assert counted is not None
    np.testing.assert_allclose(counted, of.neck.count_angles, rtol=1e-3)

    def sigma(count_rad: tuple[float, ...] | None) -> NDArray[np.float64]:
        assert of.model.pose is not None
        left = of.model.pose.residual.model_copy(update={"count_rad": count_rad})
        model = of.model.model_copy(update={"pose": of.model.pose.model_copy(update={"residual": left})})
        return filter_numbers(of.neck, model).theta_sigma

    np.testing.assert_allclose(sigma(None), of.neck.count_angles / np.sqrt(12))
    np.testing.assert_allclose(sigma(tuple(c / 4 for c in counted)), np.array(counted) / 4 / np.sqrt(12))
    with pytest.raises(Refused, match="of another arm"):
        sigma(counted[:1])


def test_pre_elongations_wander_as_calibration_allows() -> None:
    """The more so the more lasts of what it left of the angles in a shorter time; at most a constant, where none told too."""
    of = case(SEEDS[0])
    assert of.model.pose is not None
    layout = filter_numbers(of.neck, of.model).layout

    def density(angle_rad: float, seconds: float) -> float:
        assert of.model.pose is not None
        left = of.model.pose.residual.model_copy(
            update={"angle_rad": (1e-3,) * 3, "lasting_rad": (angle_rad,) * 3, "seconds": seconds}
        )
        model = of.model.model_copy(update={"pose": of.model.pose.model_copy(update={"residual": left})})
        return float(filter_numbers(of.neck, model).noise[layout.x0][0])

    assert density(1e-4, 60.0) == pytest.approx(density(1e-4, 30.0) / 2)
    assert density(0.0, 60.0) < density(5e-5, 60.0) < density(1e-4, 60.0) < X0_DRIFT_M**2
    assert density(1e-4, 0.0) == density(0.1, 60.0) == X0_DRIFT_M**2


def test_rates_at_rest_are_known_better_than_in_motion() -> None:
    """Where the arm rests an error that depends on the pose does not change."""
    of = case(SEEDS[0])
    left = replace(filter_numbers(of.neck, of.model), pose_slope=np.full(3, 0.02))
    rate = left.pose_error.rate(np.full(3, 0.1), np.zeros(3))
    np.testing.assert_array_equal(rate, 0.0)
    moving = left.pose_error.rate(np.full(3, 0.1), np.full(3, 0.5))
    finite = (
        left.pose_error.at(np.full(3, 0.1) + 5e-7, 40.0, np.zeros(3), np.zeros(4), NO_PLAY)
        - left.pose_error.at(np.full(3, 0.1) - 5e-7, 40.0, np.zeros(3), np.zeros(4), NO_PLAY)
    ) / 2e-6
    np.testing.assert_allclose(moving, finite, rtol=1e-6, atol=1e-12)
