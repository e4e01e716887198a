"""What angles may mean in place of those from bar to bar."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class OtherMeaning:
    """What angles may be in place of those from bar to bar."""

    words: str
    remedy: str
    """what to write in their place, in words"""
    alpha: Array
    """(K, N), rad, from bar to bar if they are so"""


def other_meanings(alpha: Array) -> Iterator[OtherMeaning]:
    """What angles (K, N), rad, may be: of bars against the picture, or counted from the tip, by a camera behind the arm too."""
    n = alpha.shape[1]
    if n == 1:
        return
    for sense, turned in ((1, ""), (-1, ", and turn the other way")):
        bars = sense * alpha
        upright = np.pi / 2 * np.round(np.mean(bars[:, 0]) / (np.pi / 2))
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
