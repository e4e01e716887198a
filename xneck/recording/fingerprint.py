"""What a result was made from: the recording's files, and the software. Where both are unchanged, the result still holds."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from xneck.recording.recording_folder import Recording
from xneck.recording.software_versions import software_versions
from xneck_foundation.errors import Refused
from xneck_foundation.provenance import sha256


def fingerprint(recording: Recording) -> dict[str, Any]:
    """Versions, the digest of the sources, and of every file its name, size, time of change and SHA-256. Ready for JSON."""
    return software_versions() | {
        "inputs": {role: _file_entry(path, recording.folder) for role, path in _input_files(recording).items()}
    }


def refreshed_if_unchanged(before: Mapping[str, Any], recording: Recording) -> dict[str, Any] | None:
    """The fingerprint `before` with the files' present times of change, or None where software or content has changed.

    Size and time are looked at first, as make does; a file of which the time alone differs (copied, checked out anew) is hashed.
    A change within the file system's clock tick (some ms) that keeps the size is not noticed.
    """
    software, files, entries = software_versions(), _input_files(recording), before.get("inputs", {})
    if {key: before.get(key) for key in software} != software or entries.keys() != files.keys():
        return None
    refreshed = {role: _refreshed_entry(entries[role], path, recording.folder) for role, path in files.items()}
    return None if None in refreshed.values() else software | {"inputs": refreshed}


def _input_files(recording: Recording) -> dict[str, Path]:
    return {"recording": recording.config, **recording.files}


def _refreshed_entry(entry: Mapping[str, Any], path: Path, folder: Path) -> dict[str, Any] | None:
    """The entry of a file with its present time of change, or None where its content has changed."""
    present = _file_status(path, folder)
    if any(present[key] != entry.get(key) for key in ("file", "bytes")):
        return None
    if present["mtime_ns"] != entry.get("mtime_ns") and _sha256(path) != entry.get("sha256"):
        return None
    return {**entry, **present}


def _file_entry(path: Path, folder: Path) -> dict[str, Any]:
    # the time is taken first: a file that is changed while it is hashed counts as changed later
    return {**_file_status(path, folder), "sha256": _sha256(path)}


def _file_status(path: Path, folder: Path) -> dict[str, Any]:
    stat = path.stat()
    # what recordings share may lie outside of the folder
    return {"file": Path(os.path.relpath(path, folder)).as_posix(), "bytes": stat.st_size, "mtime_ns": stat.st_mtime_ns}


def _sha256(path: Path) -> str:
    try:
        return sha256(path)
    except OSError as error:
        raise Refused(path, f"cannot be read ({error.strerror})") from error
