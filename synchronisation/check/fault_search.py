"""Which faults there are: the best one, those that noise cannot tell from it, and then the next one with these fitted along."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synchronisation.check.events import missed_counts, nearby, slacks, slips
from synchronisation.check.observation import Observed
from synchronisation.check.scoring import Fitted, Known, Score, fit_law, score, threshold
from synchronisation.check.signatures import FaultCandidate, candidates

Array = NDArray[np.float64]

MOST_FAULTS = 4
REFINEMENTS = 2
"""times that the cables' own errors are found anew with the best fault fitted along"""
WITHIN_SIGMA = 3.0
"""a rival is this much worse, at least, before it is ruled out"""
WITHIN_SHARE = 0.05
"""of the gain: and by this much, since laws and signatures are not exact"""
NEXT = 0.1
"""a further fault gains at least this share of what the first did: less is what its signature, for small sizes, leaves"""
APART_S = 3.0
"""between two events of one cable: a step leaves a trace around it, since motor angles are smoothed"""

CORRELATED = 4.0
"""times the variance that a fit of a law would have if what it leaves were white"""
ANEW_M = 5e-6
"""m that cables rest differently from one recording to the next"""


@dataclass(frozen=True)
class NamedFault:
    """The best explanation, and others that explain as much, the best first."""

    best: Score
    rivals: tuple[Score, ...]


def name_faults(seen: Observed, known: Known | None = None) -> tuple[tuple[NamedFault, ...], Fitted]:
    """Faults in the order in which they stand out, none on a healthy arm, and the law's fit with them."""
    every = [*candidates(seen), *missed_counts(seen)]
    for j in range(seen.arm.M):
        every += [*slips(seen, j), *slacks(seen, j)]
    named: list[NamedFault] = []
    fit = fit_law(seen, known)
    while len(named) < MOST_FAULTS:
        scores = [score(fit, c) for c in every]
        best, found = _best(scores), [n.best.candidate.signature for n in named]
        if best.z < threshold(scores):
            other = _beside(seen, known, found, best.candidate, every)
            if other is None:
                break
            # the masked one is found next, once this one is
            best, along = other, [*found, best.candidate.signature]
        else:
            along = found
        for _ in range(REFINEMENTS):
            error = fit_law(seen, known, [*along, best.candidate.signature]).error
            fit = fit_law(seen, known, along, error)
            scores = [score(fit, c) for c in (*every, *nearby(seen, best.candidate))]
            best = _best(scores)
        if named and best.gain < NEXT * named[0].best.gain:
            break
        named.append(NamedFault(best, _rivals(best, scores)))
        every = [c for c in every if _apart(c, best.candidate)]
        fit = fit_law(seen, known, [*found, best.candidate.signature])
    return _together(seen, named, known, fit), fit


def _beside(
    seen: Observed, known: Known | None, found: list[Array], masked: FaultCandidate, every: Sequence[FaultCandidate]
) -> Score | None:
    """The fault beside which a masked one stands out, and that stands out beside it: what either leaves hid the other."""
    others = [c for c in every if _apart(c, masked)]
    fit = fit_law(seen, known, [*found, masked.signature])
    scores = [score(fit, c) for c in others]
    other = _best(scores)
    if other.z < threshold(scores):
        return None
    fit = fit_law(seen, known, [*found, other.candidate.signature])
    scores = [score(fit, c) for c in (masked, *others)]
    return other if scores[0].z >= threshold(scores) else None


def _together(seen: Observed, named: Sequence[NamedFault], known: Known | None, fit: Fitted) -> tuple[NamedFault, ...]:
    """Each fault with the size, sigma and moment that it has beside all the others: found alone, it took some of theirs."""
    if len(named) < 2:
        return tuple(named)
    out: list[NamedFault] = []
    for k, one in enumerate(named):
        others = [n.best.candidate.signature for n in (*out, *named[k + 1 :])]
        without = fit_law(seen, known, others, fit.error)
        candidate = one.best.candidate
        scores = [score(without, c) for c in (candidate, *nearby(seen, candidate))]
        out.append(NamedFault(max(scores, key=lambda s: s.gain), one.rivals))
    return tuple(out)


def _apart(other: FaultCandidate, found: FaultCandidate) -> bool:
    if other.when is None or found.when is None or other.where != found.where:
        return other is not found
    return abs(other.when - found.when) > APART_S


def _best(scores: Sequence[Score]) -> Score:
    beyond = [s for s in scores if s.z > 0]
    return max(beyond or scores, key=lambda s: s.gain)


def _rivals(best: Score, scores: Sequence[Score]) -> tuple[Score, ...]:
    """One for each fault and place, where it gains as much within noise."""
    noise = WITHIN_SIGMA**2 * best.gain * (best.sigma / best.size) ** 2
    least = best.gain - noise - WITHIN_SHARE * best.gain
    out: dict[tuple[str, str], Score] = {}
    for s in sorted(scores, key=lambda s: -s.gain):
        place = (s.candidate.fault, s.candidate.where)
        if s.gain >= least and place != (best.candidate.fault, best.candidate.where):
            out.setdefault(place, s)
    return tuple(out.values())


def known_of(seen: Observed, fit: Fitted) -> Known:
    """A healthy recording's law as belief about the next one's."""
    size = seen.arm.M * seen.law.X.shape[2]
    covariance = CORRELATED * fit.inverse[:size, :size]
    covariance[range(size), range(size)] += np.where(np.arange(size) % seen.law.X.shape[2] == 0, ANEW_M**2, 0.0)
    return Known(fit.beta[:size], covariance)
