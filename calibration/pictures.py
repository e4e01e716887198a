"""Picture files as grey values, pixel for pixel as the sensor delivered them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from xneck_foundation.errors import Refused
from xneck_foundation.input_file import check_input

SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp", ".pgm", ".ppm")


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
        try:
            content = np.fromfile(file, np.uint8)  # cv2.imread prints to the terminal where it fails
        except OSError as error:
            raise Refused(file, f"cannot be read ({error.strerror})") from error
        flags = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION
        grey = cv2.imdecode(content, flags) if content.size else None
        if grey is None:
            raise Refused(file, "is not a picture that can be read", f"expected {', '.join(SUFFIXES)}")
        yield Picture(file.name if short else str(file), np.asarray(grey, np.uint8))
