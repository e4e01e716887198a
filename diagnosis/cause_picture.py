"""What proves a cause to the eye: what the base model leaves where it acts, against its variable, beside what it does as fitted.

All other causes stay in the model, so that what is left is this one's: the last fit's residual and what the cause does, together.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause_share import done_by_causes
from diagnosis.fit_stage import FitStage
from diagnosis.free_function import FreeFit
from diagnosis.shown_by import ShownBy

Array = NDArray[np.float64]

BINS = 20
"""of a picture, as many rows in each"""
TURN_BINS = 48
"""equal parts of a turn: four for each of the waves that a free function may have in it"""


@dataclass(frozen=True)
class CausePicture:
    """One equation against the variable that shows a cause, in K bins; N and N m."""

    channel: int
    """the equation in which the cause does most beside noise, counted from 0, the motors' before the joints'"""
    shown_by: ShownBy
    bin_middles: Array
    """(K,), as are the next three"""
    left: Array
    """means of what the base model leaves"""
    done: Array
    """means of what the cause does, as fitted"""
    noise: Array
    """RMS of noise alone in a row"""


def cause_pictures(stage: FitStage) -> tuple[CausePicture, ...]:
    """Of every cause of a fit."""
    return tuple(
        _picture(stage, cause.effect.shown_by, stage.judged_residuals, done)
        for cause, done in zip(stage.causes, done_by_causes(stage), strict=True)
    )


def free_function_picture(stage: FitStage, fit: FreeFit) -> CausePicture:
    """Of a law that nobody listed, beside a stage's causes."""
    return _picture(stage, fit.function.picture, fit.residuals, fit.done)


def _picture(stage: FitStage, by: ShownBy, residuals: Sequence[Array], done: Sequence[Array]) -> CausePicture:
    recordings = stage.comparison.linearisation.recordings
    motors = recordings[0].signals.arm.M
    channel = _channel(stage, by, done, motors)
    place = channel if by.equation == "motor" else channel - motors
    values = np.concatenate([by.values(recording, place) for recording in recordings])
    sign = np.concatenate([by.motion_sign(recording, place) for recording in recordings])
    # residuals are what the model has too much of: what it lacks is the other way round
    does = -np.concatenate([each[channel] for each in done])
    left = np.concatenate([each[channel] for each in residuals]) + does
    noise = np.concatenate([np.mean([draw[channel] ** 2 for draw in draws], axis=0) for draws in stage.judged_noise])
    seen = np.isfinite(values)
    middles, bins = _bins(values[seen], by.is_cyclic)
    count = np.bincount(bins, minlength=len(middles))

    def mean(of: Array) -> Array:
        return np.bincount(bins, of[seen], len(middles)) / count

    return CausePicture(
        channel=channel,
        shown_by=by,
        bin_middles=middles,
        left=mean(sign * left),
        done=mean(sign * does),
        noise=np.sqrt(mean(noise)),
    )


def _channel(stage: FitStage, by: ShownBy, done: Sequence[Array], motors: int) -> int:
    """Of the equations of a kind the one in which most is done beside noise."""
    over_noise = np.sqrt(np.mean(np.concatenate(done, axis=1) ** 2, axis=1)) / stage.excess.floor
    if by.equation == "motor":
        return int(np.argmax(over_noise[:motors]))
    return motors + int(np.argmax(over_noise[motors:]))


def _bins(values: Array, is_cyclic: bool) -> tuple[Array, NDArray[np.intp]]:
    """Middles of the bins that hold rows (K,), and the bin of each row."""
    edges = np.unique(np.quantile(values, np.linspace(0, 1, BINS + 1)))
    if is_cyclic:
        edges = np.linspace(0, 1, TURN_BINS + 1)
    inside = np.searchsorted(edges[1:-1], values, side="right")
    _, bins = np.unique(inside, return_inverse=True)
    return np.bincount(bins, values) / np.bincount(bins), bins
