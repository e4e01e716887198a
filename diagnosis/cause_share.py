"""How much each cause does beside all others: in the equations of the motors and of the arm, and to simulated angles."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import zip_longest

import numpy as np
from numpy.typing import NDArray

from diagnosis.fit_stage import FitStage
from diagnosis.judged_rows import judged

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CauseShare:
    """RMS of what a cause does, in the equation of each kind in which it does most."""

    motors: float
    """N"""
    arm: float
    """N m"""
    simulated_angle: float | None
    """rad, of the joint whose simulated angle it moves most; None where nothing was simulated"""

    def as_json(self) -> dict[str, float | None]:
        """For the record."""
        return {
            "motor_equation": self.motors,
            "arm_equation": self.arm,
            "simulated_joint_angle": self.simulated_angle,
        }


def cause_shares(stage: FitStage, simulated: Sequence[float | None]) -> tuple[CauseShare, ...]:
    """Of every cause of a fit, by its amounts and what a unit of each does there. simulated: of each cause, or empty."""
    motors, out = stage.comparison.linearisation.hypothesis.arm.M, []
    for done, angle in zip_longest(done_by_causes(stage), simulated):
        rms = np.sqrt(np.mean(np.concatenate(done, axis=1) ** 2, axis=1))
        out.append(CauseShare(float(rms[:motors].max()), float(rms[motors:].max()), angle))
    return tuple(out)


def done_by_causes(stage: FitStage) -> list[list[Array]]:
    """What every cause of a fit does to the residuals of each recording, (C, S), as they are judged."""
    at = stage.comparison.linearisation
    arm, out = at.hypothesis.arm, []
    for cause, columns in zip(stage.causes, stage.columns_of_causes, strict=True):
        amounts = cause.amounts / cause.sizes(arm)[: len(cause.amounts)]
        out.append(
            [
                judged(matrix[..., columns[: len(amounts)]] @ amounts, recording.signals)
                for matrix, recording in zip(stage.comparison.matrices, at.recordings, strict=True)
            ]
        )
    return out
