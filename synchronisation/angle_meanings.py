"""What angles may mean in place of those from bar to bar."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from xneck_foundation.one_line import listed

Array = NDArray[np.float64]


@dataclass(frozen=True)
class OtherMeaning:
    """What angles may be in place of those from bar to bar."""

    words: str
    remedy: str
    """what to write in their place, in words"""
    alpha: Array
    """(K, N), rad, from bar to bar if they are so"""


def quarter_turns(alpha: Array) -> Array:
    """(N,), rad: by how many quarter turns angles (K, N) stand about another place than zero, about which joints of an arm turn."""
    return np.pi / 2 * np.round(np.mean(alpha, axis=0) / (np.pi / 2))


def other_meanings(alpha: Array) -> Iterator[OtherMeaning]:
    """What angles (K, N), rad, may be: quarter turns while the arm stands straight, those of bars against the picture, or counted
    from the tip, by a camera behind the arm too."""
    n = alpha.shape[1]
    if np.any(turns := quarter_turns(alpha)):
        reads, remedies = [], []
        for turn in np.unique(turns[turns != 0]):
            names = listed(f"alpha{i + 1}" for i in np.flatnonzero(turns == turn))
            reads.append(f"{names} {'reads' if np.sum(turns == turn) == 1 else 'read'} {np.degrees(turn):.0f} deg")
            remedies.append(f"subtract {turn:.6f} from {names}" if turn > 0 else f"add {-turn:.6f} to {names}")
        words = f"{' and '.join(reads)} while the arm stands straight"
        yield OtherMeaning(words, " and ".join(remedies), alpha - turns)
    if n == 1:
        return
    for sense, turned in ((1, ""), (-1, ", and turn the other way")):
        bars = sense * alpha
        upright = quarter_turns(bars)[0]
        less = f" less {np.degrees(upright):.0f} deg" if upright else ""
        yield OtherMeaning(
            f"alpha1..{n} are angles of the bars in the picture, not from bar to bar{turned}",
            f"subtract from each bar's angle that of the bar below it; the first is alpha1{less}",
            np.diff(bars - upright, prepend=0.0, axis=1),
        )
    from_tip = f"alpha1..{n} are counted from the tip"
    yield OtherMeaning(from_tip, "write the last one first", alpha[:, ::-1])
    yield OtherMeaning(
        f"{from_tip}, and turn the other way", "write the last one first, and all with the other sign", -alpha[:, ::-1]
    )
