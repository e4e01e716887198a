"""Outputs that appear whole or not at all."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from xneck.errors import Refused


def check_place(path: Path) -> None:
    """Refused where a file cannot be put at `path`, so that long work does not end in nothing."""
    if path.is_dir():
        raise Refused(path, "is a folder", "name a file")
    if not path.parent.is_dir():
        raise Refused(path, f"the folder {path.parent} does not exist", "make it first")
    if not os.access(path.parent, os.W_OK):
        raise Refused(path, f"the folder {path.parent} cannot be written to")


@contextmanager
def whole_file(path: str | Path) -> Iterator[Path]:
    """A temporary path beside `path`, of the same suffix, moved over it when the block ends without an error.

    Raises Refused where the folder does not exist or cannot be written.
    """
    path = Path(path)
    check_place(path)
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.stem}-", suffix=path.suffix, dir=path.parent)
    except OSError as error:
        raise Refused(path, f"cannot be written ({error.strerror})") from error
    os.close(handle)
    part = Path(name)
    try:
        yield part
        part.chmod(0o644)
        part.replace(path)
    except OSError as error:
        raise Refused(path, f"cannot be written ({error.strerror or error})") from error
    finally:
        part.unlink(missing_ok=True)


def write_text(path: str | Path, text: str) -> None:
    """`text` as UTF-8 into `path`, whole or not at all."""
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8")
