"""Numbers by which motors tell the joints: found on arms whose drawing, stiffness, friction and clock are all off."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from identification.dataset.series import Series
from identification.model_file import Model, PoseModel, marker_offsets, read_model, write_model
from identification.pose_calibration import calibrate_pose, calibrated_model
from identification.pose_equations import PoseEquations
from identification.pose_numbers import sought_numbers
from identification.pose_residual import lasting_rms, residual_rate, rms_beyond_noise
from identification.pose_rows import rows_of
from identification.pose_start import begun_by_motors, check_motors, motor_rms
from tests.observation.arms import NOISE_RAD, SEEDS, built_stiffness, calibration_data, case
from xneck_foundation.errors import Refused

SEED = SEEDS[0]


def values(pose: PoseModel, name: str) -> np.ndarray:
    return np.array([n.value for n in pose.numbers if n.name == name])


def test_stiffness_comes_out_though_the_drawing_is_off() -> None:
    """Within 6 %, from up to 20 % off; what it leaves of the joints is below the frames' noise."""
    of = case(SEED)
    assert of.model.pose is not None
    before = np.array([p.value for p in of.model.parameters if p.name == "k"])
    after = values(of.model.pose, "k")
    assert np.abs(before / built_stiffness(SEED) - 1).max() > 0.1
    assert np.abs(after / built_stiffness(SEED) - 1).max() < 0.06
    assert max(of.model.pose.residual.angle_rad) < NOISE_RAD


def test_several_recordings_have_a_pre_elongation_each_and_the_model_none() -> None:
    of = case(SEED, calibrated=False)
    pose = calibrate_pose(calibration_data(SEED), of.model)
    assert not [n for n in pose.numbers if n.kind == "x0"]
    assert np.abs(values(pose, "k") / built_stiffness(SEED) - 1).max() < 0.06


def test_motors_may_be_counted_from_anywhere() -> None:
    """With 6 mm of cable wound in where motors count from, and no pre-elongation in the model, all comes out as without."""
    of, (data, _) = case(SEED, calibrated=False), calibration_data(SEED)
    told = tuple(p for p in of.model.parameters if p.name != "x0")
    model = of.model.model_copy(update={"parameters": told})
    drums = np.array([m.rd / m.R for m in of.neck.motors])
    columns = dict(data.state.columns)
    for j, drum in enumerate(drums):
        columns[f"theta{j + 1}"] = columns[f"theta{j + 1}"] - 6e-3 / drum
    moved, still = (
        calibrate_pose([replace(data, state=state)], model) for state in (Series(data.state.time, columns), data.state)
    )
    np.testing.assert_allclose(values(moved, "x0") - values(still, "x0"), 6e-3, atol=5e-5)
    np.testing.assert_allclose(values(moved, "k"), values(still, "k"), rtol=5e-3)
    np.testing.assert_allclose(moved.residual.motor_N, still.residual.motor_N, rtol=0.05)


def test_a_model_whose_forces_the_fit_gives_up_is_refused() -> None:
    """Numbers without tension are refused, and those that the fit begins with are not."""
    of, (data, _) = case(SEED, calibrated=False), calibration_data(SEED)
    rows = [rows_of(data)]
    told = PoseEquations(of.neck, of.model, rows, sought_numbers(of.neck, of.model, rows))
    equations = PoseEquations(of.neck, of.model, rows, begun_by_motors(told))
    p = np.zeros(len(equations.numbers))
    begun = motor_rms(equations, p)
    check_motors(begun, 2 * begun)
    p[[n.name == "x0" for n in equations.numbers]] = -3.0
    with pytest.raises(Refused, match="of the forces of motor"):
        check_motors(begun, motor_rms(equations, p))


def test_it_goes_through_the_models_file(tmp_path: Path) -> None:
    of = case(SEED)
    path = tmp_path / "model.yaml"
    write_model(of.model, path)
    assert read_model(path) == of.model


