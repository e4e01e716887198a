"""Picture files as grey values, pixel for pixel as the sensor delivered them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from calibration.picture_header import read_header
from calibration.png_chunks import PNG_SIGNATURE, png_damage
from xneck_foundation.errors import Refused
from xneck_foundation.input_file import check_input

SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp", ".pgm", ".ppm")
MAX_PIXELS = 250_000_000
"""pixels of a picture: more than any camera has; a file of some kB may state any number (docs/thresholds.md)"""
_FLAGS = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_ANYDEPTH | cv2.IMREAD_IGNORE_ORIENTATION
_TIFF = (b"II*\0", b"MM\0*")


@dataclass(frozen=True)
class Picture:
    """One picture or frame of a video."""

    name: str
    grey: np.ndarray  # shape (height, width), uint8


def picture_files(folder: str | Path) -> list[Path]:
    """The pictures in a folder by name, without its subfolders. Raises Refused where there are none."""
    folder = Path(folder)
    if not folder.is_dir():
        raise Refused(folder, "is not a folder", "name a folder of pictures")
    files = sorted(file for file in folder.iterdir() if file.suffix.lower() in SUFFIXES)
    if not files:
        raise Refused(folder, "holds no pictures", f"expected files ending in {', '.join(SUFFIXES)}")
    return files


def read_pictures(paths: Sequence[str | Path]) -> Iterator[Picture]:
    """Read one picture after the other, so that memory holds one at a time.

    The rotation tag of a camera's file is not applied: turned pictures would mix two principal points.
    Raises Refused, before the first is read, for files that do not exist, and at its turn for one that is no picture.
    """
    files = [Path(path) for path in paths]
    if not files:
        raise Refused("pictures", "none given", "name picture files or a folder")
    missing = [file for file in files if not file.is_file()]
    if len(missing) > 1:
        raise Refused(missing[0], f"is not a file and {len(missing) - 1} more", "check the name")
    if missing:
        check_input(missing[0])
    return _read(files)


def _read(files: list[Path]) -> Iterator[Picture]:
    # one name may stand in several folders
    short = len({file.name for file in files}) == len(files)
    for file in files:
        check_input(file)
        try:
            content = file.read_bytes()  # cv2.imread prints to the terminal where it fails
        except OSError as error:
            raise Refused(file, f"cannot be read ({error.strerror})") from error
        yield Picture(file.name if short else str(file), _decoded(file, content))


def _decoded(file: Path, content: bytes) -> np.ndarray:
    """Grey values (height, width), uint8, of a file's content. Raises Refused unless it is one picture of a listed format."""
    try:
        header = read_header(content)
    except ValueError as error:
        raise Refused(file, "is damaged in its header", "copy it again") from error
    if isinstance(header, str):
        raise Refused(file, f"is {header}", f"expected {', '.join(SUFFIXES)}")
    if header.width * header.height > MAX_PIXELS:
        raise Refused(
            file, f"is {header.width}x{header.height} pixels large", f"at most {MAX_PIXELS // 10**6} million are read"
        )
    if header.several:
        raise Refused(file, "holds several pictures", "save each in a file of its own")
    if header.turned:
        raise Refused(
            file, "is tagged as turned, and would not be read as the sensor delivered it", "save it without the tag"
        )
    if content.startswith(PNG_SIGNATURE) and (damage := png_damage(content)):
        raise Refused(file, f"is damaged {damage}", "copy it again")
    log_level = cv2.utils.logging.getLogLevel()
    try:
        if not content.startswith(_TIFF):  # of which OpenCV reads a part and says so
            cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
        grey = cv2.imdecode(np.frombuffer(content, np.uint8), _FLAGS)
    except cv2.error as error:
        raise Refused(file, f"cannot be decoded ({error.err})", "save it as PNG") from error
    finally:
        cv2.utils.logging.setLogLevel(log_level)
    if grey is None:
        raise Refused(
            file, "is damaged, or of a kind of its format that is not read", "copy it again, or save it as PNG"
        )
    if grey.dtype == np.uint8:
        return np.asarray(grey)
    if grey.dtype != np.uint16:
        raise Refused(file, f"has brightness as {grey.dtype}", "save it with 8 or 16 bits")
    # cameras of 10, 12 or 14 bits leave the upper bits of 16 empty
    bits = max(int(grey.max()).bit_length(), 8)
    return np.right_shift(grey, bits - 8).astype(np.uint8)
