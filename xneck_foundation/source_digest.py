"""What computes: a digest of the source of the packages as installed, which a version alone does not tell in a checkout."""

import functools
import hashlib
import importlib.util
from pathlib import Path

_COMPUTING = (
    "xneck_foundation",
    "mechanism",
    "calibration",
    "identification",
    "state_estimation",
    "diagnosis",
    "synchronisation",
    "vision",
    "xneck",
)
_SHOWING = ("cli", "report", "study", "viewers")
"""folders that change no number"""
_SOURCES = (".py", ".jinja", ".css")


def source_digest(*more: Path) -> str:
    """Of the packages' sources but those that only show, and of those in the folders `more`."""
    return _digest(more)


@functools.cache
def _digest(more: tuple[Path, ...]) -> str:
    sha = hashlib.sha256()
    for name in _COMPUTING:
        spec = importlib.util.find_spec(name)
        assert spec is not None
        assert spec.submodule_search_locations
        _add(sha, Path(spec.submodule_search_locations[0]), _SHOWING)
    for folder in more:
        _add(sha, folder, ())
    return sha.hexdigest()[:16]


def _add(sha: "hashlib._Hash", folder: Path, but: tuple[str, ...]) -> None:
    for file in sorted(folder.rglob("*")):
        within = file.relative_to(folder)
        if file.suffix in _SOURCES and within.parts[0] not in but:
            sha.update(f"{folder.name}/{within.as_posix()}\0".encode() + file.read_bytes())
