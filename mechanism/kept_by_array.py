"""What is computed of an array that nobody may write to, kept as long as the array lives.

Fits ask for the same functions of a recording's measured angles again and again, with other numbers before them.
"""

import weakref
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

T = TypeVar("T")

MOST_OF_ONE = 8
"""results of one array that are kept: inner constants that are fitted ask for others at every step"""


class KeptByArray(Generic[T]):
    """Results by array and key. Of an array that may be written to nothing is kept."""

    def __init__(self) -> None:
        self._kept: dict[int, tuple[weakref.ref[NDArray[np.float64]], dict[Hashable, T]]] = {}

    @staticmethod
    def keeps(array: object) -> bool:
        """Whether it is an array that nobody may write to, and none that equations are traced by."""
        return isinstance(array, np.ndarray) and not array.flags.writeable

    def get(self, array: NDArray[np.float64], key: Hashable, make: Callable[[], T]) -> T:
        """What `make` returns for this array and key, made once."""
        if not self.keeps(array):
            return make()
        number = id(array)
        if number not in self._kept:
            # an array's number is another one's after it is gone
            self._kept[number] = weakref.ref(array, lambda _: self._kept.pop(number, None)), {}
        results = self._kept[number][1]
        if key not in results:
            if len(results) == MOST_OF_ONE:
                results.clear()
            results[key] = make()
        return results[key]

    def __len__(self) -> int:
        return sum(len(results) for _, results in self._kept.values())
