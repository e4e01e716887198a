"""xneck calibrate: the camera, its meaning, other tools' formats, and whether it still holds."""

import json
import re
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest

from calibration.camera_file import read_camera
from tests.command import run
from tests.paths import SAMPLES

SAMPLE = SAMPLES / "recording"
BOARD = ["--board", SAMPLE / "board.yaml"]


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The sample's pictures of its board: every second one to calibrate with, the others to check with."""
    first, second = (tmp_path_factory.mktemp(name) for name in ("first", "second"))
    for k, file in enumerate(sorted((SAMPLE / "board").glob("*.jpg"))):
        shutil.copy(file, (first, second)[k % 2])
    return first, second


def test_the_whole_of_it(pictures: tuple[Path, Path], tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    out, page = tmp_path / "camera.yaml", tmp_path / "page.html"
    neck = ["--neck", SAMPLE / "neck.yaml", "--distance", "0.7"]
    words = ["--out", out, *neck, "--report", page, "--export", "opencv", "--json", "-"]
    ran = run(capfd, "calibrate", pictures[0], *BOARD, *words)
    assert (ran.status, ran.err) == (0, "")
    found = json.loads(ran.out)
    assert 0 < found["projection"]["median_px"] <= found["projection"]["worst_px"] < 2
    arm = found["projection"]["arm"]
    assert arm["distance_m"] == 0.7
    assert np.shape(arm["alpha_rad"]) == (3, 3)
    assert 0 < np.degrees(arm["alpha_worst_rad"]) < 0.05
    assert 0.3 < found["coverage"]["share_of_cells"] <= 1
    assert len(found["next_pictures"]) == 3
    assert found["next_pictures"][0]["words"].startswith("hold the board")
    np.testing.assert_array_equal(read_camera(tmp_path / "camera.opencv.yaml").covariance, read_camera(out).covariance)
    assert "xneck report of one camera calibration" in page.read_text(encoding="utf-8")
    # what any format of the camera leads to is the same verdict, also by a text
    for camera in (out, tmp_path / "camera.opencv.yaml"):
        ran = run(capfd, "calibrate", pictures[1], *BOARD, "--check", camera)
        assert ran.status == 0
        assert f"{camera}: holds: " in ran.out


def test_a_scaled_video_does_not_hold(
    pictures: tuple[Path, Path], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Cut and scaled up again by 2 %, as a stabiliser does: the size is the same, the focal length is not."""
    out, zoomed = tmp_path / "camera.yaml", tmp_path / "zoomed"
    zoomed.mkdir()
    assert run(capfd, "calibrate", pictures[0], *BOARD, "--out", out, "--quiet").out == ""
    for file in pictures[1].glob("*.jpg"):
        grey = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION)
        assert grey is not None
        height, width = grey.shape
        K = read_camera(out).K
        M = np.array([[1.02, 0, -0.02 * K[0, 2]], [0, 1.02, -0.02 * K[1, 2]]])
        cv2.imwrite(str(zoomed / file.with_suffix(".png").name), cv2.warpAffine(grey, M, (width, height)))
    ran = run(capfd, "calibrate", zoomed, *BOARD, "--check", out, "--json", "-")
    found = json.loads(ran.out)
    assert (ran.status, found["verdict"]) == (0, "does not hold")
    assert re.search(r"focal length changed by \+(1\.9|2|2\.1) %", found["why"])
    assert found["change"]["fx"] == pytest.approx(0.02 * read_camera(out).parameters[0], rel=0.1)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ([], "give --out camera.yaml, or --check camera.yaml"),
        (["--check", "a.yaml", "--out", "b.yaml"], "goes without --out"),
        (["--check", "a.yaml", "--link", "0.1"], "goes without --link"),
        (["--out", "b.yaml", "--distance", "1"], "give --neck or --link too"),
        (["--out", "b.yaml", "--neck", "n.yaml", "--link", "0.1"], "two arms"),
    ],
)
def test_wrong_usage(words: list[str], says: str, capfd: pytest.CaptureFixture[str]) -> None:
    ran = run(capfd, "calibrate", "x.png", *BOARD, *words)
    assert ran.status == 2
    assert says in ran.err
