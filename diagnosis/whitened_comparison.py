"""A comparison beside which the columns of one effect or another are taken, its own whitened once."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.comparison import Comparison, EffectColumns
from diagnosis.effect import Effect, Shape
from identification.fitting import segment_starts
from identification.whitening import Whitener

Array = NDArray[np.float64]


class WhitenedComparison:
    """A comparison whose columns are whitened once, to be taken with those of one effect or another beside it.

    No blocks are kept: it answers for fits, and not for what they leave where they were not fitted."""

    def __init__(self, comparison: Comparison, whiten: Whitener) -> None:
        self._comparison, self._whiten = comparison, whiten
        self._white = self._whitened(comparison.matrices)
        self._products = sum((w.T @ w for w in self._white), start=np.zeros(()))

    def beside(self, effect: Effect, shape: Shape) -> Comparison:
        """The comparison with an effect's columns behind all others."""
        c = self._comparison
        recordings, arm = c.linearisation.recordings, c.linearisation.hypothesis.arm
        further = [effect.columns(recording, shape) * effect.sizes(arm) for recording in recordings]
        white, count, width = self._whitened(further), len(c.prior_sigma), further[0].shape[2]
        of_base, new = [*range(count), count + width], slice(count, count + width)
        products = np.empty((count + width + 1, count + width + 1))
        products[np.ix_(of_base, of_base)] = self._products
        products[of_base, new] = sum((b.T @ w for b, w in zip(self._white, white, strict=True)), start=np.zeros(()))
        products[new, of_base] = products[of_base, new].T
        products[new, new] = sum((w.T @ w for w in white), start=np.zeros(()))
        free = np.full(width, np.inf)
        return replace(
            c,
            matrices=tuple(
                np.concatenate([m[..., :-1], f, m[..., -1:]], axis=2) for m, f in zip(c.matrices, further, strict=True)
            ),
            groups=(EffectColumns(effect, shape, np.arange(count, count + width)),),
            block_products=products[None],
            noise_products=np.zeros((1, count + width, 0)),
            prior_sigma=np.append(c.prior_sigma, free),
            relaxed_sigma=np.append(c.relaxed_sigma, free),
            prior_mean=np.append(c.prior_mean, np.zeros(width)),
            lower_bounds=np.append(c.lower_bounds, -free),
            upper_bounds=np.append(c.upper_bounds, free),
        )

    def _whitened(self, matrices: Sequence[Array]) -> list[Array]:
        pairs = zip(matrices, self._comparison.linearisation.recordings, strict=True)
        return [self._whiten(m, segment_starts(r.signals), r.input_variance).reshape(-1, m.shape[2]) for m, r in pairs]
