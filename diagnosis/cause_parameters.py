"""The numbers of causes, with sigma."""

import numpy as np

from diagnosis.cause import Cause
from diagnosis.effect import DescriptionEffect
from diagnosis.fit_stage import FitStage
from mechanism.arm import Arm
from mechanism.laws import Term
from xneck_foundation.parameter import Parameter

SCALE_SIGMA = 4e-3
"""relative, of every number: the arm's size as a whole is hardly told by anything (docs/thresholds.md)"""
MAX_RELATIVE_SIGMA = 0.1
"""sigma over value up to which a number is identified (docs/thresholds.md)"""


def parameters_of(stage: FitStage) -> tuple[tuple[Parameter, ...], ...]:
    """Of each cause. Where its law leaves something above noise, sigma is as many times larger."""
    arm = stage.comparison.linearisation.hypothesis.arm
    return tuple(
        tuple(_parameters(cause, stage.widening * sigma, arm))
        for cause, sigma in zip(stage.causes, stage.sigma_of_causes, strict=True)
    )


def identified(value: float, sigma: float) -> bool:
    """Whether a number is identified."""
    return bool(sigma <= MAX_RELATIVE_SIGMA * abs(value))


def _parameters(cause: Cause, sigma: np.ndarray, arm: Arm) -> list[Parameter]:
    out, places = [], len(cause.effect.place_labels(arm))
    # an amount that is a share of the described value stands for the value, of which the scale is a part
    is_share = isinstance(cause.effect, DescriptionEffect) and cause.effect.terms[0].unit == "1"
    for column, value, s in zip(cause.where.columns, cause.amounts, sigma, strict=False):
        term, place = cause.effect.terms[column // places], column % places
        index = None if term.of == "arm" and places == 1 else place + cause.effect.first_index
        s = float(np.hypot(s, SCALE_SIGMA * (1 + abs(value)) if is_share else SCALE_SIGMA * value))
        out.append(_parameter(term, index, float(value), s))
    for (term, place, value), s in zip(cause.shape_numbers(arm), sigma[len(cause.amounts) :], strict=True):
        index = None if place is None else place + cause.effect.first_index
        out.append(_parameter(term, index, value, float(np.hypot(s, SCALE_SIGMA * value))))
    return out


def _parameter(term: Term, index: int | None, value: float, sigma: float) -> Parameter:
    return Parameter(
        name=term.name,
        index=index,
        value=value,
        unit=term.unit,
        sigma=sigma,
        identified=identified(value, sigma),
    )
