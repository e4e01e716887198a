"""The numbers of causes, with sigma."""

import numpy as np

from diagnosis.cause import Cause
from diagnosis.cause_fit import FitStage
from diagnosis.effect import OfArm
from xneck_foundation.least_squares import Parameter

SCALE = 4e-3
"""of a number: the arm's size as a whole is hardly told by anything. Where nothing was hidden all lengths and drums came out
smaller than they were by this part"""
KNOWN = 0.1
"""sigma over value up to which a number is identified"""


def parameters_of(turn: FitStage) -> tuple[tuple[Parameter, ...], ...]:
    """Of each cause. Where its law leaves something above noise, sigma is as many times larger."""
    arm = turn.end.point.hypothesis.arm
    form = float(turn.beyond.ratio.max()) if turn.beyond.plain else 1.0
    return tuple(
        tuple(_parameters(cause, form * sigma, len(cause.effect.labels(arm))))
        for cause, sigma in zip(turn.causes, turn.sigma_of_causes, strict=True)
    )


def known(value: float, sigma: float) -> bool:
    """Whether a number is identified."""
    return bool(sigma <= KNOWN * abs(value))


def _parameters(cause: Cause, sigma: np.ndarray, places: int) -> list[Parameter]:
    found = []
    share = isinstance(cause.effect, OfArm) and cause.effect.terms[0].unit == "1"
    for column, value, s in zip(cause.where.columns, cause.amounts, sigma, strict=False):
        term, place = cause.effect.terms[column // places], column % places
        index = None if places == 1 else place + cause.effect.first
        s = float(np.hypot(s, SCALE * (1 + abs(value)) if share else SCALE * value))
        found.append(Parameter(term.name, index, float(value), term.unit, float(s), known(value, s)))
    for term, s in zip(cause.effect.forms, sigma[len(cause.amounts) :], strict=True):
        value = cause.forms[term.name]
        s = float(np.hypot(s, SCALE * value))
        found.append(Parameter(term.name, None, value, term.unit, float(s), known(value, s)))
    return found
