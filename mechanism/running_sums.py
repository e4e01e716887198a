"""Running sums along mechanisms."""

from typing import Any, TypeVar

import numpy as np

Values = TypeVar("Values", bound=np.ndarray[Any, Any])


def running_sums(values: Values) -> Values:
    """Over the first axis; numpy's cumsum is ten times slower where that axis is short."""
    out = values.copy()
    for i in range(1, len(out)):
        out[i] += out[i - 1]
    return out
