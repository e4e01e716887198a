"""Check that an input is a regular file, which can be read twice."""

import stat
from pathlib import Path

from xneck_foundation.errors import Refused


def check_input(path: Path) -> None:
    """Raises Refused unless `path` is a regular file: a pipe or a device may block, or be empty when read again."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError as error:
        raise Refused(path, "does not exist", "check the name") from error
    except OSError as error:
        raise Refused(path, f"cannot be read ({error.strerror})") from error
    if stat.S_ISDIR(mode):
        raise Refused(path, "is a folder", "name a file")
    if not stat.S_ISREG(mode):
        raise Refused(path, "is no file but a pipe or a device", "save it as a file first")
