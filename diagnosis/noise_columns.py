"""What noise of the angles adds to a stage's columns: by it is told how loud noise is with other numbers."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.compare import column_matrices
from diagnosis.fit_stage import FitStage
from diagnosis.linearisation import linearise
from diagnosis.noise_ensemble import NoiseEnsemble
from diagnosis.nuisances import nuisances_at
from identification.fitting import segment_starts
from identification.residuals import residual_rows
from identification.signals import Signals
from identification.whitening import Whitener

Array = NDArray[np.float64]


def noise_columns(stage: FitStage, ensembles: Sequence[NoiseEnsemble]) -> list[Array]:
    """Of a draw of each recording: what its noise changes of columns and residual, (C, S, K + 1), not whitened.

    The stage's own columns are free of vision's noise where they can be; here they are as the residual depends on them."""
    return _changed_by_noise(stage, ensembles, _columns)


def score_of_noise(stage: FitStage, ensembles: Sequence[NoiseEnsemble], whiten: Whitener) -> Array:
    """What noise alone makes of the products of a stage's columns with its residual, where both hold it, (K,).

    An arm that is smaller and lighter as a whole makes less of the angles' noise. Least squares take that for a better fit, and
    find every number by a part of its tolerance too small, however little noise there is. One draw tells it, in so many rows."""
    recordings, noise = stage.comparison.linearisation.recordings, _changed_by_noise(stage, ensembles, _read_columns)
    score = np.zeros(noise[0].shape[-1] - 1)
    for changed, r in zip(noise, recordings, strict=True):
        rows = whiten(changed, segment_starts(r.signals), r.input_variance)
        score += np.einsum("csk,cs->k", rows[..., :-1], rows[..., -1])
    return score


def _changed_by_noise(
    stage: FitStage,
    ensembles: Sequence[NoiseEnsemble],
    columns: Callable[[FitStage, Sequence[Signals]], list[Array]],
) -> list[Array]:
    """What a draw of each recording's noise changes of columns and residual, (C, S, K + 1), not whitened."""
    at = stage.comparison.linearisation
    read = [e.signals(at.hypothesis, float(lag)) for e, lag in zip(ensembles, at.frame_lags, strict=True)]
    noise_free, drawn = (columns(stage, [signals[i] for signals in read]) for i in range(2))
    return [d - f for d, f in zip(drawn, noise_free, strict=True)]


def _read_columns(stage: FitStage, signals: Sequence[Signals]) -> list[Array]:
    """Columns as the fit has them, and residual, of other recordings of the same motions."""
    at = stage.comparison.linearisation
    other = linearise(at.hypothesis, signals, at.p, at.frame_lags)
    return column_matrices(other, stage.causes, (), nuisances_at(other))[0]


def _columns(stage: FitStage, signals: Sequence[Signals]) -> list[Array]:
    at = stage.comparison.linearisation
    h, u, p = at.hypothesis, at.unknowns, at.p
    other = linearise(h, signals, p, at.frame_lags)
    by_vision = [
        replace(mine, rows=residual_rows(replace(s, remembered=theirs.signals.remembered), u, p, r, theirs.tension))
        for r, (mine, theirs, s) in enumerate(zip(other.recordings, at.recordings, signals, strict=True))
    ]
    other = replace(other, recordings=tuple(by_vision))
    return column_matrices(other, stage.causes, (), nuisances_at(other))[0]
