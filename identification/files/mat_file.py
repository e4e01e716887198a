"""MATLAB's .mat files that are the same whenever they are written."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from xneck_foundation.authorship import MARK
from xneck_foundation.whole_file import whole_file

_DESCRIPTION = f"MATLAB 5.0 MAT-file, {MARK}".ljust(116).encode()
"""the text that a .mat begins with; scipy writes the hour into it"""


def write_mat_file(content: Mapping[str, Any], path: str | Path) -> None:
    """Variables by name; arrays (T,) become columns."""
    from scipy.io import savemat

    with whole_file(path) as part, part.open("wb") as stream:
        savemat(stream, content, oned_as="column", long_field_names=True)
        stream.seek(0)
        stream.write(_DESCRIPTION)
