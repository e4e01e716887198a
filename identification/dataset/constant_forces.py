"""Forces of a log that never change: of a cable that none pulls, or all pull alike, nothing says how far it stretches."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series


@dataclass(frozen=True)
class ConstantForces:
    """The motors whose force is the same in every row."""

    motors: NDArray[np.intp]
    """from 0"""
    tell_nothing: bool
    """whether those of all motors are, or that of one is zero, which holds no cable taut"""
    words: str
    """which, and at what force"""


def constant_forces(log: Series) -> ConstantForces | None:
    """Those of a log with columns fJ, N; None where every force changes, or none is logged."""
    f = log.matrix("f")
    still = np.flatnonzero(np.ptp(f, axis=0) == 0)
    if not len(still):
        return None
    columns = ", ".join(f"f{j + 1}" for j in still)
    levels = " and ".join(f"{level:g}" for level in np.unique(f[0, still]))
    words = f"{columns} {'stays' if len(still) == 1 else 'stay'} at {levels} N in every row"
    return ConstantForces(still, len(still) == f.shape[1] or bool(np.any(f[0, still] == 0)), words)
