"""What noise of the angles adds to a stage's columns: by it is told how loud noise is with other numbers."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.compare import column_matrices
from diagnosis.fit_stage import FitStage
from diagnosis.linearisation import corrected_signals, linearise
from diagnosis.noise_ensemble import NoiseEnsemble
from diagnosis.nuisances import nuisances_at
from identification.dataset.dataset import DataSet
from identification.residuals import residual_rows

Array = NDArray[np.float64]


def noise_columns(stage: FitStage, ensembles: Sequence[NoiseEnsemble]) -> list[Array]:
    """Of a draw of each recording: what its noise changes of columns and residual, (C, S, K + 1), not whitened.

    The stage's own columns are free of vision's noise where they can be; here they are as the residual depends on them."""
    drawn = _columns(stage, [ensemble.draws[0] for ensemble in ensembles])
    noise_free = _columns(stage, [ensemble.noise_free for ensemble in ensembles])
    return [d - f for d, f in zip(drawn, noise_free, strict=True)]


def _columns(stage: FitStage, data: Sequence[DataSet]) -> list[Array]:
    at = stage.comparison.linearisation
    h, u, p = at.hypothesis, at.unknowns, at.p
    signals = [
        s for d, lag in zip(data, at.frame_lags, strict=True) for s in corrected_signals(h, [d], np.array([lag]))
    ]
    other = linearise(h, signals, p, at.frame_lags)
    by_vision = [
        replace(mine, rows=residual_rows(s, u, p, r, theirs.tension))
        for r, (mine, theirs, s) in enumerate(zip(other.recordings, at.recordings, signals, strict=True))
    ]
    other = replace(other, recordings=tuple(by_vision))
    return column_matrices(other, stage.causes, (), nuisances_at(other))[0]
