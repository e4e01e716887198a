import cv2
import numpy as np

from calibration import lens
from calibration.board import Chessboard
from calibration.bundle import DEFAULT_FREE, Poses, _Problem, fit, start
from tests.calibration.truth import CAMERA, SIZE, synthetic_views

CORNERS = Chessboard(kind="chessboard", columns=9, rows=6, square=0.025).corners


def test_jacobians_are_finite_differences():
    rng = np.random.default_rng(3)
    problem = _Problem(synthetic_views(rng, CORNERS, 2))
    R = np.stack([cv2.Rodrigues(rng.normal(scale=0.3, size=3))[0] for _ in range(2)])
    t = np.array([[0.02, 0.01, 0.5], [-0.1, 0.0, 0.7]])
    columns = np.arange(9)
    A, B = problem.jacobians(CAMERA, R, t, columns)
    h = 1e-6
    for i in range(9):
        d = h * np.eye(9)[i]
        numeric = (problem.residuals(CAMERA + d, R, t) - problem.residuals(CAMERA - d, R, t)) / (2 * h)
        np.testing.assert_allclose(A[:, i], numeric, atol=1e-4)
    for i in range(6):
        d = np.zeros(6)
        d[i] = h
        moved = [
            problem.residuals(CAMERA, np.stack([cv2.Rodrigues(s * d[:3])[0] @ r for r in R]), t + s * d[3:])
            for s in (1, -1)
        ]
        np.testing.assert_allclose(B[:, i], (moved[0] - moved[1]) / (2 * h), atol=2e-3)


def test_perfect_data_give_the_truth_from_a_wrong_start():
    views = synthetic_views(np.random.default_rng(4), CORNERS, 8, noise_px=0.0)
    parameters, poses = start(views, SIZE)
    wrong = parameters * np.array([1.2, 1.2, 1.05, 0.95, 0.0, 0.0, 0.0, 0.0, 0.0])
    fitted = fit(views, wrong, poses)
    assert fitted.converged
    assert fitted.rms < 1e-6
    np.testing.assert_allclose(fitted.parameters, CAMERA, rtol=1e-5, atol=1e-6)


def test_agrees_with_opencv_in_value_and_sigma():
    views = synthetic_views(np.random.default_rng(5), CORNERS, 12, noise_px=0.2)
    fitted = fit(views, *start(views, SIZE))
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
    free = [lens.NAMES.index(name) for name in DEFAULT_FREE]
    assert np.all(np.abs(fitted.parameters - peer)[free] < 0.01 * spread[free])
    np.testing.assert_allclose(np.sqrt(np.diag(fitted.covariance))[free], spread[free], rtol=0.01)


def test_with_nothing_free_only_poses_move():
    views = synthetic_views(np.random.default_rng(6), CORNERS, 2, noise_px=0.0)
    _, poses = start(views, SIZE)
    moved = Poses(poses.R, poses.t + 0.01)
    fitted = fit(views, CAMERA, moved, ())
    np.testing.assert_array_equal(fitted.parameters, CAMERA)
    assert fitted.rms < 1e-6
