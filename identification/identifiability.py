"""Which numbers a motion tells, and of the others why not and what would tell them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import f as f_distribution

from identification.fasquelle.method import MAX_RELATIVE_SIGMA_PERCENT
from identification.fitting import MAX_UNOBSERVED_SHARE, FitSolution, unobserved_projection
from identification.unknowns import Unknown, Unknowns
from mechanism.laws import LAWS, Law

Array = NDArray[np.float64]

_NUISANCES = ("x0", "delay")
"""zero is a value like any other for them: known where sigma is below what a person calls a change"""
_TIED = 0.9
"""a correlation from which one number is traded off against the other"""
_TOLD = 3.0
"""sigmas by which a value differs from nothing"""

ELASTIC_TERMS = {term.name for law in LAWS.values() if type(law).pull is not Law.pull for term in law.terms}
"""terms of laws by which cables pull"""


@dataclass(frozen=True)
class Identifiability:
    """Whether a number is identified; if not, the reason in words, and the motion that would tell it."""

    identified: bool
    kind: str
    """identified, dead, flat, traded, bound or nothing (not told apart from zero)"""
    why: str = ""
    record: str = ""


def judge_identifiability(u: Unknowns, found: FitSolution) -> tuple[Identifiability, ...]:
    """One verdict for each entry of the vector."""
    sigma = np.sqrt(np.diag(found.covariance))
    safe = np.where((sigma > 0) & np.isfinite(sigma), sigma, 1.0)
    correlation = np.where(np.isfinite(found.covariance), found.covariance, 0.0) / np.outer(safe, safe)
    nothing = unobserved_projection(found.information, ~found.at_bound)
    unseen = np.diag(nothing) > MAX_UNOBSERVED_SHARE
    part = np.sqrt(np.where(unseen, np.diag(nothing), 1.0))
    correlation = np.where(np.outer(unseen, unseen), nothing / np.outer(part, part), correlation)
    return tuple(_judged(u, found, place, sigma, correlation) for place in range(len(u.entries)))


def _judged(u: Unknowns, found: FitSolution, place: int, sigma: Array, correlation: Array) -> Identifiability:
    entry, value, own = u.entries[place], float(found.p[place]), float(sigma[place])
    record = entry.term.would_tell
    if found.at_bound[place]:
        return Identifiability(False, "bound", f"at its bound, {value:g} {entry.term.unit}", record)
    stuck = entry.term.of == "cable" and entry.term.name in ELASTIC_TERMS and _x0_at_bound(u, found, entry.index)
    if stuck:
        return Identifiability(
            False, "bound", f"insufficient: x0({entry.index}) is at its bound, vision's noise hides it", record
        )
    alone = float(found.information[place, place])
    if own == 0 or alone * (entry.term.high - entry.term.low) ** 2 < 1:
        return Identifiability(False, "dead", "this motion does not show it", record)
    nuisance = entry.term.name in _NUISANCES
    enough = entry.term.size if nuisance else MAX_RELATIVE_SIGMA_PERCENT / 100 * abs(value)
    if own <= enough:
        return Identifiability(True, "identified")
    others = np.abs(correlation[place])
    others[place] = 0.0
    other = int(np.argmax(others))
    if others[other] > _TIED:
        words = f"traded off against {term_label(u.entries[other])} (correlation {correlation[place, other]:+.2f})"
        return Identifiability(False, "traded", words, record)
    if not nuisance and abs(value) < _TOLD * own:
        return Identifiability(False, "nothing", "not told apart from zero", record)
    return Identifiability(False, "flat", f"known to {100 * own / abs(value):.0f} % only" if value else "not known", record)


def _x0_at_bound(u: Unknowns, found: FitSolution, index: int | None) -> bool:
    """Whether a cable's stretch at rest ran away in any recording: then its stiffness is not the cable's."""
    return any(found.at_bound[i] for i, e in enumerate(u.entries) if e.term.name == "x0" and e.index == index)


def term_label(entry: Unknown) -> str:
    """As tables write it: k(2)."""
    return entry.term.name if entry.index is None else f"{entry.term.name}({entry.index})"


def durbin_wu_hausman(found: FitSolution) -> tuple[float, float]:
    """Statistic and probability that least squares differs that much from the instruments by chance alone.

    Over the terms whose columns the instruments replace (Hausman 1978); blocks stand for independent samples.
    """
    chosen = np.flatnonzero(found.touched & ~found.at_bound)
    if not len(chosen):
        return 0.0, 1.0
    apart = (found.p - found.least_squares)[chosen]
    spread = found.difference_covariance[np.ix_(chosen, chosen)]
    scale = np.sqrt(np.diag(spread))
    if np.any(scale == 0):
        return 0.0, 1.0
    apart, spread = apart / scale, spread / np.outer(scale, scale)
    q = int(np.linalg.matrix_rank(spread, tol=1e-8))
    statistic = float(apart @ np.linalg.pinv(spread, rcond=1e-8, hermitian=True) @ apart)
    left = max(found.blocks - q, 1)
    return statistic, float(f_distribution.sf(statistic * left / (q * max(found.blocks - 1, 1)), q, left))
