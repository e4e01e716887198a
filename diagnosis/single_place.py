"""Causes that were fitted everywhere, and that recordings show to act in one place only.

Where causes are chosen by straight lines some are offered everywhere only. Once one is fitted, its amounts say where it is.
"""

from dataclasses import replace

import numpy as np

from diagnosis.cause import Cause
from diagnosis.cause_fit import CauseFitter
from diagnosis.fit_stage import UNTOLD_SIGMAS, FitStage
from diagnosis.worth_naming import MIN_LOSS_SHARE, SIMPLER_SHARE
from mechanism.arm import Arm, Array

MAX_SHARE_ELSEWHERE = 0.1
"""of the largest amount: up to which others may be what a law's form leaves (docs/thresholds.md)"""


def with_single_places(fitter: CauseFitter, stage: FitStage) -> FitStage:
    """The fit with each such cause in its one place, where that leaves hardly more."""
    for i in range(len(stage.causes)):
        arm = stage.comparison.linearisation.hypothesis.arm
        alone = _alone(stage.causes[i], stage.sigma_of_causes[i], arm)
        if alone is None:
            continue
        causes = (*stage.causes[:i], alone, *stage.causes[i + 1 :])
        narrowed = fitter.fitted(stage.comparison.linearisation, causes)
        hardly_more = max(MIN_LOSS_SHARE * stage.noise_loss, SIMPLER_SHARE * stage.surplus)
        if narrowed.possible and narrowed.surplus < stage.surplus + hardly_more:
            stage = narrowed
    return stage


def _alone(cause: Cause, sigma: Array, arm: Arm) -> Cause | None:
    """A cause at the one of its places where it does something; None where it has but one, or does something in several.

    sigma: of its amounts, then of its shape's numbers."""
    effect, places = cause.effect, cause.places(arm)
    if len(places) < 2:
        return None
    amounts = cause.amounts.reshape(len(effect.terms), -1)
    sigma = sigma[: cause.amounts.size].reshape(amounts.shape)
    size = np.abs(amounts)
    is_small = size < MAX_SHARE_ELSEWHERE * size.max(axis=1, keepdims=True)
    nothing = is_small | (size < UNTOLD_SIGMAS * sigma)
    # beside other numbers that do nearly the same no amount may be told, though the cause as a whole is
    nothing = is_small if nothing.all() else nothing
    there = np.flatnonzero(~nothing.all(axis=0))
    if len(there) != 1:
        return None
    (at,) = there
    return replace(cause, where=effect.alone_at(places[at], arm), amounts=amounts[:, at].copy())
