"""A camera survives the formats of others, told by content alone; what they cannot carry is refused or said."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from calibration.camera import Camera, camera_from
from calibration.camera_file import export_camera, read_camera
from tests.calibration.truth import CAMERA, DATA, SIZE
from tests.paths import ROOT
from xneck_foundation.errors import Refused

KALIBR = """\
cam0:
  cam_overlaps: []
  camera_model: pinhole
  distortion_coeffs: [-0.29397077, 0.08347676, 0.00029237, -1.2e-05]
  distortion_model: radtan
  intrinsics: [461.629, 460.152, 362.680, 246.049]
  resolution: [752, 480]
  rostopic: /cam0/image_raw
"""


def known() -> Camera:
    root = np.random.default_rng(0).normal(size=(9, 9)) * 1e-3
    covariance = root @ root.T
    covariance[8] = covariance[:, 8] = 0.0
    return camera_from(CAMERA, SIZE, covariance=covariance)


def stored(path: Path, size: dict[str, int | list[int]], K: np.ndarray, d: np.ndarray, **more: int | str) -> None:
    """What a person's own script with cv2.FileStorage leaves at `path`, whose suffix chooses YAML, XML or JSON."""
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for key, value in {**size, **more}.items():
        storage.write(key, np.array(value) if isinstance(value, list) else value)
    storage.write("camera_matrix", K)
    storage.write("distortion_coefficients", d)
    storage.release()


WH: dict[str, int | list[int]] = {"image_width": 640, "image_height": 480}


@pytest.mark.parametrize("suffix", ["yml", "yaml", "xml", "json"])
def test_what_opencv_writes_is_read_whatever_the_name(tmp_path: Path, suffix: str):
    stored(tmp_path / f"c.{suffix}", WH, known().K, CAMERA[4:].reshape(5, 1))
    (tmp_path / "cam.txt").write_bytes((tmp_path / f"c.{suffix}").read_bytes())
    camera = read_camera(tmp_path / "cam.txt")
    np.testing.assert_array_equal(camera.parameters, CAMERA)
    assert camera.size == SIZE
    assert camera.covariance is None


def test_opencv_round_trip_loses_nothing(tmp_path: Path):
    path, lost = export_camera(known(), tmp_path / "camera.yaml", "opencv")
    assert (path.name, lost) == ("camera.opencv.yaml", "")
    again = read_camera(path)
    np.testing.assert_array_equal(again.parameters, CAMERA)
    np.testing.assert_array_equal(again.covariance, known().covariance)
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)  # OpenCV's own reader finds its own names
    np.testing.assert_array_equal(storage.getNode("camera_matrix").mat(), known().K)
    np.testing.assert_array_equal(storage.getNode("distortion_coefficients").mat().ravel(), CAMERA[4:])
    assert (storage.getNode("image_width").real(), storage.getNode("image_height").real()) == SIZE


def test_kalibr_round_trip_says_what_it_loses(tmp_path: Path):
    path, lost = export_camera(known(), tmp_path / "camera.yaml", "kalibr")
    assert "covariance" in lost
    again = read_camera(path)
    np.testing.assert_array_equal(again.parameters, CAMERA)
    assert again.size == SIZE
    cam = yaml.safe_load(path.read_text())["cam0"]  # as Kalibr itself loads it
    assert (cam["camera_model"], cam["distortion_model"]) == ("pinhole", "radtan")
    assert all(type(value) is float for value in cam["intrinsics"] + cam["distortion_coeffs"])


def test_radtan_means_what_plumb_bob_means(tmp_path: Path):
    """Kalibr's own formula (aslam_cv RadialTangentialDistortion): y = y0 + y0 (k1 r + k2 r^2) + 2 p1 ... written out."""
    (tmp_path / "k.yaml").write_text(KALIBR)
    camera = read_camera(tmp_path / "k.yaml")
    mx, my = 0.31, -0.22
    k1, k2, p1, p2 = -0.29397077, 0.08347676, 0.00029237, -1.2e-05
    rho = mx * mx + my * my
    radial = k1 * rho + k2 * rho * rho
    u = 461.629 * (mx + mx * radial + 2 * p1 * mx * my + p2 * (rho + 2 * mx * mx)) + 362.680
    v = 460.152 * (my + my * radial + 2 * p2 * mx * my + p1 * (rho + 2 * my * my)) + 246.049
    seen = camera.project(np.array([[mx, my, 1.0]]), np.zeros(3), np.zeros(3))
    np.testing.assert_allclose(seen, [[u, v]], atol=1e-9)
    assert camera.size == (752, 480)


