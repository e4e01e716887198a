"""Standard deviations of independent errors that enter the same residuals, told by the likelihood of these."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def likelier_sizes(
    residual: Array,
    factors: Array,
    source: NDArray[np.intp],
    size: Array,
    least: Array | float,
    steps: int,
    known: Array | float = 0.0,
) -> Array:
    """Standard deviations (S,) of errors, from residuals (T, D) and a guess, in so many steps.

    factors: (T, D, R), how errors of unit size enter; source: (R,), which of the S errors' sizes each of them has; least: (S,) or
    one, below which no size is taken to be; known: (T, D, D) or (D, D), covariance of what enters besides.

    Components of variance by steps that raise the likelihood (minorisation and maximisation; Zhou, Hu, Zhou, Lange 2019)."""
    for _ in range(steps):
        told = np.linalg.inv(covariance_of(factors, source, size) + known) @ factors
        seen = np.sum(np.einsum("tdr,td->tr", told, residual) ** 2, axis=0)
        expected = np.einsum("tdr,tdr->r", told, factors)
        of_seen, of_expected = (np.bincount(source, values, len(size)) for values in (seen, expected))
        # what enters nowhere keeps its size
        ratio = np.divide(of_seen, of_expected, out=np.ones(len(size)), where=of_expected > 0)
        size = np.maximum(size * ratio**0.25, least)
    return size


def covariance_of(factors: Array, source: NDArray[np.intp], size: Array) -> Array:
    """Covariance (T, D, D) of residuals that errors of these sizes (S,) enter; as in `likelier_sizes`."""
    scaled = factors * size[source]
    return scaled @ np.swapaxes(scaled, 1, 2)
