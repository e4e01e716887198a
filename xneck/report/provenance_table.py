"""What went into a page: files with their hashes, and what computed them."""

from collections.abc import Mapping
from typing import Any

from xneck.report.number_text import file_size


def input_file_rows(provenance: Mapping[str, Any]) -> list[tuple[str, str, str, str]]:
    """Role, file, size, SHA-256 of every file that went in."""
    inputs = provenance.get("inputs", {})
    return [(role, entry["file"], file_size(entry["bytes"]), entry["sha256"]) for role, entry in inputs.items()]


def version_text(provenance: Mapping[str, Any]) -> str:
    """What computed it."""
    libraries = [f"{name} {version}" for name, version in provenance.get("libraries", {}).items()]
    return ", ".join([f"xneck {provenance.get('xneck', '?')}", f"Python {provenance.get('python', '?')}", *libraries])
