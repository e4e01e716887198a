"""What happens to files: cut off, bits that turn over, rows lost or doubled, numbers that are none, clocks that jump."""

from collections.abc import Callable

from hypothesis import strategies as st

Damage = Callable[[bytes], bytes]

NUMBERS = (
    "nan",
    "inf",
    "-inf",
    "1e308",
    "-1e308",
    "1e-320",
    "",
    "abc",
    "1,5",
    "1e999",
    "0x1F",
    "1_0",
    "９",
    "1e18",
    "-0.0",
)
"""what may stand where a number should"""
PUT = (
    *(
        ".nan",
        ".inf",
        "-1",
        "0",
        "1e308",
        "1e-320",
        '"text"',
        "null",
        "[]",
        "{}",
        "true",
        "9" * 5000,
        "- 1",
        "&a x",
        "*a",
    ),
    *(
        "!!python/name:os.system",
        "[" * 3000,
        '"\\0"',
        "é𝛼",
        "? x",
        "%",
        "!!binary aGk=",
        "!!timestamp 2001-01-01",
        "<<",
    ),
)
"""what may stand where a value of a YAML should"""
CLOCKS = (-1e9, -1.0, -1e-3, 1e-3, 1.0, 3600.0, 1e9, 1e18)
"""s by which a clock may jump"""


@st.composite
def of_bytes(draw: st.DrawFn) -> Damage:
    """A file of any kind: cut at a byte, or with a few bits, bytes or stretches that are not its own."""
    kind = draw(st.sampled_from(["cut", "flip", "stretch", "insert", "remove", "end"]))
    at = draw(st.floats(0, 1, exclude_max=True))
    others = draw(st.lists(st.tuples(st.floats(0, 1, exclude_max=True), st.integers(0, 7)), min_size=1, max_size=6))
    filler = draw(st.binary(min_size=1, max_size=24))
    length = draw(st.integers(1, 400))

    def damaged(whole: bytes) -> bytes:
        k = int(at * len(whole))
        if kind == "cut":
            return whole[:k]
        if kind == "flip":
            made = bytearray(whole)
            for place, bit in others:
                made[int(place * len(made))] ^= 1 << bit
            return bytes(made)
        if kind == "stretch":
            return whole[:k] + (filler * length)[:length] + whole[k + length :]
        if kind == "insert":
            return whole[:k] + filler + whole[k:]
        if kind == "remove":
            return whole[:k] + whole[k + length :]
        return whole + filler

    return damaged


@st.composite
def of_rows(draw: st.DrawFn) -> Damage:
    """A table with a header: rows lost, doubled, exchanged, half-written; cells that are no numbers; a clock that jumps."""
    kind = draw(st.sampled_from(["lose", "double", "exchange", "half", "cells", "column", "jump", "reverse", "header"]))
    places = draw(st.lists(st.floats(0, 1, exclude_max=True), min_size=2, max_size=4))
    cell = draw(st.floats(0, 1, exclude_max=True))
    word = draw(st.sampled_from(NUMBERS))
    jump = draw(st.sampled_from(CLOCKS))

    def damaged(whole: bytes) -> bytes:
        header, *rows = whole.decode().splitlines()
        at = [int(place * len(rows)) for place in places]
        column = int(cell * len(header.split(",")))
        if kind == "lose":
            rows = rows[: min(at)] + rows[max(at) :]
        elif kind == "double":
            rows = rows[: at[0]] + rows[min(at) : max(at) + 1] + rows[at[0] :]
        elif kind == "exchange":
            rows[at[0]], rows[at[1]] = rows[at[1]], rows[at[0]]
        elif kind == "half":
            rows[at[0]] = rows[at[0]][: int(cell * len(rows[at[0]]))]
        elif kind == "cells":
            for k in at:
                rows[k] = _with(rows[k], column, word)
        elif kind == "column":
            rows = [_with(row, column, word) for row in rows]
        elif kind == "jump":
            rows = [row if k < at[0] else _later(row, jump) for k, row in enumerate(rows)]
        elif kind == "reverse":
            rows = rows[: min(at)] + rows[min(at) :][::-1]
        else:
            header = _with(header, column, word)
        return "\n".join([header, *rows, ""]).encode()

    return damaged


@st.composite
def of_values(draw: st.DrawFn) -> Damage:
    """A YAML of one value a place: some number, word or key becomes something else."""
    place = draw(st.floats(0, 1, exclude_max=True))
    put = draw(st.sampled_from(PUT))

    def damaged(whole: bytes) -> bytes:
        lines = whole.decode().splitlines()
        k = int(place * len(lines))
        key, colon, _ = lines[k].rpartition(": ")
        lines[k] = f"{key}{colon}{put}"
        return "\n".join([*lines, ""]).encode()

    return damaged


def _with(row: str, column: int, word: str) -> str:
    cells = row.split(",")
    cells[min(column, len(cells) - 1)] = word
    return ",".join(cells)


def _later(row: str, by: float) -> str:
    time, comma, rest = row.partition(",")
    return f"{float(time) + by!r}{comma}{rest}"
