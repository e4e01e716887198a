"""Motors that stick: at rest their friction is anything up to its greatest, and the base model's law of their speed is wrong there.

Bristles that bend by so much that encoders show it leave much at rest too: they are a cause of the catalogue, and explain it.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause_ranking import CauseCandidate
from diagnosis.fit_stage import FitStage
from diagnosis.held_at_rest import slides_and_rests
from identification.fitting import segment_starts
from identification.motor_rest import MIN_OF_A_CLASS, MIN_REST_RATIO
from identification.whitening import Whitener

Array = NDArray[np.float64]

BRISTLES = "presliding_friction"
MAX_GAIN_OF_BRISTLES = 1.0
"""of the loss in the motors' equations: bristles that take more, with what they take in the arm's, are what it is
(docs/thresholds.md)"""


def motors_stick(stage: FitStage, ranking: Sequence[CauseCandidate], whiten: Whitener) -> bool:
    """Whether half of the motors leave plainly more at rest than while they turn, and bristles do not explain it.

    ranking: of effects by themselves beside the stage."""
    if not stage.excess.above_noise:
        return False
    motors, loss, ratios = stage.before_causes.arm.M, 0.0, list[list[float]]()
    recordings = stage.comparison.linearisation.recordings
    for residual, draws, at in zip(stage.comparison.residuals_after(stage.fit), stage.noise, recordings, strict=True):
        white = whiten(residual, segment_starts(at.signals), at.input_variance)[:motors]
        loss += float(np.sum(white**2))
        by_noise = np.mean(np.square(draws), axis=0)
        squares = at.held.motor_squares(at.signals)
        ratios.append([_at_rest_over_turning(r**2, n, q) for r, n, q in zip(residual, by_noise, squares, strict=False)])
    if np.median(ratios) < MIN_REST_RATIO:
        return False
    by_bristles = max((candidate.gain for candidate in ranking if candidate.effect.name == BRISTLES), default=0.0)
    return by_bristles < MAX_GAIN_OF_BRISTLES * loss


def _at_rest_over_turning(left: Array, by_noise: Array, square: Array) -> float:
    """Of what a motor's equation leaves, by its squares (S,), over the same of noise; square: (S,), of what may hold the motor."""
    turns, rests = slides_and_rests(square)
    if min(rests.sum(), turns.sum()) < MIN_OF_A_CLASS:
        return 1.0
    return float(
        np.sqrt(np.mean(left[rests]) / np.mean(left[turns]) / np.mean(by_noise[rests]) * np.mean(by_noise[turns]))
    )
