"""How far apart an arm's markers can be, in whatever pose it is."""

import numpy as np
from numpy.typing import NDArray

from mechanism.description import Neck, markers_of

Array = NDArray[np.float64]


def arm_reach(neck: Neck) -> Array:
    """Largest distance between the middles of two markers, (markers, markers), in sides of a marker.

    The middles of two neighbouring bars are never further apart than the diagonals between them are long.
    """
    markers = markers_of(neck, "neck.yaml")
    height = np.cumsum([0.0, *(m.L for m in neck.mechanisms)])
    bar, from_bar = [], []
    for marker in markers.on_bars:
        top = marker.mechanism
        bar.append(height[marker.bar if top is None else top])
        to_diagonal = 0.0 if top is None else (neck.mechanisms[top - 1].L + neck.mechanisms[top - 1].b) / 2
        from_bar.append(float(np.hypot(*marker.at)) + to_diagonal)
    at, away = np.array(bar), np.array(from_bar)
    return (np.abs(at[:, None] - at) + away[:, None] + away) / markers.size
