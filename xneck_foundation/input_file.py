"""Inputs are regular files, which can be read twice and do not change meanwhile."""

import stat
from dataclasses import dataclass
from pathlib import Path

from xneck_foundation.errors import Refused


@dataclass(frozen=True)
class FileIdentity:
    """Which file a name stands for, and which content of it, as far as the file system tells without reading it."""

    device: int
    inode: int
    bytes: int
    mtime_ns: int


def file_identity(path: Path) -> FileIdentity:
    """The identity of a file as it is now. Raises Refused unless it is a regular file."""
    check_input(path)
    status = path.stat()
    return FileIdentity(status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns)


def refuse_changed(path: Path, before: FileIdentity) -> None:
    """Raises Refused where `path` is no longer the file that it was, or has been written to.

    A change within the file system's clock tick (some ms) that keeps the size is not noticed.
    """
    if file_identity(path) != before:
        raise Refused(path, "was changed or replaced while it was being read", "leave it as it is, and run this again")


def _bag_inside(folder: Path) -> str:
    """The one file of a ROS 2 bag, whose folder it is; empty where it is none, or has several."""
    try:
        names = [file.name for file in folder.iterdir()]
    except OSError:
        return ""
    bags = [name for name in names if name.lower().endswith((".mcap", ".db3"))]
    return f"the file in it, {folder / bags[0]}" if "metadata.yaml" in names and len(bags) == 1 else ""


def check_input(path: Path) -> None:
    """Raises Refused unless `path` is a regular file: a pipe or a device may block, or be empty when read again."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError as error:
        raise Refused(path, "does not exist", "check the name") from error
    except OSError as error:
        raise Refused(path, f"cannot be read ({error.strerror})") from error
    if stat.S_ISDIR(mode):
        raise Refused(path, "is a folder", f"name {_bag_inside(path) or 'a file'}")
    if not stat.S_ISREG(mode):
        raise Refused(path, "is no file but a pipe or a device", "save it as a file first")
