"""Columns in each other's places: their order, and what is said of it."""

from collections.abc import Sequence


def swapped_order(count: int, a: int, b: int) -> list[int]:
    """The order of so many columns with two of them, counted from 0, in each other's places."""
    order = list(range(count))
    order[a], order[b] = b, a
    return order


def order_words(stem: str, order: Sequence[int]) -> str:
    """That columns are in another order: order[j] is the column of motor j, both counted from 0; empty where each is its own's."""
    moved = [j for j, column in enumerate(order) if column != j]
    if len(moved) == 2:
        return f"{stem}{moved[0] + 1} and {stem}{moved[1] + 1} are swapped"
    held = ", ".join(f"{stem}{order[j] + 1} is motor {j + 1}'s" for j in moved)
    return f"{stem} columns are in another order: {held}" if held else ""
