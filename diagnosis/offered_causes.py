"""Causes that may be added to a stage or take the place of one of its own, by straight lines."""

from collections.abc import Collection

import numpy as np

from diagnosis.cause import Cause
from diagnosis.compare import compare
from diagnosis.comparison import Comparison
from diagnosis.effects import EFFECTS
from diagnosis.elimination import eliminated
from diagnosis.fit_stage import FitStage
from diagnosis.stepwise import Choices, Option
from identification.whitening import Whitener


def with_effects(stage: FitStage, whiten: Whitener) -> Comparison:
    """A stage with every effect beside it in each of its shapes; those that it names only where these or their places may differ.

    Steps may not reach a shape that is far off. What only doubts the clock is no cause once one is named."""
    named, arm = {cause.effect.name for cause in stage.causes}, stage.comparison.linearisation.hypothesis.arm
    effects = [e for e in EFFECTS.values() if not (named and e.is_clock)]
    differs = {e.name for e in effects if max(len(e.start_shapes), len(e.placements(arm))) > 1}
    choices = [(e, s) for e in effects if e.name not in named or e.name in differs for s in e.start_shapes]
    at = stage.comparison.linearisation
    return compare(at, stage.causes, choices, stage.comparison.nuisances, whiten, stage.noise)


def choices_beside(stage: FitStage, comparison: Comparison, given_up: Collection[str]) -> tuple[Choices, list[Cause]]:
    """A stage's causes, by their numbers, then all others in each shape and place: as options, and as causes to be fitted.

    comparison: of the stage with every effect beside it."""
    arm = comparison.linearisation.hypothesis.arm
    offered, options = list(stage.causes), []
    sizes = [cause.sizes(arm) for cause in stage.causes]
    amounts = [
        np.append(cause.amounts, np.zeros(len(size) - len(cause.amounts))) / size
        for cause, size in zip(stage.causes, sizes, strict=True)
    ]
    for cause, columns in zip(stage.causes, stage.columns_of_causes, strict=True):
        low = cause.effect.least_numbers(arm)[list(cause.where.columns)]
        # an option is a choice of amounts and shape: shape goes either way
        low = np.append(low, np.full(len(columns) - len(low), -np.inf))
        options.append(Option(cause.effect.name, columns, low, len(columns)))
    for group in comparison.groups:
        if group.effect.name in given_up:
            continue
        for where in group.effect.placements(arm):
            columns = group.columns[list(where.columns)]
            low = group.effect.least_numbers(arm)[list(where.columns)]
            offered.append(Cause(group.effect, where, np.zeros(len(where.columns)), dict(group.shape)))
            options.append(Option(group.effect.name, columns, low, offered[-1].number_count))
    without = comparison.with_causes_off(np.concatenate(amounts)) if amounts else comparison
    return Choices(eliminated(without), options), offered
