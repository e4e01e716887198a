"""Libraries that only some files need: imported when one is read, and named where they are missing."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from xneck_foundation.errors import Refused


@contextmanager
def needs_extra(extra: str, library: str, where: str | Path) -> Iterator[None]:
    """Within the block `library` is imported; Refused, with the extra to install, where it is not there."""
    try:
        yield
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != library:
            raise
        raise Refused(where, f"needs the library {library}", f"pip install 'xneck[{extra}]'") from error
