"""Digest of the sources of the packages as installed: in a checkout the version alone does not identify the code."""

import functools
import hashlib
import importlib.util
from pathlib import Path

_COMPUTING = (
    "xneck_foundation",
    "discovery",
    "mechanism",
    "calibration",
    "identification",
    "observation",
    "state_estimation",
    "diagnosis",
    "synchronisation",
    "vision",
    "xneck",
)
_SHOWING = ("cli", "report", "study", "viewers")
"""folders that change no number"""
_SOURCES = (".py", ".jinja", ".css", ".js", ".yaml")


def source_digest(*folders: Path) -> str:
    """Digest of the sources of all packages, but those that only show results, and of those in `folders`."""
    return _digest(folders)


@functools.cache
def _digest(folders: tuple[Path, ...]) -> str:
    sha = hashlib.sha256()
    for name in _COMPUTING:
        spec = importlib.util.find_spec(name)
        assert spec is not None
        assert spec.submodule_search_locations
        _add(sha, Path(spec.submodule_search_locations[0]), _SHOWING)
    for folder in folders:
        _add(sha, folder, ())
    return sha.hexdigest()[:16]


def _add(sha: "hashlib._Hash", folder: Path, excluded: tuple[str, ...]) -> None:
    for file in sorted(folder.rglob("*")):
        within = file.relative_to(folder)
        if file.suffix in _SOURCES and within.parts[0] not in excluded:
            sha.update(f"{folder.name}/{within.as_posix()}\0".encode() + file.read_bytes())