def test_k3_is_not_dropped_in_silence(tmp_path: Path):
    wild = camera_from(CAMERA + np.eye(9)[8] * -0.4, SIZE)
    with pytest.raises(Refused, match=r"k3 = -0\.4 has no place in Kalibr's radtan; export opencv"):
        export_camera(wild, tmp_path / "camera.yaml", "kalibr")
    assert not list(tmp_path.iterdir())
    path, _ = export_camera(wild, tmp_path / "camera.yaml", "opencv")
    assert read_camera(path).distortion[4] == -0.4


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("radtan", "equidistant", "cam0.distortion_model: 'equidistant' is not read; calibrate with pinhole-radtan"),
        ("pinhole", "omni", "cam0.camera_model: 'omni' is not read"),
        (", -1.2e-05]", "]", "cam0.distortion_coeffs: expected 4, found 3"),
        (", 246.049]", "]", "cam0.intrinsics: expected 4"),
        ("461.629", "4.6", r"cam0.intrinsics\[0\]: a focal length of 4.6 px"),
        ("  rostopic", "  rostopik", "cam0: rostopik: unknown key"),
        ("[752, 480]", "[752]", "resolution"),
        ("  rostopic: /cam0/image_raw\n", "cam1: {}\n", "holds cam0 and cam1; leave one camera"),
    ],
)
def test_kalibr_refusals(tmp_path: Path, old: str, new: str, says: str):
    assert old in KALIBR
    (tmp_path / "bad.yaml").write_text(KALIBR.replace(old, new, 1))
    with pytest.raises(Refused, match=says):
        read_camera(tmp_path / "bad.yaml")


def with_k4(path: Path) -> None:
    stored(path, WH, known().K, np.array([*CAMERA[4:], 0.1, 0.0, 0.2]))


def as_fisheye(path: Path) -> None:
    stored(path, WH, known().K, CAMERA[4:8], fisheye_model=1)


def without_size(path: Path) -> None:
    stored(path, {}, known().K, CAMERA[4:])


def in_mm(path: Path) -> None:
    stored(path, WH, np.diag([4.2, 4.2, 1.0]), CAMERA[4:])


def skewed(path: Path) -> None:
    stored(path, WH, known().K + np.eye(3, k=1), CAMERA[4:])


def unfinished(path: Path) -> None:
    path.write_text("%YAML:1.0\n---\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   data: [ 1.")


def without_columns(path: Path) -> None:
    """cv2.FileNode.mat() writes past its memory here."""
    path.write_text("%YAML:1.0\n---\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   dt: d\n   data: [ 1., 2., 3. ]\n")


def without_matrix(path: Path) -> None:
    path.write_text("%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\n")


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (with_k4, "a lens model with k4, k6 is not read"),
        (as_fisheye, "a fisheye model is not read"),
        (without_size, "image_width, image_height: missing"),
        (in_mm, "a focal length of 4.2 px, expected pixels, not mm"),
        (skewed, "a skewed camera is not read"),
        (unfinished, "not what cv2.FileStorage writes"),
        (without_columns, "camera_matrix: expected a matrix"),
        (without_matrix, "camera_matrix: missing; found: image_width, image_height"),
    ],
)
def test_opencv_refusals(tmp_path: Path, make: Callable[[Path], None], says: str):
    make(tmp_path / "bad.yml")
    with pytest.raises(Refused, match=says):
        read_camera(tmp_path / "bad.yml")


def test_a_rational_model_that_is_plumb_bob_is_read(tmp_path: Path):
    stored(tmp_path / "c.yml", {"image_size": [640, 480]}, known().K, np.array([*CAMERA[4:], 0.0, 0.0, 0.0]))
    np.testing.assert_array_equal(read_camera(tmp_path / "c.yml").parameters, CAMERA)


def test_opencvs_own_calibration_samples():
    folder = DATA / "opencv_left_right"
    if not folder.is_dir():
        pytest.skip("shared data not beside the checkout")
    camera = read_camera(folder / "left_intrinsics.yml")
    assert camera.parameters[0] == 535.91573396163199
    with pytest.raises(Refused, match="two cameras of a stereo pair"):
        read_camera(folder / "intrinsics.yml")


DEEP = {
    "lists": "%YAML:1.0\\n---\\na: " + "[" * 200_000,
    "dashes": "%YAML:1.0\\n---\\na:\\n  " + "- " * 200_000,
    "maps": "%YAML:1.0\\n---\\na: " + "{a: " * 100_000,
    "tags": "<?xml version='1.0'?><opencv_storage>" + "<a>" * 100_000,
    "JSON": "{'opencv-matrix': " + "[" * 200_000,
}


@pytest.mark.parametrize("kind", DEEP)
def test_a_file_in_which_opencv_would_run_out_of_stack_is_refused(kind: str, tmp_path: Path):
    """In a process of its own, which ends by a signal where OpenCV reads it."""
    file = tmp_path / "camera.yaml"
    file.write_text(DEEP[kind].replace("\\n", "\n").replace("'", '"'))
    code = (
        "import sys\n"
        "from calibration.camera_file import read_camera\n"
        "from xneck_foundation.errors import Refused\n"
        "try: read_camera(sys.argv[1])\n"
        "except Refused as refusal: print(refusal)\n"
    )
    done = subprocess.run([sys.executable, "-c", code, file], capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done
    assert "camera.yaml: opens more than 1000 lists, tags or maps; is this a camera's file?" in done.stdout


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        ([f"k{k}: 1" for k in range(60_000)], "has 60000 entries"),
        (["camera_matrix: [" + "1, " * 300_000 + "1]"], "camera_matrix: expected a matrix of finite numbers"),
        (["k" * 900_000 + ": 1"], "camera_matrix: missing; found: kkk"),
    ],
)
def test_an_opencv_file_of_many_entries_is_refused_at_once(lines: list[str], says: str, tmp_path: Path):
    file = tmp_path / "camera.yaml"
    file.write_text("\n".join(["%YAML:1.0", "---", *lines, ""]))
    with pytest.raises(Refused) as caught:
        read_camera(file)
    assert says in str(caught.value)
    assert len(str(caught.value)) < 500
