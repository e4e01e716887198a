"""The numbers of laws, fitted together: amounts, and the inner constants that say how each law acts."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from discovery.evidence import Evidence
from discovery.found_law import FoundLaw
from discovery.problem import Problem

Array = NDArray[np.float64]

_STEPS = 12
_PLACE_SHARES = (1.0, 0.5, 0.25, 0.12, 0.06, 0.03, 0.015)
"""of the distance between knots: by how much what is narrower is moved to where it leaves least"""
_SMALL_STEP = 0.05
"""in sigmas of a number: a smaller step of all is the last"""
_DIFFERENCE = 1e-3
"""of a constant's scale: step of the derivatives by it"""


def with_laws(problem: Problem, laws: Sequence[FoundLaw]) -> tuple[Array, Array]:
    """The base columns with those of laws behind them, (rows, P), and the precision of what is known of their numbers, (P,)."""
    columns = [problem.base, *(_columns(problem, law) for law in laws)]
    base = np.concatenate(columns, axis=1)
    return base, np.append(problem.precision, np.zeros(base.shape[1] - len(problem.precision)))


def _columns(problem: Problem, law: FoundLaw) -> Array:
    """A law's columns, (rows, k): those of its amounts, then derivatives by its free constants at these amounts."""
    own = problem.columns(law.candidate, law.function)
    moved = []
    for name in law.free_constants if law.amounts.any() else ():
        step = _DIFFERENCE * _scale(law, name)
        other = {**law.constants, name: law.constants[name] + step}
        changed = problem.columns(law.candidate, lambda x, other=other: law.form.columns(x, other))
        moved.append((changed - own) @ law.amounts / step)
    return np.column_stack([own, *moved])


def _scale(law: FoundLaw, name: str) -> float:
    """By how much a constant moves in a change of note."""
    basis = law.candidate.basis
    return basis.high - basis.low if name == "place" else max(abs(law.constants[name]), 1e-9)


def fitted(problem: Problem, laws: tuple[FoundLaw, ...]) -> tuple[FoundLaw, ...]:
    """Laws with all their numbers at their best together, inner constants too, and their covariance.

    Gauss-Newton's steps in the constants are shortened until they help.
    """
    laws, loss = _placed_by_rows(problem, *with_amounts(problem, laws))
    for _ in range(_STEPS):
        step, sigma = _step(problem, laws)
        moving = step[np.isfinite(sigma)]
        if not len(moving) or np.all(np.abs(step) < _SMALL_STEP * sigma):
            break
        for share in (1.0, 0.5, 0.25, 0.1):
            moved, after = with_amounts(problem, _moved(laws, share * step))
            if after < loss:
                laws, loss = moved, after
                break
        else:
            break
    return _with_covariance(problem, laws)


def _placed_by_rows(problem: Problem, laws: tuple[FoundLaw, ...], loss: float) -> tuple[tuple[FoundLaw, ...], float]:
    """Laws whose last one is moved to the place where it leaves least, if it is narrower than the fine columns tell; the loss."""
    *others, law = laws
    knots, width = law.candidate.basis.knots, law.constants.get("width", np.inf)
    if law.candidate.basis.is_turn or width > knots[1] - knots[0]:
        return laws, loss
    for share in _PLACE_SHARES:
        for by in (-share, share):
            place = law.constants["place"] + by * (knots[1] - knots[0])
            tried = (*others, replace(law, constants={**law.constants, "place": place}))
            moved, after = with_amounts(problem, tried)
            if after < loss:
                laws, loss, law = moved, after, moved[-1]
                break
    return laws, loss


def with_amounts(problem: Problem, laws: tuple[FoundLaw, ...]) -> tuple[tuple[FoundLaw, ...], float]:
    """Laws with amounts at their best under their inner constants, and the loss."""
    own = [problem.columns(law.candidate, law.function) for law in laws]
    evidence, every = evidence_of(problem, own), np.eye(sum(c.shape[1] for c in own))
    ends = np.cumsum([c.shape[1] for c in own])[:-1]
    amounts = np.split(evidence.fit(every)[evidence.fitted :], ends)
    return tuple(replace(law, amounts=a) for law, a in zip(laws, amounts, strict=True)), evidence.loss(every)


def evidence_of(problem: Problem, columns: Sequence[Array]) -> Evidence:
    """What blocks say of columns of several laws, each (rows, k), beside the base columns."""
    asked = np.concatenate(list(columns), axis=1)
    return Evidence.of(problem.base, problem.precision, asked, problem.target, problem.blocks)


def _step(problem: Problem, laws: Sequence[FoundLaw]) -> tuple[Array, Array]:
    """Gauss-Newton's step in the inner constants of all laws, with their sigmas."""
    columns = [_columns(problem, law) for law in laws]
    evidence = evidence_of(problem, columns)
    every = np.eye(sum(c.shape[1] for c in columns))
    x, covariance = evidence.fit(every)[evidence.fitted :], evidence.covariance(every)
    sigma = np.sqrt(np.maximum(np.diag(covariance)[evidence.fitted :], 0.0))
    inner = _inner(laws, columns)
    return x[inner], sigma[inner]


def _inner(laws: Sequence[FoundLaw], columns: Sequence[Array]) -> NDArray[np.bool_]:
    """Which of the columns are those of inner constants."""
    parts = [np.arange(c.shape[1]) >= len(law.amounts) for law, c in zip(laws, columns, strict=True)]
    return np.concatenate(parts)


def _moved(laws: Sequence[FoundLaw], step: Array) -> tuple[FoundLaw, ...]:
    """Laws with inner constants moved by a step; scales at most halve or double."""
    out, first = [], 0
    for law in laws:
        constants = dict(law.constants)
        names = law.free_constants if law.amounts.any() else ()
        for name, by in zip(names, step[first : first + len(names)], strict=True):
            old = constants[name]
            if name == "place":
                reach = 0.1 * (law.candidate.basis.high - law.candidate.basis.low)
                constants[name] = old + float(np.clip(by, -reach, reach))
            else:
                constants[name] = float(np.clip(old + by, old / 2, 2 * old))
        first += len(names)
        out.append(replace(law, constants=constants))
    return tuple(out)


def _with_covariance(problem: Problem, laws: tuple[FoundLaw, ...]) -> tuple[FoundLaw, ...]:
    """Laws with the covariance of their amounts and free constants."""
    columns = [_columns(problem, law) for law in laws]
    evidence = evidence_of(problem, columns)
    covariance = evidence.covariance(np.eye(sum(c.shape[1] for c in columns)))[evidence.fitted :, evidence.fitted :]
    out, first = [], 0
    for law, c in zip(laws, columns, strict=True):
        own = slice(first, first + c.shape[1])
        first += c.shape[1]
        out.append(replace(law, covariance=covariance[own, own]))
    return tuple(out)
