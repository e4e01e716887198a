import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest

from calibration.pictures import picture_files, read_pictures
from xneck_foundation.errors import Refused

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


@pytest.mark.parametrize("kind", ["16 bit", "colour", "alpha", "16 bit colour"])
def test_other_depths_and_channels_become_grey(tmp_path: Path, kind: str):
    deep = GREY.astype(np.uint16) * 257
    alpha = np.full_like(GREY, 255)
    stored = {
        "16 bit": deep,
        "colour": np.dstack([GREY] * 3),
        "alpha": np.dstack([GREY, GREY, GREY, alpha]),
        "16 bit colour": np.dstack([deep] * 3),
    }[kind]
    (picture,) = read_pictures([save(tmp_path / "a.png", stored)])
    assert picture.grey.dtype == np.uint8
    np.testing.assert_allclose(picture.grey.astype(int), GREY, atol=1)


def test_grey_with_alpha_becomes_grey(tmp_path: Path):
    def chunk(kind: bytes, data: bytes) -> bytes:
        return len(data).to_bytes(4, "big") + kind + data + zlib.crc32(kind + data).to_bytes(4, "big")

    rows = b"".join(b"\x00" + np.dstack([row, np.full_like(row, 255)]).tobytes() for row in GREY)
    head = GREY.shape[1].to_bytes(4, "big") + GREY.shape[0].to_bytes(4, "big") + b"\x08\x04\x00\x00\x00"
    path = tmp_path / "a.png"  # OpenCV writes no such file: colour type 4
    body = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + body)
    (picture,) = read_pictures([path])
    np.testing.assert_array_equal(picture.grey, GREY)


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif", ".bmp"])
def test_refuses_a_picture_cut_short(tmp_path: Path, suffix: str):
    path = save(tmp_path / f"a{suffix}")
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(Refused, match=rf"a{suffix}: is damaged"):
        list(read_pictures([path]))


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".bmp", ".pgm", ".webp"])
@pytest.mark.parametrize("without", [4, 20, 200])
def test_the_refusal_of_a_cut_picture_is_all_that_is_printed(
    tmp_path: Path, suffix: str, without: int, capfd: pytest.CaptureFixture[str]
):
    """libpng and OpenCV print lines of their own, past Python."""
    path = save(tmp_path / f"a{suffix}")
    path.write_bytes(path.read_bytes()[:-without])
    with pytest.raises(Refused, match=rf"a{suffix}: is damaged"):
        list(read_pictures([path]))
    assert capfd.readouterr() == ("", "")


def test_a_changed_byte_of_a_png_is_refused_where_the_picture_needs_it(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
):
    whole = save(tmp_path / "a.png").read_bytes()
    (tmp_path / "a.png").write_bytes(whole[:200] + bytes([whole[200] ^ 1]) + whole[201:])
    with pytest.raises(Refused, match=r"a.png: is damaged after \d+ of its \d+ bytes: their checksum is wrong"):
        list(read_pictures([tmp_path / "a.png"]))
    assert capfd.readouterr() == ("", "")
    note = b"tEXtTitle\0of the board"
    noted = whole[:33] + (len(note) - 4).to_bytes(4, "big") + note + zlib.crc32(note).to_bytes(4, "big") + whole[33:]
    for ending in (b"", b"what a camera appends"):
        (tmp_path / "a.png").write_bytes(noted + ending)
        (picture,) = read_pictures([tmp_path / "a.png"])
        np.testing.assert_array_equal(picture.grey, GREY)


def test_refuses_missing_files_before_reading_any(tmp_path: Path):
    with pytest.raises(Refused, match=r"gone.png: is not a file and 1 more"):
        read_pictures([save(tmp_path / "a.png"), tmp_path / "gone.png", tmp_path / "too.png"])


@pytest.mark.parametrize(
    ("content", "what"),
    [
        (b"", "an empty file"),
        (b"hello", "no picture"),
        (b"\x89PNG\r\n\x1a\n broken", "damaged"),
        (b"\x89PNG\r\n\x1a\n", "damaged"),
        (b"II*\0\x08\0\0\0\xff\xff", "damaged"),
        (b"\xff\xd8\xff\xe0\0\x04ab\xff", "damaged"),
        (b"GIF89a" + bytes(20), "a GIF"),
        (b"\0\0\0\x20ftypisom" + bytes(20), "a video"),
        (b"\0\0\0\x20ftypavif" + bytes(20), "an AVIF"),
        (b"#EXTM3U\n/etc/passwd\n", "a text"),
        (b'<svg><image href="file:///etc/passwd"/></svg>', "a text"),
        (b"#?RADIANCE\n", "floating-point brightness"),
    ],
)
def test_refuses_what_is_no_picture(tmp_path: Path, content: bytes, what: str):
    (tmp_path / "a.png").write_bytes(content)
    with pytest.raises(Refused, match=rf"a.png: is .*{what}"):
        list(read_pictures([tmp_path / "a.png"]))


