"""Where a result comes from: hashes of what went in, versions of what computed it, and its settings."""

import hashlib
import platform
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from xneck_foundation.version import VERSION

_LIBRARIES = ("numpy", "scipy", "opencv-contrib-python-headless", "av", "mcap", "matplotlib")


def provenance(inputs: Mapping[str, str | Path], settings: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Names, sizes and SHA-256 of input files by role; versions; settings. Ready for JSON."""
    return {
        **versions(),
        "inputs": {
            role: {"file": Path(path).name, "bytes": Path(path).stat().st_size, "sha256": sha256(path)}
            for role, path in inputs.items()
        },
        "settings": dict(settings or {}),
    }


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
