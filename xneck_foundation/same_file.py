"""Whether two paths lead to one file."""

import os
from pathlib import Path


def same_file(first: Path, second: Path) -> bool:
    """Whether two paths lead to one file, through links of either kind, or would once it is written."""
    if first.exists() and second.exists() and os.path.samefile(first, second):
        return True
    return real_path(first) == real_path(second)


def real_path(path: Path) -> Path:
    """The path without links, and in one case where the system knows no cases. Links in a circle stay as they are."""
    return Path(os.path.normcase(os.path.realpath(path)))
