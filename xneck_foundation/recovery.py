"""What a damaged file no longer holds: said as a warning, so that a library's user and the command line both hear it."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO


class Recovered(UserWarning):
    """A file was read as far as it is whole; the text says which, what happened to it, and what is lost."""


def warn_recovered(where: str | Path, what: str) -> None:
    """Warns of what is lost in the file `where`."""
    warnings.warn(Recovered(f"{where}: {what}"), stacklevel=2)


@contextmanager
def collected_recoveries() -> Iterator[list[str]]:
    """The texts of all files recovered within the block, in the order in which they were read; nobody else hears of them."""
    said: list[str] = []
    with warnings.catch_warnings():
        others = warnings.showwarning

        def show(
            message: Warning | str,
            category: type[Warning],
            filename: str,
            lineno: int,
            file: TextIO | None = None,
            line: str | None = None,
        ) -> None:
            if issubclass(category, Recovered):
                said.append(str(message))
            else:
                others(message, category, filename, lineno, file, line)

        warnings.showwarning = show
        warnings.simplefilter("always", Recovered)
        yield said
