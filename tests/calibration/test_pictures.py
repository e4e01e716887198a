from pathlib import Path

import cv2
import numpy as np
import pytest

from calibration.pictures import picture_files, read_pictures
from xneck.errors import Refused

GREY = np.random.default_rng(0).integers(0, 255, (20, 30), np.uint8)


def save(path: Path, grey: np.ndarray = GREY) -> Path:
    cv2.imwrite(str(path), grey)
    return path


def test_reads_a_folder_in_order(tmp_path: Path):
    for name in ("b.png", "a.PNG", "c.bmp"):
        save(tmp_path / name)
    (tmp_path / "notes.txt").write_text("no picture")
    pictures = list(read_pictures(picture_files(tmp_path)))
    assert [picture.name for picture in pictures] == ["a.PNG", "b.png", "c.bmp"]
    np.testing.assert_array_equal(pictures[0].grey, GREY)


def test_same_name_in_two_folders_keeps_the_folders(tmp_path: Path):
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
    paths = [save(tmp_path / folder / "a.png") for folder in ("one", "two")]
    assert [picture.name for picture in read_pictures(paths)] == [str(path) for path in paths]


def test_the_rotation_tag_is_ignored(tmp_path: Path):
    path = save(tmp_path / "turned.jpg")
    jpeg = path.read_bytes()
    # EXIF with the one entry Orientation = 6 (turn by 90 degrees)
    tiff = b"MM\x00*\x00\x00\x00\x08\x00\x01\x01\x12\x00\x03\x00\x00\x00\x01\x00\x06\x00\x00\x00\x00\x00\x00"
    exif = b"Exif\x00\x00" + tiff
    path.write_bytes(jpeg[:2] + b"\xff\xe1" + (len(exif) + 2).to_bytes(2, "big") + exif + jpeg[2:])
    turned = cv2.imread(str(path))
    assert turned is not None
    assert turned.shape[:2] == (30, 20), "OpenCV turns it"
    (picture,) = read_pictures([path])
    assert picture.grey.shape == (20, 30)


def test_refuses_missing_files_before_reading_any(tmp_path: Path):
    with pytest.raises(Refused, match=r"gone.png: is not a file and 1 more"):
        read_pictures([save(tmp_path / "a.png"), tmp_path / "gone.png", tmp_path / "too.png"])


@pytest.mark.parametrize("content", [b"", b"hello", b"\x89PNG\r\n\x1a\n broken"])
def test_refuses_what_is_no_picture(tmp_path: Path, content: bytes, capfd: pytest.CaptureFixture[str]):
    (tmp_path / "a.png").write_bytes(content)
    with pytest.raises(Refused, match=r"a.png: is not a picture"):
        list(read_pictures([tmp_path / "a.png"]))


def test_refuses_nothing(tmp_path: Path):
    with pytest.raises(Refused, match="holds no pictures"):
        picture_files(tmp_path)
    with pytest.raises(Refused, match="is not a folder"):
        picture_files(tmp_path / "gone")
    with pytest.raises(Refused, match="none given"):
        read_pictures([])
