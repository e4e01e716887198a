"""The software that made a result: versions, and the digest of its sources."""

import platform
from pathlib import Path
from typing import Any

from xneck_foundation.provenance import versions
from xneck_foundation.source_digest import source_digest

_REPORT_FOLDERS = tuple(Path(__file__).parents[1] / name for name in ("report", "viewers"))
"""sources that change no number, but a result's files"""


def software_versions() -> dict[str, Any]:
    """Versions of xneck, Python and the libraries, and the digest of the sources that compute and report."""
    # a patch of Python changes no number, and machines of a cluster may differ in it
    python = ".".join(platform.python_version_tuple()[:2])
    return {**versions(), "python": python, "source": source_digest(*_REPORT_FOLDERS)}
