"""A folder of results as one zip archive that says what is in it: a research object for an archive such as Zenodo."""

import hashlib
import zipfile
from collections.abc import Iterator, Sequence
from datetime import date
from pathlib import Path
from typing import Any

from xneck.export.crate_metadata import (
    METADATA,
    Origin,
    PackageOptions,
    PackedFile,
    crate_metadata,
    missing_words,
)
from xneck_foundation.authorship import written_by_xneck
from xneck_foundation.errors import Refused
from xneck_foundation.input_file import file_identity, refuse_changed
from xneck_foundation.json_text import json_text, read_record
from xneck_foundation.same_file import real_path
from xneck_foundation.whole_file import whole_file

_STAMP = (1980, 1, 1, 0, 0, 0)
"""of every file in the archive, so that the same results give the same bytes"""
_BLOCK_BYTES = 1 << 20
_RECORDS = ("result.json", "diagnosis.json", "study.json")
"""that may say what the files beside them were made from"""


def write_package(folder: Path, path: Path, options: PackageOptions) -> dict[str, Any]:
    """Writes the archive, whole or not at all, and returns what is in it and what it does not say, ready for JSON.

    Hidden files and links are left out, and named. Raises Refused where the archive would lie in the folder, there is nothing in
    it, licence, author or date cannot be read, or a file changes meanwhile.
    """
    day = _date(options.date)
    if real_path(path).is_relative_to(real_path(folder)):
        raise Refused(path, "lies in the folder that goes into it", "write it beside the folder")
    files, left_out = _files(folder)
    if not files:
        raise Refused(folder, "holds no files", "give a folder of results")
    if any(name.casefold() == METADATA for name in files):
        raise Refused(folder, f"holds a {METADATA} already", "it is packed: give the folder that xneck wrote")
    crate_metadata("", day, options, (), ())  # refuses licence and author before the work
    with whole_file(path) as part, zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as archive:
        packed = [_packed(folder / name, name, archive) for name in files]
        metadata = crate_metadata(
            options.title or folder.resolve().name, day, options, packed, list(_origins(folder, files))
        )
        archive.writestr(zipfile.ZipInfo(METADATA, _STAMP), json_text(metadata))
    return {
        "file": path.name,
        "format": "RO-Crate 1.1",
        "bytes": path.stat().st_size,
        "files": [{"file": f.name, "bytes": f.bytes, "sha256": f.sha256, "as_written": f.as_written} for f in packed],
        "left_out": left_out,
        "missing": missing_words(options, packed) + ([f"left out: {', '.join(left_out)}"] if left_out else []),
    }


def _date(text: str | None) -> str:
    if text is None:
        return date.today().isoformat()
    try:
        return date.fromisoformat(text).isoformat()
    except ValueError as error:
        raise Refused("--date", f"{text!r} is no date", "write it as 2026-01-31") from error


def _files(folder: Path) -> tuple[list[str], list[str]]:
    """Names of the files, with slashes, in order; and of what is left out: hidden, a link, or no regular file."""
    files, left_out = [], []
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if path.is_symlink() or any(part.startswith(".") for part in path.relative_to(folder).parts):
            left_out.append(name)
        elif path.is_file():
            files.append(name)
        elif not path.is_dir():
            left_out.append(name)
    return files, left_out


def _packed(path: Path, name: str, archive: zipfile.ZipFile) -> PackedFile:
    """Copies a file into the archive; its hash is that of the bytes that went there."""
    before, as_written = file_identity(path), written_by_xneck(path)
    digest = hashlib.sha256()
    info = zipfile.ZipInfo(name, _STAMP)
    info.compress_type, info.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
    with path.open("rb") as source, archive.open(info, "w", force_zip64=True) as target:
        while block := source.read(_BLOCK_BYTES):
            digest.update(block)
            target.write(block)
    refuse_changed(path, before)
    return PackedFile(name, before.bytes, digest.hexdigest(), as_written)


def _origins(folder: Path, files: Sequence[str]) -> Iterator[Origin]:
    """What records in the folder say of themselves and of the files beside them; an edited record says nothing."""
    for name in files:
        if Path(name).name not in _RECORDS:
            continue
        try:
            record = read_record(folder / name)
        except (OSError, ValueError):
            continue
        made_from = record.get("made_from") or record.get("provenance")
        if isinstance(made_from, dict):
            yield Origin(name, made_from.get("inputs") or {}, made_from)
