"""Which faults there are: the best one, those that noise cannot tell from it, then the next one with the first fitted along."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mechanism.tolerance import EXACT
from synchronisation.check.faults import FAULTS
from synchronisation.check.momentary_faults import missed_counts, slacks, slips, slips_near
from synchronisation.check.observation import ElongationObservation
from synchronisation.check.scoring import (
    CandidateScore,
    LawFit,
    LawPrior,
    adjusted,
    fit_law,
    score_candidates,
    threshold,
)
from synchronisation.check.signatures import FaultCandidate, candidates

Array = NDArray[np.float64]

MAX_FAULTS = 4
"""faults that are named at most (docs/thresholds.md)"""
REFINEMENTS = 2
"""times that the cables' own errors are estimated again with the best fault fitted along"""
RIVAL_SIGMA = 3.0
"""sigma by which a rival must explain less before it is ruled out (docs/thresholds.md)"""
RIVAL_GAIN_SHARE = 0.05
"""share of the gain by which a rival must explain less as well, since laws and signatures are not exact (docs/thresholds.md)"""
MIN_GAIN_SHARE = 0.1
"""share of the first fault's gain that a further one must reach, the drawing held exact (docs/thresholds.md)"""
MAX_LEFT_M = 6e-5
"""m: a cable's own error from which a fault of that cable alone must explain a part of it (docs/thresholds.md)"""
MIN_SHARE_OF_LEFT, MIN_SHARE_OF_MOMENTS = 0.1, 0.5
"""of the square of such an error: what a fault that lasts, and faults of one moment, must explain of it (docs/thresholds.md)"""
MIN_SEPARATION_S = 3.0
"""s between two events of one cable: a step leaves a trace around it, since motor angles are smoothed (docs/thresholds.md)"""
CORRELATION_FACTOR = 4.0
"""variance of a law's factors over the variance that white residuals would give them (docs/thresholds.md)"""
REST_SIGMA_M = 5e-6
"""m: standard deviation of a cable's rest length from one recording to the next (docs/thresholds.md)"""


@dataclass(frozen=True)
class NamedFault:
    """The best explanation, and others that explain as much, the best first."""

    best: CandidateScore
    rivals: tuple[CandidateScore, ...]


def name_faults(
    observation: ElongationObservation, prior: LawPrior | None = None
) -> tuple[tuple[NamedFault, ...], LawFit]:
    """Faults in the order in which they stand out, none on a healthy arm, and the law's fit with them."""
    observation = adjusted(observation, fit_law(observation, prior))
    remaining = [*candidates(observation), *missed_counts(observation)]
    for j in range(observation.arm.M):
        remaining += [*slips(observation, j), *slacks(observation, j)]
    named: list[NamedFault] = []
    gains: list[float] = []
    fit = fit_law(observation, prior)
    while len(named) < MAX_FAULTS:
        scores = score_candidates(fit, remaining)
        best, signatures = _best(scores), _signatures(named)
        if best.z < threshold(scores):
            other = _unmasking_fault(observation, prior, signatures, best.candidate, remaining)
            if other is None:
                break
            # the masked fault is found next, once the other is fitted along
            best, fitted_along = other, [*signatures, best.candidate.signature]
        else:
            fitted_along = signatures
        for _ in range(REFINEMENTS):
            error = fit_law(observation, prior, [*fitted_along, best.candidate.signature]).error
            fit = fit_law(observation, prior, fitted_along, error)
            scores = score_candidates(fit, (*remaining, *slips_near(observation, best.candidate)))
            best = _best(scores)
        gains.append(_gain_with_exact_drawing(observation, prior, fitted_along, best.candidate, fit.error))
        if gains[-1] < MIN_GAIN_SHARE * gains[0]:
            break
        named.append(NamedFault(best, _rivals(best, scores)))
        remaining = [c for c in remaining if _is_separate(c, best.candidate) and not _are_scales(c, best.candidate)]
        fit = fit_law(observation, prior, [*signatures, best.candidate.signature])
    if len(believed := _without_stand_ins(observation, prior, named)) < len(named):
        named, fit = believed, fit_law(observation, prior, _signatures(believed))
    return _jointly_estimated(observation, named, prior, fit), fit


def _unmasking_fault(
    observation: ElongationObservation,
    prior: LawPrior | None,
    signatures: list[Array],
    masked: FaultCandidate,
    remaining: Sequence[FaultCandidate],
) -> CandidateScore | None:
    """The fault beside which `masked` stands out, and which stands out beside it: the residual of either hid the other.

    signatures: (F, M) each, of the faults that are named already.
    """
    others = [c for c in remaining if _is_separate(c, masked) and not _are_scales(c, masked)]
    fit = fit_law(observation, prior, [*signatures, masked.signature])
    scores = score_candidates(fit, others)
    other = _best(scores)
    if other.z < threshold(scores):
        return None
    fit = fit_law(observation, prior, [*signatures, other.candidate.signature])
    scores = score_candidates(fit, (masked, *others))
    return other if scores[0].z >= threshold(scores) else None


