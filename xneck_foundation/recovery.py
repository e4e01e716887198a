"""Losses of damaged files, as warnings, so that both users of the library and the command line are told of them."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO


class Recovered(UserWarning):
    """A damaged file was read in part; the text says which, what happened to it, and what is lost."""


def warn_recovered(where: str | Path, what: str) -> None:
    """Warns that the file `where` is damaged; what: the damage and the loss, in words."""
    warnings.warn(Recovered(f"{where}: {what}"), stacklevel=2)


@contextmanager
def collected_recoveries() -> Iterator[list[str]]:
    """Texts of all `Recovered` warnings within the block, in order; they are not shown."""
    texts: list[str] = []
    with warnings.catch_warnings():
        show_others = warnings.showwarning

        def show(
            message: Warning | str,
            category: type[Warning],
            filename: str,
            lineno: int,
            file: TextIO | None = None,
            line: str | None = None,
        ) -> None:
            if issubclass(category, Recovered):
                texts.append(str(message))
            else:
                show_others(message, category, filename, lineno, file, line)

        warnings.showwarning = show
        warnings.simplefilter("always", Recovered)
        yield texts
