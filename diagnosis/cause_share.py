"""What each cause does in the equations, beside what nothing named explains there."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause_fit import FitStage
from diagnosis.judged_rows import judged

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CauseShare:
    """Of one cause, by equation, the motors' (N) before the arm's (N m): RMS of what it does in the residuals as judged, (C,)."""

    does: Array
    left: Array
    """what nothing named explains there beyond noise"""
    floor: Array
    """what noise alone leaves there"""

    @property
    def outweighed(self) -> float:
        """What is left over what the cause does, in the equation in which it does most, counted in noise."""
        where = int(np.argmax(self.does / self.floor))
        return float(self.left[where] / self.does[where])


def cause_shares(stage: FitStage) -> tuple[CauseShare, ...]:
    """Of every cause of a fit, by its columns where it is."""
    at, excess = stage.comparison.linearisation, stage.excess
    left = np.sqrt(np.maximum(excess.rms**2 - excess.floor**2, 0.0))
    out = []
    for cause, columns in zip(stage.causes, stage.columns_of_causes, strict=True):
        amounts = cause.amounts / cause.sizes(at.hypothesis.arm)[: len(cause.amounts)]
        does = [
            judged(matrix[..., columns[: len(amounts)]] @ amounts, recording.signals)
            for matrix, recording in zip(stage.comparison.matrices, at.recordings, strict=True)
        ]
        rms = np.sqrt(np.mean(np.concatenate(does, axis=1) ** 2, axis=1))
        out.append(CauseShare(rms, left, excess.floor))
    return tuple(out)
