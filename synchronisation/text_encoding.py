"""In which encoding a table of text is: UTF-8, or the one of Windows in Western Europe and America."""

import codecs
from pathlib import Path
from typing import TextIO

_LOOKED_AT_BYTES = 1 << 16
_CONTROL = bytes(set(range(32)) - set(b"\t\n\r\f\v"))
"""bytes that no text has"""


def open_text(path: Path) -> TextIO:
    """A table opened for reading, its line ends as they are. Raises OSError, and as it is read UnicodeDecodeError."""
    with path.open("rb") as stream:
        encoding = encoding_of(stream.read(_LOOKED_AT_BYTES))
    return path.open(newline="", encoding=encoding)


def encoding_of(begin: bytes) -> str:
    """By the first bytes of a file. Text that cannot be UTF-8 is Windows-1252, of which Latin-1 is a part.

    A file that is no text is said to be UTF-8, which it is not: reading it raises UnicodeDecodeError."""
    try:
        codecs.getincrementaldecoder("utf-8")().decode(begin)  # a letter may be cut at its end
    except UnicodeDecodeError:
        if len(begin.translate(None, delete=_CONTROL)) == len(begin):
            return "cp1252"
    return "utf-8-sig"
