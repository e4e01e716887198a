"""One fit for all: exact derivatives, recovery, and the same numbers as OpenCV's where OpenCV can follow."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from calibration import board_shape, lens
from calibration.board import Chessboard
from calibration.board_poses import BoardPoses
from calibration.bundle_adjustment import (
    DEFAULT_FREE_PARAMETERS,
    BundleStart,
    fit_bundle,
    fit_noise,
    initial_estimate,
    leave_out_groups,
    prediction_distances,
)
from calibration.bundle_problem import BundleProblem
from calibration.corner_detection import BoardView
from calibration.reprojection import huber_loss
from calibration.stacked_views import stack_views
from tests.calibration.truth import CAMERA, SIZE, bowed, synthetic_views

CORNERS = Chessboard(kind="chessboard", columns=9, rows=6, square=0.025).corners


def partly(views: list[BoardView], rng: np.random.Generator) -> list[BoardView]:
    """Each view without some of its corners."""
    some = []
    for view in views:
        keep = np.sort(rng.permutation(len(view.corner_ids))[: rng.integers(30, 50)])
        some.append(
            replace(
                view,
                image_points=view.image_points[keep],
                object_points=view.object_points[keep],
                corner_ids=view.corner_ids[keep],
            )
        )
    return some


@pytest.mark.parametrize("model", ["bowed, aspect", "free"])
def test_normal_equations_are_those_of_finite_differences(model: str):
    rng = np.random.default_rng(3)
    seen = stack_views(partly(synthetic_views(rng, CORNERS, 2), rng))
    poses = BoardPoses(
        np.stack([cv2.Rodrigues(rng.normal(scale=0.3, size=3))[0] for _ in range(2)]),
        np.array([[0.02, 0.01, 0.5], [-0.1, 0.0, 0.7]]),
    )
    problem = BundleProblem(seen, lens.PARAMETER_NAMES, board_shape.SHAPE_MODELS[model], None)
    shape = replace(board_shape.flat_board(seen.ids, seen.nominal), model=board_shape.SHAPE_MODELS[model])
    shape = replace(shape, values=np.array([3e-4, -2e-4, 0.01]))
    normal = problem.normal(CAMERA, shape, poses, problem.residuals(CAMERA, shape.points, poses))
    numbers = 9 + len(shape.model.free) + (shape.offsets.size if shape.model.offsets else 0)

    def residuals(step: np.ndarray, view: int) -> np.ndarray:
        p, moved = problem.moved(CAMERA, shape, step[:numbers])
        turn = cv2.Rodrigues(step[numbers : numbers + 3])[0]
        at = BoardPoses(turn @ poses.R, poses.t + step[numbers + 3 :])
        return problem.residuals(p, moved.points, at)[view].ravel()

    size = np.concatenate([np.full(9, 1e-5), np.full(numbers - 9, 1e-6), np.full(6, 1e-6)])
    for view in range(2):
        steps = np.diag(size)
        J = np.stack(
            [(residuals(d, view) - residuals(-d, view)) / (2 * h) for d, h in zip(steps, size, strict=True)], 1
        )
        r = residuals(np.zeros(len(size)), view)
        numeric = np.column_stack([J, r]).T @ np.column_stack([J, r])
        dense = [*range(9 + len(shape.model.free)), *range(numbers, numbers + 7)]
        mine = normal.products[view]
        scale = np.sqrt(np.outer(np.diag(mine), np.diag(mine))) + 1e-12
        np.testing.assert_allclose(mine / scale, numeric[np.ix_(dense, dense)] / scale, atol=1e-6)
        if normal.by_offset is not None and normal.offset_squares is not None:
            own = numeric[9:numbers][:, dense].reshape(-1, 3, len(dense))
            np.testing.assert_allclose(normal.by_offset[view], own, atol=1e-5 * np.abs(own).max())
            for corner, block in enumerate(normal.offset_squares[view]):
                at = slice(9 + 3 * corner, 12 + 3 * corner)
                np.testing.assert_allclose(block, numeric[at, at], rtol=1e-4, atol=1e-5 * np.abs(own).max())


def test_poses_are_eliminated_exactly():
    # the step of the Schur complement is that of all unknowns at once
    seen = stack_views(synthetic_views(np.random.default_rng(7), CORNERS, 3))
    poses = initial_estimate(seen, SIZE).poses
    model = board_shape.SHAPE_MODELS["bowed"]
    problem = BundleProblem(seen, DEFAULT_FREE_PARAMETERS, model, None)
    shape = replace(board_shape.flat_board(seen.ids, seen.nominal), model=model)
    normal = problem.normal(CAMERA, shape, poses, problem.residuals(CAMERA, shape.points, poses))
    m = 10
    H, g = np.zeros((m + 18, m + 18)), np.zeros(m + 18)
    for i, block in enumerate(normal.products):
        at = [*range(m), *range(m + 6 * i, m + 6 * i + 6)]
        H[np.ix_(at, at)] += block[: m + 6, : m + 6]
        g[at] += block[: m + 6, -1]
    scale = np.sqrt(np.diag(H))
    whole = -np.linalg.solve(H / np.outer(scale, scale), g / scale) / scale
    step, pose_steps = normal.step(0.0)
    np.testing.assert_allclose(step * scale[:m], whole[:m] * scale[:m], rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(pose_steps.ravel() * scale[m:], whole[m:] * scale[m:], rtol=1e-5, atol=1e-6)


def test_perfect_data_give_the_truth_from_a_wrong_start():
    views = synthetic_views(np.random.default_rng(4), CORNERS, 8, noise_px=0.0)
    start = initial_estimate(stack_views(views), SIZE)
    parameters, poses = start.parameters, start.poses
    wrong = parameters * np.array([1.2, 1.2, 1.05, 0.95, 0.0, 0.0, 0.0, 0.0, 0.0])
    fitted = fit_bundle(stack_views(views), BundleStart(wrong, poses))
    assert fitted.converged
    assert fitted.rms < 1e-6
    np.testing.assert_allclose(fitted.parameters, CAMERA, rtol=1e-5, atol=1e-6)


def test_agrees_with_opencv_in_value_and_sigma():
    views = synthetic_views(np.random.default_rng(5), CORNERS, 12, noise_px=0.2)
    fitted = fit_bundle(stack_views(views), initial_estimate(stack_views(views), SIZE))
    rms, K, d, _, _, sigma, _, each = cv2.calibrateCameraExtended(
        [view.object_points.astype(np.float32) for view in views],
        [view.image_points.astype(np.float32).reshape(-1, 1, 2) for view in views],
        SIZE,
        np.zeros((3, 3)),
        np.zeros(5),
        flags=cv2.CALIB_FIX_K3,
    )
    peer = np.array([K[0, 0], K[1, 1], K[0, 2], K[1, 2], *np.ravel(d)])
    spread = np.ravel(sigma)[:9]
    assert abs(fitted.rms - rms) < 1e-5
    np.testing.assert_allclose(fitted.rms_views, np.ravel(each), atol=1e-3)
    free = [lens.PARAMETER_NAMES.index(name) for name in DEFAULT_FREE_PARAMETERS]
    assert np.all(np.abs(fitted.parameters - peer)[free] < 0.01 * spread[free])
    np.testing.assert_allclose(np.sqrt(np.diag(fitted.covariance))[free], spread[free], rtol=0.01)


def test_with_nothing_free_only_poses_move():
    seen = stack_views(synthetic_views(np.random.default_rng(6), CORNERS, 2, noise_px=0.0))
    poses = initial_estimate(seen, SIZE).poses
    moved = BoardPoses(poses.R, poses.t + 0.01)
    fitted = fit_bundle(seen, BundleStart(CAMERA, moved), ())
    np.testing.assert_array_equal(fitted.parameters, CAMERA)
    assert fitted.rms < 1e-6
    distances = prediction_distances(seen, np.tile(CAMERA, (2, 1)), np.tile(CORNERS, (2, 1, 1)), moved, steps=8)
    assert distances.max() < 1e-6, "the same for each view by itself"


@pytest.mark.parametrize("model", ["rigid", "bowed", "free"])
def test_leaving_out_a_view_by_one_step_is_as_good_as_fitting_anew(model: str):
    seen = stack_views(synthetic_views(np.random.default_rng(8), CORNERS, 10, shape=bowed(CORNERS, 0.0005)))
    whole = fit_bundle(seen, initial_estimate(seen, SIZE))
    whole = fit_bundle(
        seen, BundleStart(whole.parameters, whole.poses), shape_model=board_shape.SHAPE_MODELS[model], noise=0.1
    )
    quick = leave_out_groups(whole, [np.array([i]) for i in range(10)])
    moved, missed = [], []
    for i, (p, _) in enumerate(quick):
        rest = np.delete(np.arange(10), i)
        anew = fit_bundle(
            seen.of(rest),
            BundleStart(whole.parameters, whole.poses.of(rest), whole.shape),
            whole.free,
            whole.shape.model,
            noise=0.1,
        )
        moved.append((anew.parameters - whole.parameters)[:8])
        missed.append((anew.parameters - p)[:8])
    # a jackknife of ten views is itself known to 1/sqrt(2 * 9), a quarter
    assert np.all(np.std(missed, axis=0) < 0.2 * np.std(moved, axis=0))


def test_a_bad_corner_does_not_bend_the_camera():
    shifts = {"plain": [], "robust": [], "sigma": []}
    for seed in range(6):
        views = synthetic_views(np.random.default_rng(seed), CORNERS, 10)
        clean = fit_bundle(stack_views(views), initial_estimate(stack_views(views), SIZE))
        points = views[2].image_points.copy()
        points[0] += [6.0, -6.0]
        seen = stack_views([*views[:2], replace(views[2], image_points=points), *views[3:]])
        plain = fit_bundle(seen, BundleStart(clean.parameters, clean.poses))
        robust = fit_bundle(seen, BundleStart(clean.parameters, clean.poses), noise=fit_noise(plain))
        sigma = np.sqrt(np.diag(clean.covariance))[:8]
        shifts["plain"].append((plain.parameters - clean.parameters)[:8] / sigma)
        shifts["robust"].append((robust.parameters - clean.parameters)[:8] / sigma)
        shifts["sigma"].append(np.sqrt(np.diag(robust.covariance))[:8] / sigma)
    plain, robust = (float(np.sqrt(np.mean(np.square(shifts[key])))) for key in ("plain", "robust"))
    assert plain > 1.0, "the bad corner matters"
    assert robust < plain / 15, "a knee of 0.3 px for an error of 8.5 px"
    # an 85 sigma corner of 540 makes plain sigma 3 times too large; what is claimed stays what it was without it
    assert np.all(np.abs(np.array(shifts["sigma"]) - 1) < 0.15)


def test_hubers_loss_is_square_then_straight():
    np.testing.assert_allclose(huber_loss(np.array([0.5, 1.0, 3.0]), 1.0), [0.25, 1.0, 5.0])
