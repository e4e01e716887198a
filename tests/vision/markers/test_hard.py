"""What a cable, a strip or blur takes from a detector, following keeps: angles of rendered recordings against their own motion."""

from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

import vision.markers.detection
from benchmarks.hard import by_opencv, by_ours, true_camera
from calibration.camera_file import write_camera
from mechanism.description import Neck, markers_of, read_neck
from samples.generator.frame import render_frame
from samples.generator.hard import COMES_AT, FRAME_HZ, Hard, cases
from synchronisation.angles import read_angles
from tests.command import run
from tests.paths import NECK_FILE
from vision.markers.detection import MarkerDetector
from vision.markers.tracking import MarkerTracker

PLAIN = NECK_FILE
CASES = cases(yaml.safe_load(PLAIN.read_text()))
FRAMES = 20
BEFORE = round(COMES_AT * FRAME_HZ)
"""frames before anything comes in the way"""


def made(name: str, folder: Path) -> tuple[Hard, Path, Neck]:
    """The first frames of a hard recording and its neck.yaml."""
    case = CASES[name]
    case.render(folder / "video.mp4", FRAMES)
    (folder / "neck.yaml").write_text(yaml.safe_dump(case.neck))
    return case, folder / "video.mp4", read_neck(folder / "neck.yaml")


@pytest.mark.parametrize("name", ["a quarter hidden", "6 px of blur, cable"])
def test_no_angle_is_lost_where_a_detector_loses_nearly_all(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """OpenCV loses 9 of 10 angles once something is in the way, and so does ours if it follows nothing and fills no lines.

    As it is it loses none; by grey levels it errs as its sigma says: errors of one recording go together, so that its three joints
    count, and the RMS of error over sigma is below 1 + 3 / sqrt(2 * 3). Edges do not tell a strip's side from the marker's.
    """
    case, video, neck = made(name, tmp_path)
    camera, truth = true_camera(case.camera), case.truth(FRAMES)
    alone = by_opencv("SUBPIX", video, neck, camera, FRAMES)
    assert np.isnan(alone.alpha[BEFORE:]).mean() > 0.9
    for corners in ("edges", "template"):
        ours = by_ours(corners, video, neck, camera, case.camera.exposure_s, FRAMES)
        assert np.isfinite(ours.alpha).all()
        assert ours.markers_lost == 0
        z = (ours.alpha - truth) / ours.sigma
        assert np.sqrt(np.mean(z**2)) < (1 + 3 / np.sqrt(6) if corners == "template" else 4)
        # edges beside a strip are as wrong as markers stuck on beside their places, and count so
        assert np.degrees(np.median(ours.sigma)) < (0.1 if corners == "template" else 0.2)
    monkeypatch.setattr(vision.markers.detection, "OCCLUSION_WIDTHS_PX", ())
    monkeypatch.setattr(MarkerTracker, "_predicted", lambda self, time: np.full((len(self._ids), 4, 2), np.nan))
    blind = by_ours("edges", video, neck, camera, case.camera.exposure_s, FRAMES)
    assert np.isnan(blind.alpha[BEFORE:]).mean() > 0.9


def test_a_portrait_recording_by_command(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Stored on its side with a tag, as a phone does, a cable across the markers: every angle, within what sigma says."""
    case, video, _ = made("cable, portrait", tmp_path)
    write_camera(true_camera(case.camera), tmp_path / "camera.yaml")
    words = ["--camera", tmp_path / "camera.yaml", "--neck", tmp_path / "neck.yaml", "--out", tmp_path / "angles.csv"]
    done = run(capfd, "extract", video, *words, "--corners", "template", "--exposure", str(case.camera.exposure_s))
    assert done.status == 0
    assert f"{FRAMES} of {FRAMES} frames with all angles" in done.out
    found = read_angles(tmp_path / "angles.csv", 3)
    error = found.alpha - case.truth(FRAMES)
    assert np.degrees(np.abs(error).max()) < 0.2
    assert np.sqrt(np.mean((error / found.sigma) ** 2)) < 1 + 3 / np.sqrt(6)


def test_markers_under_a_cable_are_found_without_a_history() -> None:
    """Of four markers three have a dark line of 4 px across: filled, two of them at least are read in every picture; as they are,
    not half as many in all."""
    case = CASES["cable from the start"]
    markers = markers_of(read_neck(PLAIN), PLAIN)
    detector = MarkerDetector(markers)
    plain, filled = [], []
    for t in case.times[:30:5]:
        picture = render_frame(case.alpha_at(t), case.neck, case.camera, None, suffers=case.trouble_at(t))
        grey = np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), dtype=np.uint8)
        plain.append(len(detector.detect_all(grey)) - 1)
        filled.append(len(detector.detect(grey).corners) - 1)
    assert min(filled) >= 2
    assert 2 * sum(plain) < sum(filled)