def test_without_a_frame_it_is_refused_and_the_model_stays_as_it_was() -> None:
    data = calibration_data(SEED)[0]
    columns = {n: np.full_like(c, np.nan) if n.startswith("alpha") else c for n, c in data.angles.columns.items()}
    blind = replace(data, angles=Series(data.angles.time, columns))
    model: Model = case(SEED, calibrated=False).model
    with pytest.raises(Refused, match="no frame shows all joints"):
        calibrate_pose([blind], model)
    outcome = calibrated_model(model, [blind])
    assert outcome.model is model
    assert outcome.as_json() == {"calibrated": False, "left_rad": None, "why": outcome.refused}
    assert "no frame shows all joints" in outcome.as_text()


def test_what_is_left_is_told_where_nothing_holds_the_joints() -> None:
    """A quarter of the frames stands 10 noises beside; where it is not known to be held, that is what is left of all."""
    rng = np.random.default_rng(3)
    rests = (np.arange(2000) // 100 % 4 == 0)[:, None]
    noise = np.full((2000, 1), NOISE_RAD**2)
    held = np.where(rests, (10 * NOISE_RAD) ** 2, 0.0)
    angles = NOISE_RAD * rng.standard_normal((2000, 1)) + np.sqrt(held)
    assert rms_beyond_noise(angles, noise, held, 1 / 30)[0] < NOISE_RAD
    assert rms_beyond_noise(angles, noise, np.zeros_like(held), 1 / 30)[0] > 4 * NOISE_RAD


FRAME_S = 1 / 30


def lively() -> tuple[np.ndarray, np.ndarray]:
    """Times of a minute's frames, and angles of three joints."""
    time = np.arange(0, 60, FRAME_S)
    return time, 0.4 * np.sin(2 * np.pi * np.array([0.31, 0.43, 0.37]) * time[:, None] + np.arange(3))


def test_noise_alone_leaves_nothing_more_often_than_not() -> None:
    """Chance exceeds one sigma of itself in 16 of 100, and two in 2 of 100."""
    rng, (time, alpha) = np.random.default_rng(8), lively()
    left, rates = [], []
    for _ in range(30):
        noise = NOISE_RAD * rng.standard_normal(alpha.shape)
        variance = np.full_like(noise, NOISE_RAD**2)
        left.append(rms_beyond_noise(noise, variance, np.zeros_like(noise), FRAME_S))
        rates.append(residual_rate(noise, alpha, time)[0])
    assert np.mean(np.array(left) > 0) < 0.3
    assert np.mean(np.array(rates) > 0) < 0.08


def test_an_arm_that_swings_at_five_hertz_is_left_out() -> None:
    """It swings as much as noise; a residual of the same size at 1 Hz is told whole."""
    rng, (time, alpha) = np.random.default_rng(9), lively()
    noise = NOISE_RAD * rng.standard_normal(alpha.shape)
    variance = np.full_like(noise, NOISE_RAD**2)
    swings, slow = (np.sqrt(2) * NOISE_RAD * np.sin(2 * np.pi * f * time)[:, None] for f in (5.5, 1.0))
    told, kept = (rms_beyond_noise(noise + r, variance, np.zeros_like(noise), FRAME_S) for r in (swings, slow))
    assert told.max() < 0.3 * NOISE_RAD
    np.testing.assert_allclose(kept, NOISE_RAD, rtol=0.15)
    assert residual_rate(noise + swings, alpha, time)[0].max() < 0.2 * residual_rate(noise + slow, alpha, time)[0].min()


def test_what_follows_the_pose_does_not_last_and_what_drifts_does() -> None:
    time, alpha = lively()
    drift = np.radians(0.05) * (time / 30 - 1)[:, None] * np.ones(3)
    assert lasting_rms(0.01 * alpha, time).max() < 0.4 * 0.01 * np.sqrt(np.mean(alpha**2))
    np.testing.assert_allclose(lasting_rms(drift, time), np.sqrt(np.mean(drift**2)), rtol=0.4)


def test_how_fast_residuals_change_is_told_beside_noise() -> None:
    """A residual of 2 % of the second joint's angle, in noise that is larger than it changes from frame to frame."""
    rng, (time, alpha) = np.random.default_rng(5), lively()
    noise = NOISE_RAD * rng.standard_normal(alpha.shape)
    rate, slope = residual_rate(noise + np.array([0.0, 0.02, 0.0]) * alpha, alpha, time)
    own = 0.02 * np.sqrt(np.mean(np.gradient(alpha[:, 1], time) ** 2))
    path = np.sqrt(np.mean(np.sum(np.gradient(alpha, time, axis=0) ** 2, axis=1)))
    assert own < rate[1] < 2 * own  # there may be as much again that frames do not tell
    assert slope[1] == pytest.approx(rate[1] / path, rel=0.05)
    assert max(rate[0], rate[2]) < rate[1] / 2


def test_a_residual_that_jumps_where_a_joint_turns_round_is_told_whole() -> None:
    """As play leaves it: 0.1 deg to the one side and the other, crossed in 0.08 s, in noise of 0.05 deg; noise alone is none."""
    rng, (time, alpha) = np.random.default_rng(6), lively()
    noise = np.radians(0.05) * rng.standard_normal(alpha.shape)
    fine = np.arange(0, 60, 1e-3)
    at = 0.4 * np.sin(2 * np.pi * np.array([0.31, 0.43, 0.37]) * fine[:, None] + np.arange(3))
    sides = np.radians(0.1) * np.sign(np.gradient(at, fine, axis=0))
    jumps = np.stack([np.convolve(column, np.ones(80) / 80, "same") for column in sides.T], axis=-1)
    true = np.sqrt(np.mean(np.gradient(jumps, fine, axis=0)[100:-100] ** 2, axis=0))
    seen = noise + np.stack([np.interp(time, fine, column) for column in jumps.T], axis=-1)
    rate, _ = residual_rate(seen, alpha, time)
    np.testing.assert_allclose(rate, true, rtol=0.3)
    assert residual_rate(noise, alpha, time)[0].max() < rate.min() / 2


def test_markers_that_sit_askew_do_not_change_the_stiffness() -> None:
    """Joints that are seen 0.5 deg and more beside where they stand: as much is found, and cables come out as they were."""
    of, (data, _) = case(SEED, calibrated=False), calibration_data(SEED)
    askew = np.radians([0.6, -0.8, 0.5])

    def seen(series: Series) -> Series:
        moved = {f"alpha{i + 1}": series.columns[f"alpha{i + 1}"] + askew[i] for i in range(3)}
        return Series(series.time, {**series.columns, **moved})

    there = calibrate_pose([data], of.model)
    pose = calibrate_pose([replace(data, angles=seen(data.angles), state=seen(data.state))], of.model)
    np.testing.assert_allclose(values(pose, "k"), values(there, "k"), rtol=5e-3)
    sigma = np.array([n.sigma for n in pose.numbers if n.kind == "markers"])
    offset = values(pose, "marker_offset") - values(there, "marker_offset")
    assert np.all(np.abs(offset - askew) < 3 * sigma)
    np.testing.assert_allclose(marker_offsets(pose, 3), values(pose, "marker_offset"))


def test_the_clock_is_held_as_well_as_sync_knows_it() -> None:
    data = calibration_data(SEED)[0]
    told = rows_of(replace(data, clock={"offset_s": 0.0, "offset_sigma_s": 1e-4, "skew_sigma_ppm": 2.0}))
    assert (told.clock_sigma, told.skew_sigma) == (1e-4, pytest.approx(2e-6))
    untold = rows_of(replace(data, clock={"offset_s": 0.0}))
    assert untold.clock_sigma >= 1e-3
    assert untold.skew_sigma >= 1e-5


def test_speeds_of_motors_that_no_frame_shows_move_no_predicted_angle() -> None:
    """A motor that shakes at 12 Hz stretches no cable as far as frames tell; one that goes at 1 Hz does, by its damping."""
    of, (data, _) = case(SEED), calibration_data(SEED)
    rows = rows_of(data)
    moved = []
    for rate in (None, 12.0, 1.0):
        shaken = rows.theta_d + (0.0 if rate is None else 20 * np.sin(2 * np.pi * rate * rows.time)[:, None])
        shaken_rows = [replace(rows, theta_d=shaken)]
        equations = PoseEquations(of.neck, of.model, shaken_rows, sought_numbers(of.neck, of.model, shaken_rows))
        start = np.zeros(len(equations.numbers))
        moved.append(equations.misfit(start, 0, equations.compliance(start, 0)).angles)
    fast, slow = (np.nanstd(angles - moved[0]) for angles in moved[1:])
    assert fast < 0.02 * slow
