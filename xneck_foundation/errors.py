"""The one exception that a person is meant to read."""

from collections.abc import Sequence
from pathlib import Path

from xneck_foundation.one_line import printable, shortened, unfolded
from xneck_foundation.spelling import quoted, valid_words

MAX_CHARACTERS = 480
"""longest line of a refusal; before it a command writes its name, or a batch the recording's"""
_MAX_WHERE = 160
"""characters of the line that `where` may take"""
_LEAST_WHAT = 160
"""characters that `what` may take however long `do` is: numbers in `do` are copied, so that `what` is cut before it"""
_WHERE_HEAD = 0.15
"""share of a long `where` that is kept of its beginning: a file's name stands at the end"""


class Refused(Exception):
    """Input that cannot be used, or a result that cannot be given: where, what, and what to do about it.

    The command line prints it as one line and exits with 1; from Python it is the only error to catch. As text it is one
    printable line of at most MAX_CHARACTERS; where, what and do hold all of it.
    """

    def __init__(self, where: str | Path, what: str, do: str = "") -> None:
        self.where = str(where)
        self.what = what
        self.do = do
        super().__init__(where, what, do)

    def __str__(self) -> str:
        where = shortened(printable(self.where), _MAX_WHERE, _WHERE_HEAD)
        what, do = unfolded(self.what), unfolded(self.do)
        left = MAX_CHARACTERS - len(where) - len(": ")
        do = f"; {shortened(do, left - min(len(what), _LEAST_WHAT) - len('; '))}" if do else ""
        what = shortened(what, left - len(do))
        return f"{where}: {what}{do}"


def one_of(where: str | Path, word: str, valid: Sequence[str], what: str) -> str:
    """`word` if it is one of `valid`, otherwise Refused with what was likely meant, or the valid ones."""
    if word not in valid:
        raise Refused(where, f"unknown {what} {quoted(word)}", valid_words(word, valid))
    return word
