"""A number at the head of a page."""

from dataclasses import dataclass


@dataclass(frozen=True)
class KeyNumber:
    """A number with its label, and a note on what it counts."""

    label: str
    value: str
    note: str
