"""Where a result comes from: hashes of what went in, versions of what computed it, and its settings."""

import hashlib
import platform
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from xneck_foundation.input_file import FileIdentity, file_identity, refuse_changed
from xneck_foundation.version import VERSION

_LIBRARIES = ("numpy", "scipy", "opencv-contrib-python-headless", "av", "mcap", "matplotlib")


@dataclass(frozen=True)
class InputFiles:
    """Input files by role, each with what it was before anything of it was read."""

    files: Mapping[str, tuple[Path, FileIdentity]]


def note_inputs(paths: Mapping[str, str | Path]) -> InputFiles:
    """Input files by role as they are now; to be called before they are read. Raises Refused where one is no regular file."""
    return InputFiles({role: (Path(path), file_identity(Path(path))) for role, path in paths.items()})


def provenance(inputs: InputFiles, settings: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Names, sizes and SHA-256 of input files by role; versions; settings. Ready for JSON.

    To be called when the inputs were read. Raises Refused where one is not what it was before: a hash is that of the bytes read.
    """
    return {
        **versions(),
        "inputs": {role: _input_entry(path, before) for role, (path, before) in inputs.files.items()},
        "settings": dict(settings or {}),
    }


def _input_entry(path: Path, before: FileIdentity) -> dict[str, Any]:
    """Name, size and SHA-256 of a file that has been what it is from `before` it was read until it was hashed."""
    refuse_changed(path, before)
    digest = sha256(path)
    refuse_changed(path, before)
    return {"file": path.name, "bytes": before.bytes, "sha256": digest}


def versions() -> dict[str, Any]:
    """Versions of xneck, Python and the libraries that compute."""
    return {
        "xneck": VERSION,
        "python": platform.python_version(),
        "libraries": {name: _installed(name) for name in _LIBRARIES},
    }


def sha256(path: str | Path) -> str:
    """Hexadecimal SHA-256 of a file's content."""
    with Path(path).open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _installed(library: str) -> str | None:
    """Version of a library, or None where it is absent: below `vision` all runs without those that read pictures."""
    try:
        return version(library)
    except PackageNotFoundError:
        return None
