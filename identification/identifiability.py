"""Which parameters a motion identifies, and of the others the reason, and the motion that would identify them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import f as f_distribution

from identification.fasquelle.method import MAX_RELATIVE_SIGMA_PERCENT
from identification.fitting import MAX_UNOBSERVED_SHARE, FitSolution, unobserved_projection
from identification.unknowns import Unknown, Unknowns
from mechanism.laws import LAWS, Law
from xneck_foundation.one_line import indexed
from xneck_foundation.unit_text import with_unit

Array = NDArray[np.float64]

_TRADED_CORRELATION = 0.9
"""correlation of two parameters above which one is said to be traded off against the other (docs/thresholds.md)"""
_MIN_SIGMAS_FROM_ZERO = 3.0
"""sigmas by which a value must differ from zero to be told apart from it (docs/thresholds.md)"""

ELASTIC_TERMS = {term.name for law in LAWS.values() if type(law).pull is not Law.pull for term in law.terms}
"""terms of the laws that make the cables' tension"""


@dataclass(frozen=True)
class Identifiability:
    """Whether a parameter is identified; if not, the reason in words, and the motion that would identify it."""

    identified: bool
    kind: str
    """identified, dead (without effect), flat, traded, bound or nothing (not told apart from zero)"""
    why: str = ""
    record: str = ""


def judge_identifiability(u: Unknowns, solution: FitSolution) -> tuple[Identifiability, ...]:
    """Whether each entry of the parameter vector is identified."""
    sigma = np.sqrt(np.diag(solution.covariance))
    safe = np.where((sigma > 0) & np.isfinite(sigma), sigma, 1.0)
    correlation = np.where(np.isfinite(solution.covariance), solution.covariance, 0.0) / np.outer(safe, safe)
    unobserved = unobserved_projection(solution.information, ~solution.at_bound)
    undetermined = np.diag(unobserved) > MAX_UNOBSERVED_SHARE
    part = np.sqrt(np.where(undetermined, np.diag(unobserved), 1.0))
    correlation = np.where(np.outer(undetermined, undetermined), unobserved / np.outer(part, part), correlation)
    return tuple(_judged(u, solution, place, sigma, correlation) for place in range(len(u.entries)))


def _judged(u: Unknowns, solution: FitSolution, place: int, sigma: Array, correlation: Array) -> Identifiability:
    entry, value, own_sigma = u.entries[place], float(solution.p[place]), float(sigma[place])
    record = entry.term.would_tell
    if solution.at_bound[place]:
        return Identifiability(False, "bound", with_unit(f"at its bound, {value:g}", entry.term.unit), record)
    x0_at_bound = (
        entry.term.of == "cable" and entry.term.name in ELASTIC_TERMS and _x0_at_bound(u, solution, entry.index)
    )
    if x0_at_bound:
        return Identifiability(
            False, "bound", f"insufficient: x0({entry.index}) is at its bound, vision's noise hides it", record
        )
    own_information = float(solution.information[place, place])
    if own_sigma == 0 or own_information * (entry.term.high - entry.term.low) ** 2 < 1:
        return Identifiability(False, "dead", "this motion does not show it", record)
    # zero is a value like any other for what each recording has of its own
    nuisance = entry.recording is not None
    max_sigma = entry.term.size if nuisance else MAX_RELATIVE_SIGMA_PERCENT / 100 * abs(value)
    if own_sigma <= max_sigma:
        return Identifiability(True, "identified")
    others = np.abs(correlation[place])
    others[place] = 0.0
    other = int(np.argmax(others))
    if others[other] > _TRADED_CORRELATION:
        words = f"traded off against {term_label(u.entries[other])} (correlation {correlation[place, other]:+.2f})"
        return Identifiability(False, "traded", words, record)
    if not nuisance and abs(value) < _MIN_SIGMAS_FROM_ZERO * own_sigma:
        return Identifiability(False, "nothing", "not told apart from zero", record)
    return Identifiability(
        False, "flat", f"known to {100 * own_sigma / abs(value):.0f} % only" if value else "not known", record
    )


def _x0_at_bound(u: Unknowns, solution: FitSolution, index: int | None) -> bool:
    """Whether a cable's pre-elongation is at its bound in any recording: then its stiffness is not the cable's."""
    return any(solution.at_bound[i] for i, e in enumerate(u.entries) if e.term.name == "x0" and e.index == index)


def term_label(entry: Unknown) -> str:
    """A term with its index, as tables write it: k(2)."""
    return indexed(entry.term.name, entry.index)


def durbin_wu_hausman(solution: FitSolution) -> tuple[float, float]:
    """Statistic of the difference between least squares and instruments, and its probability if neither were biased.

    Over the terms whose columns the instruments replace (Hausman 1978); blocks stand for independent samples.
    """
    chosen = np.flatnonzero(solution.instrumented & ~solution.at_bound)
    if not len(chosen):
        return 0.0, 1.0
    difference = (solution.p - solution.least_squares)[chosen]
    spread = solution.difference_covariance[np.ix_(chosen, chosen)]
    scale = np.sqrt(np.diag(spread))
    if np.any(scale == 0):
        return 0.0, 1.0
    difference, spread = difference / scale, spread / np.outer(scale, scale)
    q = int(np.linalg.matrix_rank(spread, tol=1e-8))
    statistic = float(difference @ np.linalg.pinv(spread, rcond=1e-8, hermitian=True) @ difference)
    freedom = max(solution.blocks - q, 1)
    return statistic, float(f_distribution.sf(statistic * freedom / (q * max(solution.blocks - 1, 1)), q, freedom))
