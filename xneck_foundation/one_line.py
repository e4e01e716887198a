"""Text for one line of a terminal or a log: nothing in it that a terminal obeys, and no longer than a person reads."""

from collections.abc import Iterable

LIST_CHARACTERS = 200
"""characters of a list before the rest of it is counted instead of named"""


def printable(text: str) -> str:
    """`text` with all that does not print as escapes, such as \\x1b: values and names of files may hold a terminal's commands.

    Also line ends, marks that turn the direction of writing, and bytes of a file's name that are no UTF-8.
    """
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def unfolded(text: str) -> str:
    """Prose of several lines on one, and printable."""
    return printable(" ".join(text.split()))


def shortened(text: str, limit: int, head: float = 0.6) -> str:
    """`text` in `limit` characters at most: of a longer one the middle is left out, `head` is the share kept of its beginning."""
    if len(text) <= limit:
        return text
    mark = " ... "
    before = round(head * (limit - len(mark)))
    return text[:before] + mark + text[len(text) - (limit - len(mark) - before) :]


def counted(count: int, word: str) -> str:
    """`1 cable`, `6 cables`."""
    return f"{count} {word}{'' if count == 1 else 's'}"


def indexed(name: str, index: int | None) -> str:
    """A number's name with that of its cable, joint or motor from 1: `k(3)`; `cm` where there is one of a kind."""
    return name if index is None else f"{name}({index})"


def listed(words: Iterable[str], separator: str = ", ", limit: int = LIST_CHARACTERS) -> str:
    """`words` up to about `limit` characters, at least one of them, and how many more there are: `a, b, ... and 17 more`."""
    words = list(words)
    shown: list[str] = []
    for word in words:
        if shown and sum(map(len, shown)) + len(separator) * len(shown) + len(word) > limit:
            return separator.join([*shown, f"... and {len(words) - len(shown)} more"])
        shown.append(shortened(word, limit))
    return separator.join(shown)
