"""Output files that appear whole or not at all, and never in the place of a file that somebody else wrote."""

import contextlib
import glob
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from xneck_foundation.authorship import sign, written_by_xneck, yaml_kind
from xneck_foundation.errors import Refused

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None

_STEM = 40
"""characters of a file's name that its temporary file takes over, so that its name is not too long"""


_YAML = (".yaml", ".yml")
NECK_KIND, MODEL_KIND = "xneck", "xneck_model"
"""keys of the formats of neck.yaml and model.yaml"""
_YAML_KINDS = {NECK_KIND: "the description of an arm", MODEL_KIND: "a model"}

BY_OPTION = "give --force"
BY_BLOCK = "write within xneck_foundation.whole_file.replacing_any_file()"
"""what replaces files that xneck did not write: on the command line, and from Python"""

_REPLACING_ANY: ContextVar[bool] = ContextVar("replacing any file", default=False)


@contextmanager
def replacing_any_file() -> Iterator[None]:
    """Within the block, files that xneck did not write are replaced too, as `--force` does on the command line."""
    token = _REPLACING_ANY.set(True)
    try:
        yield
    finally:
        _REPLACING_ANY.reset(token)


def check_output(path: Path) -> None:
    """Raises Refused where no file can be written at `path`, or one is there that xneck did not write; called before long work."""
    check_place(path)
    if path.exists() and path.stat().st_size and not _REPLACING_ANY.get() and not written_by_xneck(path):
        what = "exists, and is not as xneck wrote it: replacing it would lose what is in it"
        raise Refused(path, what, f"name another file, or {BY_OPTION}")


def check_kind(path: Path, kind: str) -> None:
    """Raises Refused where a YAML file is at `path` that is of another kind than the one that is to be written there."""
    if path.suffix.lower() not in _YAML or not path.is_file() or not path.stat().st_size or _REPLACING_ANY.get():
        return
    if (there := yaml_kind(path)) != kind:
        names = [_YAML_KINDS.get(one, f"a file of `{one}`") for one in (there, kind)]
        raise Refused(path, f"is {names[0]}, and would be replaced by {names[1]}", f"name another file, or {BY_OPTION}")


def check_place(path: Path) -> None:
    """Raises Refused where no file can be written at `path`."""
    if path.is_dir():
        raise Refused(path, "is a folder", "name a file")
    if path.exists() and not path.is_file():
        raise Refused(path, "is a pipe or a device", "name a file")
    if not path.parent.is_dir():
        raise Refused(path, f"the folder {path.parent} does not exist", "make it first")
    if not os.access(path.parent, os.W_OK):
        raise Refused(path, f"the folder {path.parent} cannot be written to")


@contextmanager
def whole_file(path: str | Path) -> Iterator[Path]:
    """A temporary path beside `path`, of the same suffix, moved over it when the block ends without an error.

    The file is marked as xneck's (xneck_foundation/authorship.py). Temporary files of earlier attempts at `path` that were
    killed are removed. Raises Refused where the folder does not exist or cannot be written, a file is there that xneck did
    not write or that is a YAML of another kind, or the disk is full.
    """
    path = Path(path)
    check_output(path)
    remove_abandoned(path)
    try:
        handle, name = tempfile.mkstemp(prefix=_prefix(path), suffix=path.suffix, dir=path.parent)
    except OSError as error:
        raise Refused(path, f"cannot be written ({error.strerror})") from error
    part = Path(name)
    try:
        with os.fdopen(handle, "rb") as held:
            lock_file(held.fileno())
            yield part
            check_kind(path, yaml_kind(part))
            sign(part, path.suffix)
            os.fsync(held.fileno())
        part.chmod(0o644)
        part.replace(path)
    except OSError as error:
        raise Refused(path, f"cannot be written ({error.strerror or error})") from error
    finally:
        part.unlink(missing_ok=True)


def _prefix(path: Path) -> str:
    return f".{path.stem[:_STEM]}.xneck-"


def remove_abandoned(path: Path) -> None:
    """Removes temporary files of the output `path` whose writer has ended: a running one holds a lock."""
    for temporary in path.parent.glob(f"{glob.escape(_prefix(path))}????????{glob.escape(path.suffix)}"):
        with contextlib.suppress(OSError), temporary.open("rb") as stream:
            if lock_file(stream.fileno()):
                temporary.unlink()


def lock_file(handle: int) -> bool | None:
    """Whether this process has locked the open file; False where another one holds it, None where the system has no such locks."""
    if fcntl is None:
        return None
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return None
    return True


def replaces_any_file() -> bool:
    """Whether files that xneck did not write are replaced here."""
    return _REPLACING_ANY.get()


def write_text(path: str | Path, text: str) -> None:
    """`text` as UTF-8 into `path`, whole or not at all."""
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8")
