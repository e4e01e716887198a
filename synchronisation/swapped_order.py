"""Two columns in each other's places."""


def swapped_order(count: int, a: int, b: int) -> list[int]:
    """The order of so many columns with two of them, counted from 0, in each other's places."""
    order = list(range(count))
    order[a], order[b] = b, a
    return order
