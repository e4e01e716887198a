from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from calibration.camera import Camera, camera_from
from calibration.camera_file import read_camera, write_camera
from tests.calibration.truth import CAMERA, SIZE, project
from xneck_foundation.errors import Refused

ROS = """\
image_width: 640
image_height: 480
camera_name: narrow_stereo
camera_matrix:
  rows: 3
  cols: 3
  data: [500.5, 0., 320.25, 0, 501, 240, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.2, 5.0e-02, 1.0e-05, 0, 0]
rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}
projection_matrix: {rows: 3, cols: 4, data: [500, 0, 320, 0, 0, 500, 240, 0, 0, 0, 1, 0]}
"""


def example() -> Camera:
    root = np.random.default_rng(0).normal(size=(9, 9)) * 1e-5
    info = {
        "rms_px": 0.1,
        "corners": 40,
        "notes": ['a "quoted": word', "tilt µ°"],
        "pictures": [{"file": "a, b.png", "used": False, "why": "x: y # z"}],
    }
    parameters = CAMERA.copy()
    parameters[7] = 5e-05
    return camera_from(parameters, SIZE, covariance=root @ root.T, name="bench", info=info)


def test_round_trip_is_exact(tmp_path: Path):
    camera = example()
    write_camera(camera, tmp_path / "camera.yaml")
    again = read_camera(tmp_path / "camera.yaml")
    np.testing.assert_array_equal(again.parameters, camera.parameters)
    assert camera.covariance is not None
    np.testing.assert_array_equal(again.covariance, camera.covariance)
    assert (again.size, again.name, again.info) == (camera.size, camera.name, camera.info)


def test_other_programs_read_it(tmp_path: Path):
    path = tmp_path / "camera.yaml"
    write_camera(example(), path)
    ros = yaml.safe_load(path.read_text())  # what ROS's camera_info_manager_py does
    assert ros["distortion_model"] == "plumb_bob"
    for key, shape in (
        ("camera_matrix", (3, 3)),
        ("distortion_coefficients", (1, 5)),
        ("rectification_matrix", (3, 3)),
        ("projection_matrix", (3, 4)),
    ):
        assert (ros[key]["rows"], ros[key]["cols"]) == shape
        assert all(type(value) is float for value in ros[key]["data"]), "5e-05 is text to YAML 1.1"
        assert len(ros[key]["data"]) == shape[0] * shape[1]
    assert set(ros) - {"xneck"} == {*yaml.safe_load(ROS)}
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    data = storage.getNode("camera_matrix").getNode("data")
    np.testing.assert_array_equal([data.at(i).real() for i in (0, 2, 4, 5)], CAMERA[[0, 2, 1, 3]])
    assert storage.getNode("image_width").real() == 640


def test_a_plain_ros_file_is_welcome(tmp_path: Path):
    (tmp_path / "ros.yaml").write_text(ROS)
    camera = read_camera(tmp_path / "ros.yaml")
    np.testing.assert_array_equal(camera.parameters, [500.5, 501, 320.25, 240, -0.2, 0.05, 1e-5, 0, 0])
    assert camera.covariance is None


def test_four_coefficients_are_five_with_a_zero(tmp_path: Path):
    (tmp_path / "ros.yaml").write_text(ROS.replace("1.0e-05, 0, 0]", "1.0e-05, 0]"))
    np.testing.assert_array_equal(read_camera(tmp_path / "ros.yaml").distortion, [-0.2, 0.05, 1e-5, 0, 0])


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("image_width: 640\n", "", "image_width: missing"),
        ("plumb_bob", "equidistant", "distortion_model: equidistant is not read; calibrate with plumb_bob"),
        ("plumb_bob", "pinhole", "unknown model 'pinhole'"),
        ("1.0e-05, 0, 0]", "1.0e-05, 0, 0, 1, 1, 1]", "expected 4 or 5 of them .* found 8"),
        ("500.5, 0.,", "4.2, 0.,", r"camera_matrix.data\[0\]: a focal length of 4.2 px, expected pixels, not mm"),
        ("500.5, 0.,", "500.5, 3.,", "a skewed camera"),
        ("320.25", "3202.5", r"camera_matrix.data\[2\]: the optical axis at 3202.5 px of 640"),
        ("500.5, 0.,", "500.5,", "expected 3 x 3, found 3 x 3 with 8"),
        ("500.5", ".nan", "finite number"),
        ("500.5", "abc", "valid number"),
        ("camera_name", "camera_nmae", "camera_nmae: unknown key"),
        ("image_height: 480\n", "image_height: 480\nbinning_x: 2\n", "binning_x"),
        (
            "rectification",
            "xneck: {format: 1, covariance: [[1.0]]}\nrectification",
            "xneck.covariance: expected 9 rows",
        ),
        ("rectification", "xneck: {format: 2}\nrectification", "xneck.format"),
    ],
)
def test_refuses(tmp_path: Path, old: str, new: str, says: str):
    assert old in ROS
    (tmp_path / "bad.yaml").write_text(ROS.replace(old, new, 1))
    with pytest.raises(Refused, match=says):
        read_camera(tmp_path / "bad.yaml")


def test_project_and_undistort(tmp_path: Path):
    camera = example()
    points = np.random.default_rng(2).uniform(-0.1, 0.1, (20, 3))
    rvec, tvec = np.array([0.3, -0.2, 1.0]), np.array([0.02, -0.03, 0.5])
    R = cv2.Rodrigues(rvec)[0]
    pixels = camera.project(points, rvec, tvec)
    np.testing.assert_allclose(pixels, project(points, R, tvec, camera.parameters), atol=1e-9)
    seen = points @ R.T + tvec
    np.testing.assert_allclose(camera.rays(pixels), seen[:, :2] / seen[:, 2:], atol=1e-10)
    pinhole = seen @ camera.K.T
    np.testing.assert_allclose(camera.undistort(pixels), pinhole[:, :2] / pinhole[:, 2:], atol=1e-7)


def test_points_behind_the_camera_have_no_pixels():
    assert np.all(np.isnan(example().project(np.zeros((1, 3)), np.zeros(3), np.array([0.0, 0.0, -1.0]))))