def png(width: int, height: int, *chunks: bytes) -> bytes:
    def chunk(kind: bytes, data: bytes) -> bytes:
        return len(data).to_bytes(4, "big") + kind + data + zlib.crc32(kind + data).to_bytes(4, "big")

    head = width.to_bytes(4, "big") + height.to_bytes(4, "big") + b"\x08\0\0\0\0"
    rows = zlib.compress(b"\0" + bytes(width) if width < 1000 else b"")
    between = b"".join(chunk(kind, bytes(8)) for kind in chunks)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + between + chunk(b"IDAT", rows) + chunk(b"IEND", b"")


def test_a_size_that_no_camera_has_is_refused_before_memory_is_asked_for(tmp_path: Path):
    (tmp_path / "a.png").write_bytes(png(100_000, 100_000))
    with pytest.raises(Refused, match="is 100000x100000 pixels large"):
        list(read_pictures([tmp_path / "a.png"]))


@pytest.mark.parametrize("suffix", [".png", ".webp", ".tif"])
def test_several_pictures_in_a_file_are_refused_and_one_is_read(tmp_path: Path, suffix: str):
    path = tmp_path / f"a{suffix}"
    if suffix == ".png":
        path.write_bytes(png(3, 1, b"acTL"))
    else:
        frames = [np.dstack([GREY] * 3), np.dstack([255 - GREY] * 3)]
        cv2.imwritemulti(str(path), frames) if suffix == ".tif" else cv2.imwriteanimation(str(path), animated(frames))
    with pytest.raises(Refused, match="holds several pictures"):
        list(read_pictures([path]))
    single = tmp_path / f"b{suffix}"
    cv2.imwrite(str(single), GREY, [cv2.IMWRITE_WEBP_QUALITY, 101])
    (picture,) = read_pictures([single])
    np.testing.assert_allclose(picture.grey.astype(int), GREY, atol=1)


def animated(frames: list[np.ndarray]) -> cv2.Animation:
    animation = cv2.Animation()
    animation.frames, animation.durations = frames, [100] * len(frames)
    return animation


def test_a_tiff_that_opencv_would_turn_is_refused(tmp_path: Path):
    """libtiff obeys the tag, whatever OpenCV is told; a TIFF whose tag turns nothing is read."""
    path = tmp_path / "a.tif"
    cv2.imwrite(str(path), GREY, [cv2.IMWRITE_TIFF_COMPRESSION, 1])
    plain = path.read_bytes()
    # the entry of a single plane (284), which is the default, becomes that of the orientation (274)
    entry = b"\x03\0\x01\0\0\0"
    assert plain.count(b"\x1c\x01" + entry + b"\x01") == 1
    path.write_bytes(plain.replace(b"\x1c\x01" + entry + b"\x01", b"\x12\x01" + entry + b"\x06"))
    turned = cv2.imdecode(np.fromfile(path, np.uint8), cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION)
    assert turned is not None
    assert turned.shape == (30, 20)
    with pytest.raises(Refused, match="is tagged as turned"):
        list(read_pictures([path]))
    path.write_bytes(plain)
    (picture,) = read_pictures([path])
    np.testing.assert_array_equal(picture.grey, GREY)


def test_twelve_bits_in_sixteen_keep_their_grey_levels(tmp_path: Path):
    (picture,) = read_pictures([save(tmp_path / "a.png", GREY.astype(np.uint16) * 16)])
    np.testing.assert_array_equal(picture.grey, GREY)


def test_brightness_in_floating_point_is_refused(tmp_path: Path):
    with pytest.raises(Refused, match="has brightness as float32"):
        list(read_pictures([save(tmp_path / "a.tif", GREY.astype(np.float32))]))


def test_refuses_nothing(tmp_path: Path):
    with pytest.raises(Refused, match="holds no pictures"):
        picture_files(tmp_path)
    with pytest.raises(Refused, match="is not a folder"):
        picture_files(tmp_path / "gone")
    with pytest.raises(Refused, match="none given"):
        read_pictures([])
