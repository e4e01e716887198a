"""What a camera's covariance means: the part that what is estimated through the camera cannot absorb."""

import cv2
import numpy as np
import pytest

from calibration.camera import Camera, camera_from
from calibration.projection_uncertainty import (
    board_information,
    projection_sigma,
    propagate_covariance,
    rays_by_pose,
    rays_by_rotation,
)
from tests.calibration.truth import CAMERA, SIZE, project


def camera(sigma: dict[int, float], parameters: np.ndarray = CAMERA) -> Camera:
    """Known but for independent errors of some of the nine parameters."""
    covariance = np.zeros((9, 9))
    for index, value in sigma.items():
        covariance[index, index] = value**2
    return camera_from(parameters, SIZE, covariance=covariance)


def facing() -> np.ndarray:
    """A plate at 1 m that fills the middle of the picture, points in the camera frame, (n, 3), m."""
    x, y = np.meshgrid(np.linspace(-0.35, 0.35, 9), np.linspace(-0.25, 0.25, 7))
    return np.column_stack([x.ravel(), y.ravel(), np.ones(x.size)])


def test_jacobians_are_those_of_moved_points():
    points = facing() + np.random.default_rng(0).normal(scale=0.05, size=(63, 3))
    rays = points[:, :2] / points[:, 2:]
    for k in range(6):
        step = 1e-6 * np.eye(6)[k]
        moved = [(points @ cv2.Rodrigues(s[:3])[0].T + s[3:]) for s in (step, -step)]
        numeric = (moved[0][:, :2] / moved[0][:, 2:] - moved[1][:, :2] / moved[1][:, 2:]) / 2e-6
        np.testing.assert_allclose(rays_by_pose(points)[:, :, k], numeric, atol=1e-8)
    np.testing.assert_array_equal(rays_by_pose(points)[:, :, :3], rays_by_rotation(rays))


def test_a_facing_plate_does_not_feel_the_focal_length_but_directions_do():
    """Its distance absorbs a focal length that is wrong; nothing absorbs one in the angle between two directions."""
    plain = np.array([620.0, 620.0, 319.5, 239.5, 0, 0, 0, 0, 0])
    both = np.zeros((9, 9))
    both[:2, :2] = 1.0  # fx and fy wrong by the same pixel
    unsure = camera_from(plain, SIZE, covariance=both)
    points = facing()
    found = propagate_covariance(unsure, points[:, :2], rays_by_pose(points))
    assert found.sigma.max() < 1e-6
    assert np.sqrt(found.covariance[5, 5]) == pytest.approx(1 / 620, rel=1e-6), "distance wrong by the same share"
    # at the picture's corner the ray leans by 400 px / 620 px; a turn about the axes absorbs nothing of a radial error
    corner = projection_sigma(unsure).sigma[0, 0]
    assert corner == pytest.approx(np.hypot(319.5, 239.5) / 620, rel=0.01)


def test_a_moved_axis_is_mostly_a_turned_camera():
    moved = projection_sigma(camera({2: 1.0}))
    assert moved.median < 0.12, "of the pixel by which the axis is unsure"
    assert moved.worst < 0.5


def test_directions_bound_every_body():
    unsure = camera({0: 1.0, 1: 1.3, 2: 2.0, 3: 1.5, 4: 0.004, 5: 0.01, 6: 3e-4, 7: 2e-4})
    rng = np.random.default_rng(1)
    for tilt in (0.0, 0.3, 0.6):
        points = facing() @ cv2.Rodrigues(np.array([tilt, 0.2, 0.0]))[0].T + rng.normal(scale=0.02, size=3)
        rays = points[:, :2] / points[:, 2:]
        body = propagate_covariance(unsure, rays, rays_by_pose(points)).sigma
        turn = propagate_covariance(unsure, rays, rays_by_rotation(rays)).sigma
        assert np.sqrt(np.mean(body**2)) < np.sqrt(np.mean(turn**2))


def test_the_map_names_where_it_is_worst_and_knows_no_lens_that_turns_back():
    # a tangential error that a covariance couples with the axis is largest on one side
    root = np.zeros((9, 1))
    root[[4, 6, 7], 0] = 0.01, 0.004, 0.004
    found = projection_sigma(camera_from(CAMERA, SIZE, covariance=root @ root.T))
    row, column = np.unravel_index(np.nanargmax(found.sigma), found.sigma.shape)
    vertical = ("upper", "middle", "lower")[3 * int(row) // found.sigma.shape[0]]
    assert found.worst_place == f"{vertical} {('left', 'middle', 'right')[3 * int(column) // found.sigma.shape[1]]}"
    wild = CAMERA.copy()
    wild[4:6] = -0.9, 0.0
    assert np.isnan(projection_sigma(camera({4: 0.01}, wild)).sigma[0, 0])


def test_exactly_known_is_zero():
    assert projection_sigma(camera_from(CAMERA, SIZE)).worst == 0.0


def test_information_is_what_a_free_pose_leaves():
    """Against a dense least squares of camera and pose together, its derivatives by differences of the tests' camera."""
    rng = np.random.default_rng(3)
    board = np.column_stack([rng.uniform(-0.1, 0.1, (20, 2)), np.zeros(20)])
    R, t = cv2.Rodrigues(np.array([0.4, -0.3, 0.2]))[0], np.array([0.03, -0.02, 0.4])

    def pixels(step: np.ndarray) -> np.ndarray:
        return project(board, cv2.Rodrigues(step[9:12])[0] @ R, t + step[12:], CAMERA + step[:9]).ravel()

    sizes = np.array([1e-3] * 4 + [1e-6] * 11)
    J = np.stack([(pixels(s) - pixels(-s)) / (2 * size) for s, size in zip(np.diag(sizes), sizes, strict=True)], axis=1)
    A, B = J[:, :9], J[:, 9:]
    expected = A.T @ A - A.T @ B @ np.linalg.solve(B.T @ B, B.T @ A)
    found = board_information(camera_from(CAMERA, SIZE), board @ R.T + t)
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    np.testing.assert_allclose(found / scale, expected / scale, atol=1e-5)
