"""What a page was made from: input files with their hashes, and the versions of the software."""

from collections.abc import Mapping
from typing import Any

from xneck.report.number_text import file_size


def input_file_rows(provenance: Mapping[str, Any]) -> list[tuple[str, str, str, str]]:
    """Rows of the table of input files: role, file, size, SHA-256."""
    inputs = provenance.get("inputs", {})
    return [(role, entry["file"], file_size(entry["bytes"]), entry["sha256"]) for role, entry in inputs.items()]


def version_text(provenance: Mapping[str, Any]) -> str:
    """Versions of xneck, Python and the libraries in one line."""
    libraries = [f"{name} {version}" for name, version in provenance.get("libraries", {}).items()]
    return ", ".join([f"xneck {provenance.get('xneck', '?')}", f"Python {provenance.get('python', '?')}", *libraries])
