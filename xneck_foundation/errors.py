"""The one exception that a person is meant to read."""

from pathlib import Path


class Refused(Exception):
    """Input that cannot be used, or a result that cannot be given: where, what, and what to do about it.

    The command line prints it as one line and exits with 1; from Python it is the only error to catch.
    """

    def __init__(self, where: str | Path, what: str, do: str = "") -> None:
        self.where = str(where)
        self.what = what
        self.do = do
        super().__init__(f"{where}: {what}" + (f"; {do}" if do else ""))


def one_of(where: str | Path, word: str, valid: list[str] | tuple[str, ...], what: str) -> str:
    """`word` if it is one of `valid`, otherwise Refused with the list of valid ones."""
    if word not in valid:
        raise Refused(where, f"unknown {what} {word!r}", f"valid: {', '.join(valid)}")
    return word
