"""How much each cause does in the equations of the motors and of the arm, beside all others."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause_fit import FitStage
from diagnosis.judged_rows import judged

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CauseShare:
    """RMS of what a cause does, in the equation of each kind in which it does most."""

    motors: float
    """N"""
    arm: float
    """N m"""

    def as_json(self) -> dict[str, float]:
        """For the record."""
        return {"motor_equation": self.motors, "arm_equation": self.arm}


def cause_shares(stage: FitStage) -> tuple[CauseShare, ...]:
    """Of every cause of a fit, by its amounts and what a unit of each does there."""
    at = stage.comparison.linearisation
    arm, out = at.hypothesis.arm, []
    for cause, columns in zip(stage.causes, stage.columns_of_causes, strict=True):
        amounts = cause.amounts / cause.sizes(arm)[: len(cause.amounts)]
        does = [
            judged(matrix[..., columns[: len(amounts)]] @ amounts, recording.signals)
            for matrix, recording in zip(stage.comparison.matrices, at.recordings, strict=True)
        ]
        rms = np.sqrt(np.mean(np.concatenate(does, axis=1) ** 2, axis=1))
        out.append(CauseShare(float(rms[: arm.M].max()), float(rms[arm.M :].max())))
    return tuple(out)
