import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from calibration import lens
from tests.calibration.truth import CAMERA, project

RAYS = np.random.default_rng(1).uniform(-0.5, 0.5, (50, 2))
P = CAMERA + np.array([0, 0, 0, 0, 0, 0, 0, 0, 0.03])


def test_distort_agrees_with_opencv_and_with_the_definition():
    K = np.array([[P[0], 0, P[2]], [0, P[1], P[3]], [0, 0, 1]])
    points = np.column_stack([RAYS, np.ones(50)])
    peer, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), K, P[4:])
    np.testing.assert_allclose(lens.rays_to_pixels(RAYS, P), np.reshape(peer, (-1, 2)), atol=1e-9)
    np.testing.assert_allclose(lens.rays_to_pixels(RAYS, P), project(points, np.eye(3), np.zeros(3), P), atol=1e-9)


def test_jacobians_are_finite_differences():
    by_ray, by_parameter = lens.ray_jacobian(RAYS, P), lens.parameter_jacobian(RAYS, P)
    for i in range(2):
        h = 1e-6 * np.eye(2)[i]
        numeric = (lens.rays_to_pixels(RAYS + h, P) - lens.rays_to_pixels(RAYS - h, P)) / 2e-6
        np.testing.assert_allclose(by_ray[:, :, i], numeric, atol=1e-5)
    for i in range(9):
        h = 1e-5 * np.eye(9)[i]
        numeric = (lens.rays_to_pixels(RAYS, P + h) - lens.rays_to_pixels(RAYS, P - h)) / 2e-5
        np.testing.assert_allclose(by_parameter[:, :, i], numeric, atol=1e-5)


@given(
    st.floats(-0.4, 0.4),
    st.floats(-0.2, 0.2),
    st.floats(-0.003, 0.003),
    st.floats(-0.003, 0.003),
    st.floats(-0.55, 0.55),
    st.floats(-0.4, 0.4),
)
def test_undistort_inverts_distort_wherever_the_model_has_not_turned_back(k1, k2, p1, p2, x, y):
    p = np.array([600.0, 610.0, 320.0, 240.0, k1, k2, p1, p2, 0.0])
    ray = np.array([[x, y]])
    # near the turning point the inverse exists but is ill-conditioned
    if np.linalg.det(lens.ray_jacobian(1.1 * ray, p))[0] > 0.1 * 600 * 610 and lens.is_invertible(1.1 * ray, p)[0]:
        np.testing.assert_allclose(lens.pixels_to_rays(lens.rays_to_pixels(ray, p), p), ray, atol=1e-8)


def test_beyond_the_turning_point_there_is_no_answer():
    barrel = np.array([500.0, 500.0, 320.0, 240.0, -0.4, 0.0, 0.0, 0.0, 0.0])  # turns back at r = 0.913, 304 px
    inside, outside = lens.pixels_to_rays(np.array([[320.0 + 300.0, 240.0], [320.0 + 306.0, 240.0]]), barrel)
    assert np.all(np.isfinite(inside))
    assert np.all(np.isnan(outside))
    # a model that turns back and out again: the second way out is no answer either
    twice = np.array([500.0, 500.0, 320.0, 240.0, -0.9, 0.3, 0.0, 0.0, 0.0])
    beyond = lens.rays_to_pixels(np.array([[2.0, 0.0]]), twice)
    assert np.all(np.isnan(lens.pixels_to_rays(beyond, twice)))


def test_better_than_opencvs_default_iterations():
    strong = np.array([600.0, 600.0, 320.0, 240.0, -0.35, 0.12, 0.0, 0.0, 0.0])
    pixels = lens.rays_to_pixels(RAYS, strong)
    K = np.array([[600.0, 0, 320], [0, 600, 240], [0, 0, 1]])
    peer = cv2.undistortPoints(pixels.reshape(-1, 1, 2), K, strong[4:]).reshape(-1, 2)
    mine = np.abs(lens.pixels_to_rays(pixels, strong) - RAYS).max()
    assert mine < 1e-10
    assert mine < np.abs(peer - RAYS).max()


def test_rendering_and_estimating_share_the_pixel_convention():
    assert lens.rays_to_pixels(np.zeros((1, 2)), P)[0] == pytest.approx(P[2:4])


@pytest.mark.parametrize(("column", "power"), [(4, 2), (5, 4), (8, 6)])
@pytest.mark.parametrize("size", [0.2, 0.6])
def test_each_coefficient_folds_the_picture_back_where_its_slope_ends(column: int, power: int, size: float) -> None:
    """r (1 - c r^n) rises until (n + 1) c r^n = 1, by hand; just within there is an inverse, just beyond there is none."""
    p = np.array([900.0, 900.0, 640.0, 360.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    p[column] = -size
    fold = (1 / ((power + 1) * size)) ** (1 / power)
    turned = np.array([np.cos(1.0), np.sin(1.0)])
    assert lens.is_invertible(0.99 * fold * turned[None], p)[0]
    assert not lens.is_invertible(1.01 * fold * turned[None], p)[0]
