"""Lists of words and names as people write them."""

from collections.abc import Sequence


def join_words(words: Sequence[str]) -> str:
    """Such as `a`, `a and b`, or `a, b and c`."""
    return " and ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else "".join(words)


def with_spaces(name: str) -> str:
    """The name of an effect or a fault with spaces for underscores."""
    return name.replace("_", " ")
