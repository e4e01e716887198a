"""Which markers stand still in the picture: the same pixels show their edges in every frame."""

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]

STANDING_SHARE = 0.02
"""of its side: a marker that never goes further from its mean place stands still (docs/thresholds.md)"""


def side_lengths(image: Complex) -> NDArray[np.float64]:
    """Mean side of each marker, (markers,), in the unit of its corners (F, markers, 4), NaN where never found."""
    side = np.abs(np.roll(image, -1, axis=-1) - image).mean(axis=-1)
    return np.array([np.mean(s[~np.isnan(s)]) if not np.isnan(s).all() else np.nan for s in side.T])


def standing_markers(image: Complex, share: float = STANDING_SHARE) -> NDArray[np.bool_]:
    """Which markers stand still, (markers,), by their corners (F, markers, 4), NaN where not found; one never found does not.

    share: of its side, by which a marker may be beside its mean place."""
    standing = np.zeros(image.shape[1], dtype=bool)
    for k, side in enumerate(side_lengths(image)):
        middle = image[~np.isnan(image[:, k]).any(axis=1), k].mean(axis=1)
        standing[k] = len(middle) > 0 and np.abs(middle - middle.mean()).max() < share * side
    return standing