def _gain_with_exact_drawing(
    observation: ElongationObservation,
    prior: LawPrior | None,
    fitted_along: Sequence[Array],
    candidate: FaultCandidate,
    error: Array,
) -> float:
    """What a fault explains where nothing else of the arm may be off, so that faults with and without a tolerance compare.

    error: each cable's own, (M,), m. A baseline tells the drawing already.
    """
    exact = observation if prior else replace(observation, tolerance=EXACT)
    fit = fit_law(exact, prior, fitted_along, error)
    (score,) = score_candidates(fit, (candidate,))
    return score.gain


def _jointly_estimated(
    observation: ElongationObservation, named: Sequence[NamedFault], prior: LawPrior | None, fit: LawFit
) -> tuple[NamedFault, ...]:
    """Each fault with the size, sigma and time that it has when all others are fitted along: alone, it took some of theirs."""
    if len(named) < 2:
        return tuple(named)
    estimated: list[NamedFault] = []
    for k, fault in enumerate(named):
        others = _signatures((*estimated, *named[k + 1 :]))
        without = fit_law(observation, prior, others, fit.error)
        candidate = fault.best.candidate
        scores = score_candidates(without, (candidate, *slips_near(observation, candidate)))
        best = max(scores, key=lambda s: s.gain)
        if np.isfinite(best.sigma):  # else it would have to be larger beside the others than it can be
            estimated.append(NamedFault(best, fault.rivals))
    return tuple(estimated)


def _is_separate(other: FaultCandidate, candidate: FaultCandidate) -> bool:
    """Whether both can be named beside each other."""
    if other.when is None or candidate.when is None or other.where != candidate.where:
        return other is not candidate
    return abs(other.when - candidate.when) > MIN_SEPARATION_S


def _without_stand_ins(
    observation: ElongationObservation, prior: LawPrior | None, named: list[NamedFault]
) -> list[NamedFault]:
    """The faults but those of a single cable that leaves far more than healthy ones do, where they explain too little of it.

    What is left so is of a law that nobody knows, and any fault that looks like it a little seems to be there. A cable that goes
    slack does so again and again: one time is little of it."""
    cables = [_its_cable(fault.best.candidate) for fault in named]
    after = fit_law(observation, prior, _signatures(named)).error if named else np.zeros(0)
    for j in {cable for cable in cables if cable is not None and after[cable] > MAX_LEFT_M}:
        others, own = (
            [n for n, cable in zip(named, cables, strict=True) if (cable == j) == of_it] for of_it in (False, True)
        )
        before = fit_law(observation, prior, _signatures(others)).error
        lasts = any(not FAULTS[fault.best.candidate.fault].of_one_moment for fault in own)
        if 1 - (after[j] / before[j]) ** 2 < (MIN_SHARE_OF_LEFT if lasts else MIN_SHARE_OF_MOMENTS):
            named, cables = others, [cable for cable in cables if cable != j]
    return named


def _its_cable(candidate: FaultCandidate) -> int | None:
    """The cable that a fault moves, from 0, if it is one alone and more than a time of slack."""
    (moved,) = np.nonzero(np.any(candidate.signature != 0, axis=0))
    return int(moved[0]) if len(moved) == 1 and candidate.fault != "cable_slack" else None


def _signatures(named: Sequence[NamedFault]) -> list[Array]:
    return [fault.best.candidate.signature for fault in named]


def _are_scales(one: FaultCandidate, other: FaultCandidate) -> bool:
    """Whether both are of all cables, bars or angles at once: but for little, two of these together do nothing."""
    return one.is_scale and other.is_scale


def _best(scores: Sequence[CandidateScore]) -> CandidateScore:
    beyond_tolerance = [s for s in scores if s.z > 0]
    return max(beyond_tolerance or scores, key=lambda s: s.gain)


def _rivals(best: CandidateScore, scores: Sequence[CandidateScore]) -> tuple[CandidateScore, ...]:
    """The candidates that gain as much within noise, the best one of each fault and place."""
    noise = RIVAL_SIGMA**2 * best.gain * (best.sigma / best.size) ** 2
    min_gain = best.gain - noise - RIVAL_GAIN_SHARE * best.gain
    rivals: dict[tuple[str, str], CandidateScore] = {}
    for s in sorted(scores, key=lambda s: -s.gain):
        place = (s.candidate.fault, s.candidate.where)
        if s.gain >= min_gain and place != (best.candidate.fault, best.candidate.where):
            rivals.setdefault(place, s)
    return tuple(rivals.values())


def law_prior_of(observation: ElongationObservation, fit: LawFit) -> LawPrior:
    """A healthy recording's law, and the arm's drawing as it tells it, as prior for the next one's."""
    own = slice(fit.of_arm)
    covariance = CORRELATION_FACTOR * fit.inverse[own, own]
    rest = np.arange(observation.arm.M) * observation.law.X.shape[2]
    covariance[rest, rest] += REST_SIGMA_M**2
    return LawPrior(fit.beta[own], covariance)
