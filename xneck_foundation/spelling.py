"""Words that are not known: the one that was likely meant, or those that are valid."""

from collections.abc import Iterable
from difflib import get_close_matches

from xneck_foundation.one_line import listed, shortened

_MAX_LETTERS = 60
"""longer words are not compared: no word of ours is half as long, and the time grows with the square"""
_MIN_BEGINNING = 3
"""letters that two words share at their beginning, where the shorter is all of it"""
_MAX_WORDS = 500
"""so many words are compared at most, of a header for instance"""


def likely_spelling(word: str, valid: Iterable[str]) -> str | None:
    """The one of `valid` that was likely meant by `word`, whatever its capitals; None where none is alike."""
    by_small = {one.casefold(): one for one in list(valid)[:_MAX_WORDS] if len(one) <= _MAX_LETTERS}
    close = get_close_matches(word.casefold(), by_small, n=1) if len(word) <= _MAX_LETTERS else []
    if close:
        return by_small[close[0]]
    begun = [one for small, one in by_small.items() if _begins(small, word.casefold())]
    return begun[0] if len(begun) == 1 else None


def _begins(first: str, second: str) -> bool:
    """Whether one of two words is the beginning of the other: `sync` of `synchronise`."""
    return min(len(first), len(second)) >= _MIN_BEGINNING and (first.startswith(second) or second.startswith(first))


def valid_words(word: str, valid: Iterable[str]) -> str:
    """What to write instead of `word`: `did you mean stiffness?`, or the valid words where none is alike."""
    valid = list(valid)
    likely = likely_spelling(word, valid)
    return f"did you mean {likely}?" if likely is not None else f"valid: {listed(valid)}"


def quoted(word: str) -> str:
    """A word as it was found, in quotes and shortened."""
    return repr(shortened(word, _MAX_LETTERS))
