"""Every effect by itself beside a stage, in the order of what it takes from blocks of time that it was not fitted to."""

from dataclasses import dataclass

import numpy as np

from diagnosis.comparison import Comparison, Index
from diagnosis.effect import Effect, Placement, Shape
from diagnosis.worth_naming import SIMPLER_SHARE, SINGLE_PLACE_SHARE


@dataclass(frozen=True)
class CauseCandidate:
    """An effect in its best shape and place, its columns, and what it takes from the loss."""

    effect: Effect
    shape: Shape
    where: Placement
    columns: Index
    gain: float
    """of blocks that it was not fitted to, and of nuisances that need not go so far"""
    number_count: int
    """of numbers that it is fitted by"""


def rank(comparison: Comparison) -> list[CauseCandidate]:
    """Every effect in its best shape and place, the most telling first."""
    arm = comparison.linearisation.hypothesis.arm
    usual_folds, usual_losses, usual_prior = comparison.folds(), comparison.block_losses(), comparison.prior_loss()
    best: dict[str, CauseCandidate] = {}
    for group in comparison.groups:
        effect, options = group.effect, []
        for where in effect.placements(arm):
            columns = group.columns[list(where.columns)]
            # the first cause that is not the clock itself puts a clock in doubt which rests on the base model's laws
            relaxed = comparison.clock_relaxed or (not len(comparison.cause_columns) and not effect.is_clock)
            folds = comparison.folds(columns)
            without = usual_losses if np.array_equal(folds, usual_folds) else comparison.block_losses(folds=folds)
            options.append(
                CauseCandidate(
                    effect=effect,
                    shape=group.shape,
                    where=where,
                    columns=columns,
                    gain=float(np.sum(without - comparison.block_losses(columns, relaxed, folds)))
                    + usual_prior
                    - comparison.prior_loss(columns, relaxed),
                    number_count=len(columns) + relaxed,
                )
            )
        most = max(option.gain for option in options)
        candidate = min(
            (o for o in options if o.gain >= most - (1 - SINGLE_PLACE_SHARE) * abs(most)),
            key=lambda o: (o.number_count, -o.gain),
        )
        if effect.name not in best or candidate.gain > best[effect.name].gain:
            best[effect.name] = candidate
    clock = next((c.gain for c in best.values() if c.effect.is_clock), 0.0)
    most = max(c.gain for c in best.values())

    def gain_beyond_clock(c: CauseCandidate) -> float:
        # where doubt about the clock is all that explains, the clock itself does
        return c.gain if c.effect.is_clock or c.gain > clock + SIMPLER_SHARE * most else c.gain - clock

    return sorted(best.values(), key=lambda c: -gain_beyond_clock(c))
