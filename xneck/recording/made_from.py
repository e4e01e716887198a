"""What a result was made from: the recording's files, and what computed it. Where both are the same, so is the result."""

import platform
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from xneck.recording.recording_folder import Recording
from xneck_foundation.errors import Refused
from xneck_foundation.provenance import sha256, versions
from xneck_foundation.source_digest import digest

_SHOWN = tuple(Path(__file__).parents[1] / name for name in ("report", "viewers"))


def made_from(recording: Recording) -> dict[str, Any]:
    """Versions, the digest of the sources, and of every file its name, size, time of change and SHA-256. Ready for JSON."""
    return makers() | {"inputs": {role: _entry(path, recording.folder) for role, path in _files(recording).items()}}


def unchanged(before: Mapping[str, Any], recording: Recording) -> dict[str, Any] | None:
    """`before` with the times of change as they are now, or None where something else has changed.

    Size and time are looked at first, as make does; a file of which the time alone differs (copied, checked out anew) is hashed.
    What was changed within the file system's clock tick (some ms) and kept its size goes unseen.
    """
    now_made, files, entries = makers(), _files(recording), before.get("inputs", {})
    if {key: before.get(key) for key in now_made} != now_made or entries.keys() != files.keys():
        return None
    now = {role: _still(entries[role], path, recording.folder) for role, path in files.items()}
    return None if None in now.values() else now_made | {"inputs": now}


def _files(recording: Recording) -> dict[str, Path]:
    return {"recording": recording.config, **recording.files}


def makers() -> dict[str, Any]:
    """What computes and shows: versions, and the digest of the sources."""
    # a patch of Python changes no number, and machines of a cluster may differ in it
    python = ".".join(platform.python_version_tuple()[:2])
    return {**versions(), "python": python, "source": digest(*_SHOWN)}


def _still(entry: Mapping[str, Any], path: Path, folder: Path) -> dict[str, Any] | None:
    seen = _stat(path, folder)
    if any(seen[key] != entry.get(key) for key in ("file", "bytes")):
        return None
    if seen["mtime_ns"] != entry.get("mtime_ns") and _sha256(path) != entry.get("sha256"):
        return None
    return {**entry, **seen}


def _entry(path: Path, folder: Path) -> dict[str, Any]:
    # the time is taken first: what is changed while it is read is seen as changed later
    return {**_stat(path, folder), "sha256": _sha256(path)}


def _stat(path: Path, folder: Path) -> dict[str, Any]:
    stat = path.stat()
    return {"file": path.relative_to(folder).as_posix(), "bytes": stat.st_size, "mtime_ns": stat.st_mtime_ns}


def _sha256(path: Path) -> str:
    try:
        return sha256(path)
    except OSError as error:
        raise Refused(path, f"cannot be read ({error.strerror})") from error
