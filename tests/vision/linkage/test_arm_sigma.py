"""What the camera does to joint angles: predicted, and found by measuring the same arm through many wrong cameras."""

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import least_squares

from calibration.board import Chessboard
from calibration.camera import camera_from
from calibration.estimation import calibrate
from calibration.observations import Observations
from mechanism.description import read_neck
from tests.calibration.truth import CAMERA, SIZE, synthetic_views
from tests.paths import NECK_FILE
from vision.linkage.arm_sigma import BENDS_RAD, PlanarArm, arm_sigma, marker_arm, two_link_arm
from xneck_foundation.errors import Refused

NECK = NECK_FILE
CORNERS = Chessboard(kind="chessboard", columns=8, rows=6, square=0.025).corners
DRAWS = 120
SPREAD = 3.5 / np.sqrt(2 * DRAWS)
"""relative: a standard deviation of DRAWS draws is known to 1 / sqrt(2 DRAWS)"""


def pixels(p: np.ndarray, rvec: np.ndarray, tvec: np.ndarray, plane: NDArray[np.complex128]) -> np.ndarray:
    """Points of the arm's plane (complex, y up) as OpenCV's camera sees them, (n, 2), px."""
    points = np.column_stack([plane.real, -plane.imag, np.zeros(plane.size)])
    K = np.array([[p[0], 0, p[2]], [0, p[1], p[3]], [0, 0, 1.0]])
    return cv2.projectPoints(points, rvec, tvec, K, p[4:])[0].reshape(-1, 2)


def measured(arm: PlanarArm, true: np.ndarray, believed: np.ndarray, distance: float) -> np.ndarray:
    """Angles in each bend as somebody finds them who believes in another camera, pose fitted too; (bends * joints,)."""
    alpha = np.array(BENDS_RAD)[:, None] * np.ones(arm.joints)
    plane = arm.points(alpha).ravel()
    middle = complex(plane.real.min() + plane.real.max(), plane.imag.min() + plane.imag.max()) / 2
    at_middle = (np.array([319.5, 239.5]) - true[2:4]) / true[:2] * distance
    t = np.array([at_middle[0], at_middle[1], distance])
    seen = pixels(true, np.zeros(3), t, plane - middle)

    def left(x: np.ndarray) -> np.ndarray:
        bent = arm.points(x[6:].reshape(alpha.shape)).ravel() - middle
        return (pixels(believed, x[:3], x[3:6], bent) - seen).ravel()

    return least_squares(left, np.concatenate([np.zeros(3), t, alpha.ravel()]), method="lm").x[6:]


@pytest.mark.parametrize(
    ("arm", "distance"),
    [(two_link_arm(0.18), 0.45), (marker_arm(read_neck(NECK), "neck.yaml"), 0.5)],
    ids=["links", "neck"],
)
def test_the_spread_of_angles_is_the_one_predicted(arm: PlanarArm, distance: float):
    unsure = calibrate(Observations(tuple(synthetic_views(np.random.default_rng(0), CORNERS, 15)), (), SIZE)).camera
    assert unsure.covariance is not None
    found = arm_sigma(unsure, arm, distance)
    rng = np.random.default_rng(1)
    drawn = rng.multivariate_normal(unsure.parameters, unsure.covariance, size=DRAWS, method="eigh")
    angles = np.array([measured(arm, unsure.parameters, p, distance) for p in drawn])
    spread = np.sqrt(np.mean((angles - np.repeat(BENDS_RAD, arm.joints)) ** 2, axis=0))
    np.testing.assert_allclose(spread, found.alpha.ravel(), rtol=SPREAD)
    bends = (angles.reshape(DRAWS, 3, -1) - angles.reshape(DRAWS, 3, -1)[:, :1])[:, 1:]
    bends -= np.array(BENDS_RAD)[1:, None]
    np.testing.assert_allclose(np.sqrt(np.mean(bends**2, axis=0)), found.bend, rtol=SPREAD)


def test_calibrations_are_off_by_what_they_say():
    """The whole chain: angles through 12 cameras, each calibrated anew, against the true one."""
    ratio = []
    for seed in range(12):
        views = synthetic_views(np.random.default_rng(seed), CORNERS, 15)
        camera = calibrate(Observations(tuple(views), (), SIZE)).camera
        error = measured(two_link_arm(0.18), CAMERA, camera.parameters, 0.45) - BENDS_RAD
        ratio.append(error / arm_sigma(camera, two_link_arm(0.18), 0.45).alpha.ravel())
    # the three angles of a camera go together: 12 draws, and the jackknife's larger sigma is on the safe side
    assert 0.4 < float(np.sqrt(np.mean(np.square(ratio)))) < 1.6


def test_a_larger_picture_of_the_arm_feels_more_of_the_lens():
    """Far away the lens is a straight map, and a pose absorbs that; what remains grows with the square of the size."""
    middle = np.array([620.0, 620.0, 319.5, 239.5, 0, 0, 0, 0, 0])
    camera = camera_from(middle, SIZE, covariance=np.diag([0, 0, 0, 0, 1e-4, 0, 0, 0, 0.0]))
    near, far = (arm_sigma(camera, two_link_arm(0.18), d).worst_alpha for d in (0.5, 2.0))
    assert near / far == pytest.approx(16, rel=0.02)


def test_without_a_distance_it_fills_the_picture():
    camera = camera_from(CAMERA, SIZE, covariance=np.diag([1.0, 1.0, 0, 0, 1e-6, 0, 0, 0, 0]))
    found = arm_sigma(camera, marker_arm(read_neck(NECK), "neck.yaml"))
    assert np.ptp(found.pixels.reshape(-1, 2), axis=0).max() / np.array(SIZE)[1] > 0.8
    assert np.all((found.pixels >= -0.5) & (found.pixels <= np.array(SIZE) - 0.5))
    assert found.mm * found.px_per_mm == pytest.approx(found.px)
    assert found.px_per_mm == pytest.approx(621 / found.distance / 1e3, rel=1e-3)


def test_an_arm_too_near_is_refused():
    with pytest.raises(Refused, match=r"distance: at 0\.1 m the arm .* does not fit"):
        arm_sigma(camera_from(CAMERA, SIZE), two_link_arm(0.18), 0.1)


def test_an_arm_without_markers_is_refused():
    with pytest.raises(Refused, match="has no `markers`"):
        marker_arm(read_neck(NECK).model_copy(update={"markers": None}), "neck.yaml")
