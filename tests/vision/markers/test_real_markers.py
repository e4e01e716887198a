"""Markers in photographs and videos that nobody here made; skipped where the shared data are not beside the checkout."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from mechanism.printed_markers import BarMarker, Markers
from tests.paths import SHARED
from vision.markers.detection import MarkerDetector
from vision.video import read_frames

DATA = SHARED / "markers"

pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason=f"no real data at {DATA}")


def finder(dictionary: str, ids: range) -> MarkerDetector:
    on_bars = tuple(BarMarker(id=i, bar=0) for i in ids)
    return MarkerDetector(Markers(dictionary=dictionary, size=0.02, on_bars=on_bars))


def published(picture: Path) -> list[np.ndarray]:
    """Corners lb, rb, rt, lt of the tags in a photograph, pixel edges at integers, turned to pixel centres at integers."""
    rows = [line for line in picture.with_suffix(".txt").read_text().splitlines() if line.strip()]
    cells = [row.split(",", 1)[1].replace("(", " ").replace(")", " ").replace(",", " ").split() for row in rows]
    return [np.array(c, dtype=float).reshape(4, 2) - 0.5 for c in cells]


def test_photographs() -> None:
    """41 of 47 tags (36 by OpenCV's own settings), 46 where small ones are searched, corners within half a pixel of the published
    ones in the median; and OpenCV's AprilTag patterns are turned by 180 degrees against AprilTag's own, on every tag."""
    found, small, turns, off, expected = 0, 0, set(), [], 0
    for picture in sorted((DATA / "apriltag").glob("*.jpg")):
        grey = np.asarray(cv2.imread(str(picture), cv2.IMREAD_GRAYSCALE), dtype=np.uint8)
        detector = finder("apriltag_36h11", range(587))
        seen = [c for _, c in detector.detect_all(grey)]
        of_few_pixels = np.array([c.mean(axis=0) for _, c in detector.detect_small(grey)])
        for corners in published(picture):
            expected += 1
            small += bool(np.any(np.linalg.norm(of_few_pixels - corners.mean(axis=0), axis=1) < 4))
            upright = corners[[3, 2, 1, 0]]  # lt, rt, rb, lb: OpenCV's order
            near = [c for c in seen if np.linalg.norm(c.mean(axis=0) - upright.mean(axis=0)) < 4]
            if near:
                found += 1
                errors = [np.max(np.abs(np.roll(near[0], k, axis=0) - upright)) for k in range(4)]
                turns.add(int(np.argmin(errors)))
                off.append(min(errors))
    assert expected == 47
    assert found >= 41
    assert small >= 46
    assert turns == {2}
    assert np.median(off) < 0.5


def test_markers_on_two_wooden_bars() -> None:
    """17 of the 18 markers of the first frame (OpenCV as it is: 16); the video is read to its end, though its header counts one
    frame more."""
    seen = [
        len(finder("aruco_original", range(1024)).detect_all(f.grey))
        for f in read_frames(DATA / "scikit_surgery/multipattern.avi")
    ]
    assert len(seen) == 10
    assert seen[0] == 17


@pytest.mark.parametrize("dictionary", ["aruco_original", "aruco_4x4_50", "apriltag_16h5", "apriltag_36h11"])
def test_pictures_without_markers_have_none(dictionary: str) -> None:
    """Boards of dots and squares; the search for small ones took dark squares of five of them for marker 0 of aruco_original."""
    detector = finder(dictionary, range(1))
    folders = [SHARED / "calibration" / name for name in ("zhang_1998", "opencv_left_right")]
    pictures = sorted(path for folder in folders for path in folder.rglob("*") if path.suffix in (".png", ".jpg"))
    assert len(pictures) > 20
    for path in pictures:
        grey = np.asarray(cv2.imread(str(path), cv2.IMREAD_GRAYSCALE), dtype=np.uint8)
        assert detector.detect_all(grey) + detector.detect_small(grey) == [], path.name
