"""What noise of the angles adds to a stage's columns: by it is told how loud noise is with other numbers."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.compare import column_matrices
from diagnosis.fit_stage import FitStage
from diagnosis.linearisation import linearise
from diagnosis.noise_ensemble import NoiseEnsemble
from diagnosis.nuisances import nuisances_at
from identification.residuals import residual_rows
from identification.signals import Signals

Array = NDArray[np.float64]


def noise_columns(stage: FitStage, ensembles: Sequence[NoiseEnsemble]) -> list[Array]:
    """Of a draw of each recording: what its noise changes of columns and residual, (C, S, K + 1), not whitened.

    The stage's own columns are free of vision's noise where they can be; here they are as the residual depends on them."""
    at = stage.comparison.linearisation
    read = [e.signals(at.hypothesis, float(lag)) for e, lag in zip(ensembles, at.frame_lags, strict=True)]
    noise_free, drawn = (_columns(stage, [signals[i] for signals in read]) for i in range(2))
    return [d - f for d, f in zip(drawn, noise_free, strict=True)]


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
