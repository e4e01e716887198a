"""Which causes explain what the base model does not, as many as the recordings carry.

They are chosen jointly (diagnosis/cause_choice.py). In the end those that explained about as much are fitted in the place of each
(diagnosis/look_alikes.py), and what takes too little of what stands above noise is not named.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.cause import Cause
from diagnosis.cause_choice import ANEW_SHARE, with_all_causes
from diagnosis.cause_fit import CauseFitter, fitted_without
from diagnosis.cause_ranking import CauseCandidate, rank
from diagnosis.comparison import Comparison
from diagnosis.fit_stage import FitStage
from diagnosis.free_function import FreeFit, FreeFits
from diagnosis.hypothesis import Hypothesis
from diagnosis.linearisation import Linearisation
from diagnosis.look_alikes import NamedCause, with_look_alikes
from diagnosis.noise_ensemble import NoiseEnsemble
from diagnosis.noise_excess import NoiseExcess
from diagnosis.offered_causes import with_effects
from diagnosis.remainder import MAX_REMAINDER, leaves_plainly_more
from diagnosis.single_place import with_single_places
from diagnosis.sticking_motors import motors_stick
from diagnosis.worth_naming import MIN_EXPLAINED
from identification.whitening import Whitener
from mechanism.laws import law_named
from mechanism.laws.unlisted import UnlistedLaw

MAX_SHARE_OF_UNLISTED = 0.5
"""of what all causes leave above noise: a function of one variable that leaves less in their place takes their place
(docs/thresholds.md)"""

MAX_SHARE_OF_OTHER_FORM = 0.1
"""of what stood above noise: causes that leave less are right but for the form of their laws, however far above noise that is
(docs/thresholds.md)"""

MIN_SHARE_BESIDE_UNKNOWN = 0.05
"""of the geometric mean of all that is beyond noise and of what is left: a cause that takes less may stand in for something else
(docs/thresholds.md)"""

MAX_TIMES_OF_STAND_IN = 3.0
"""times what is left: what takes more stands in for nothing (docs/thresholds.md)"""

MAX_SHARE_CLEARED = 0.1
"""of what an equation had above noise, that is left where a cause is said to clear it (docs/thresholds.md)"""

_MAX_EXCHANGES = 3
"""of causes for those that leave far less, after which others are sought once more"""

MAX_TIMES_LEFT = 10.0
"""times the noise, and what another explanation leaves beyond it: causes that leave more are not looked at further
(docs/thresholds.md)"""

SAME_SIGMAS = 3.0
"""standard deviations within which a motor's gain is that of its drum (docs/thresholds.md)"""


@dataclass(frozen=True)
class Search:
    """Where it began, where it ended, and what was named on the way."""

    first: FitStage
    last: FitStage
    named: tuple[NamedCause, ...]
    every_effect: Comparison
    """the first stage with all effects beside it"""
    ranking: tuple[CauseCandidate, ...]
    """of every effect by itself beside the first stage, the best first"""
    fitter: CauseFitter
    """with the weights of the last stage"""
    unlisted: FreeFit | None
    """the function of one variable that explains most of what the causes leave plainly above noise, if they do"""
    free_fits: FreeFits
    """those that were looked for"""
    outweighed: FitStage | None = None
    """with causes that take too little to be named by themselves, if there are any"""

    def share_taken(self, candidate: CauseCandidate) -> float:
        """Of the first stage's loss, by one of the ranking."""
        return min(candidate.gain / self.first.loss, 1.0)

    def with_outweighed_causes(self) -> "Search | None":
        """With causes that take too little to be named by themselves: beside a law that nobody listed they may be right."""
        if self.outweighed is None:
            return None
        causes, last = with_look_alikes(self.fitter, self.outweighed)
        return self._ending(self.fitter.finished(last), causes)

    def without_causes(self) -> "Search":
        """As it began."""
        return self._ending(self.first, ())

    def without_the_least(self) -> "Search":
        """Without the cause that takes least; without any where the others leave too much."""
        least = min(range(len(self.named)), key=lambda i: self.named[i].gain)
        if len(self.named) == 1:
            return self.without_causes()
        last = self.fitter.finished(fitted_without(self.fitter, self.last, [least]))
        if last.excess.above_noise and _is_outweighed(self.first, last, self.fitter.whiten, self.free_fits):
            return self.without_causes()
        return self._ending(last, (*self.named[:least], *self.named[least + 1 :]))

    def with_one_cause(self) -> "Search":
        """With the one of its causes beside which a function of one variable leaves least."""
        everything = range(len(self.named))
        alone = [fitted_without(self.fitter, self.last, [k for k in everything if k != i]) for i in everything]
        left = [self.free_fits.best(stage, self.fitter.whiten) for stage in alone]
        best = min(everything, key=lambda i: (left[i] or alone[i]).excess.energy)
        return self._ending(self.fitter.finished(alone[best]), (self.named[best],))

    def _ending(self, last: FitStage, named: tuple[NamedCause, ...]) -> "Search":
        return replace(self, named=named, last=last, unlisted=_unlisted(last, self.fitter.whiten, self.free_fits))


def search_causes(
    h: Hypothesis,
    ensembles: Sequence[NoiseEnsemble],
    seed: int = 0,
    rival: NoiseExcess | None = None,
    begun: tuple[Cause, ...] = (),
) -> Search:
    """Causes beyond a hypothesis in recordings of one arm. Raises Refused where a motor stands still.

    rival: what another explanation leaves, if there is one: causes that leave far more are as good as none. begun: causes that the
    choice begins with.
    Where they hold a gain of a motor that is as far off as its drum is found to be, forces are taken to be torques over the
    described drums, and causes are sought again from the others on."""
    search = _search(h, ensembles, seed, begun, rival=rival)
    of_drums = [] if h.forces_as_drums else _of_drums(search.last)
    if not of_drums:
        return search
    others = tuple(cause for i, cause in enumerate(search.last.causes) if i not in of_drums)
    return _search(h.with_forces_as_drums(), ensembles, seed, others, search.last.comparison.linearisation)


def _of_drums(stage: FitStage) -> list[int]:
    """Which causes are gains of motors that are the same as is found of their drums.

    Either sits at one motor, and has one number."""
    found = [
        (cause.effect.name, cause.where.label, float(cause.amounts[0]), float(sigma[0]))
        for cause, sigma in zip(stage.causes, stage.sigma_of_causes, strict=True)
    ]
    drums = {where: (amount, sigma) for name, where, amount, sigma in found if name == "drum_radius"}
    out = []
    for i, (name, where, gain, sigma) in enumerate(found):
        drum, of_drum = drums.get(where, (np.inf, 0.0))
        if name == "actuator_gain" and abs(gain - drum) < SAME_SIGMAS * np.hypot(sigma, of_drum):
            out.append(i)
    return out


def _search(
    h: Hypothesis,
    ensembles: Sequence[NoiseEnsemble],
    seed: int,
    begun: tuple[Cause, ...] = (),
    near: Linearisation | None = None,
    rival: NoiseExcess | None = None,
) -> Search:
    """begun, rival: as `search_causes`. near: where the causes that the choice begins with stand, if that is known."""
    fitter = CauseFitter(h, ensembles)
    fitter, first = fitter.redrawn(fitter.base_model())
    every_effect = with_effects(first, fitter.whiten)
    ranked = rank(every_effect)
    if motors_stick(first, ranked, fitter.whiten):
        fitter, first = fitter.with_sticking_motors(first)
        every_effect = with_effects(first, fitter.whiten)
        ranked = rank(every_effect)
    of_first, free_fits = fitter, FreeFits()
    last, beside = first, every_effect
    if begun:
        fitter, last = fitter.with_own_weights(fitter.fitted(near or first.comparison.linearisation, begun))
        beside = with_effects(last, fitter.whiten)
    fitter, last = with_all_causes(fitter, last, beside, free_fits, seed)
    nothing = Search(first, first, (), every_effect, tuple(ranked), fitter, unlisted=None, free_fits=free_fits)
    if rival is not None and last.excess.energy > MAX_TIMES_LEFT * (rival.energy + len(rival.ratio)):
        return nothing
    outweighed: FitStage | None = None
    knows_a_law = any(isinstance(law_named(name), UnlistedLaw) for name in h.laws)
    if not knows_a_law and last.excess.above_noise and _is_outweighed(first, last, fitter.whiten, free_fits):
        # a law whose numbers stay as they were found leaves more beside the right causes than one more law would
        outweighed, last = last if last.causes else None, first
    fitter, causes, last = _with_exchanges(fitter, last, free_fits, seed)
    causes, last = _without_stand_ins(fitter, first, causes, last)
    if causes and last.excess.above_noise:
        fitter, last = fitter.reweighted_by_what_is_left(last)
    elif causes:
        fitter, last = fitter.reweighted(last)
    if causes:
        last = fitter.finished(last)
        if len(last.untold) == len(causes) and not first.excess.above_noise:
            causes, last = (), first
        elif told := _without_untold(fitter, last):
            causes = tuple(cause for i, cause in enumerate(causes) if i not in last.untold)
            last = fitter.finished(told)
        explain_most = last.excess.share_of(first.excess) < MAX_SHARE_OF_OTHER_FORM
        untold = len(last.untold_beside_what_is_left) == len(causes)
        if leaves_plainly_more(last.excess) and untold and not explain_most:
            causes, last = (), first  # they stand in for something else
    if not causes:
        last = of_first.finished(first)
    return replace(
        nothing,
        last=last,
        named=causes,
        fitter=fitter,
        unlisted=_unlisted(last, fitter.whiten, free_fits),
        outweighed=outweighed,
    )


def _with_exchanges(
    fitter: CauseFitter, last: FitStage, free_fits: FreeFits, seed: int, rounds: int = _MAX_EXCHANGES
) -> tuple[CauseFitter, tuple[NamedCause, ...], FitStage]:
    """Causes with those that explain as much in their place.

    Where one leaves far less than what it takes the place of, and more than noise all the same, others are sought beside it."""
    last = with_single_places(fitter, last)
    causes, exchanged = with_look_alikes(fitter, last)
    is_far_better = exchanged.surplus < ANEW_SHARE * last.surplus
    if not (rounds and is_far_better and leaves_plainly_more(exchanged.excess)):
        return fitter, causes, exchanged
    fitter, last = fitter.with_own_weights(exchanged)
    fitter, last = with_all_causes(fitter, last, with_effects(last, fitter.whiten), free_fits, seed)
    return _with_exchanges(fitter, last, free_fits, seed, rounds - 1)


def _unlisted(stage: FitStage, whiten: Whitener, free_fits: FreeFits) -> FreeFit | None:
    return free_fits.best(stage, whiten) if leaves_plainly_more(stage.excess) else None


def _is_outweighed(first: FitStage, last: FitStage, whiten: Whitener, free_fits: FreeFits) -> bool:
    """Whether what causes leave is more than they may, or far more than a law that nobody listed would leave in their place."""
    if last.excess.share_of(first.excess) > 1 - MIN_EXPLAINED:
        return True
    if not leaves_plainly_more(last.excess):
        return False
    unlisted = free_fits.best(first, whiten)
    return unlisted is not None and unlisted.excess.share_of(last.excess) < MAX_SHARE_OF_UNLISTED


def _without_stand_ins(
    fitter: CauseFitter, first: FitStage, causes: tuple[NamedCause, ...], last: FitStage
) -> tuple[tuple[NamedCause, ...], FitStage]:
    """Without causes that take a small share of all, and little beside what is left plainly above noise.

    They may mend the form of another one's law, or stand in for what nobody knows. None does that clears an equation: beside it
    another one may hold far more that nobody knows."""
    if not leaves_plainly_more(last.excess):
        return causes, last
    left, at_first = max(0.0, last.surplus), max(0.0, first.surplus)
    least = min(MAX_TIMES_OF_STAND_IN * left, MIN_SHARE_BESIDE_UNKNOWN * np.sqrt(at_first * left))
    small = sorted((i for i, cause in enumerate(causes) if cause.gain < least), key=lambda i: causes[i].gain)
    # two may each take little beside the other, and much together: all at once, else one after the other
    for tried in ([small], [[i] for i in small]):
        left_out, rest = list[int](), last
        for more in tried:
            if not 0 < len(left_out) + len(more) < len(causes):
                break
            without = fitted_without(fitter, last, [*left_out, *more])
            takes_little = without.surplus - last.surplus < least and not _is_cleared(without.excess, last.excess)
            if without.possible and takes_little:
                left_out, rest = [*left_out, *more], without
        if left_out:
            return tuple(cause for i, cause in enumerate(causes) if i not in left_out), rest
    return causes, last


def _is_cleared(before: NoiseExcess, after: NoiseExcess) -> bool:
    """Whether most of what an equation held plainly above noise is gone."""
    plain = before.ratio >= MAX_REMAINDER
    return bool(np.any(plain & (after.ratio**2 - 1 < MAX_SHARE_CLEARED * (before.ratio**2 - 1))))


def _without_untold(fitter: CauseFitter, stage: FitStage) -> FitStage | None:
    """The fit without causes that the recordings do not tell from nothing, if others stay; None where there is none of them.

    Beside a law whose noise is not white they may take a part of the loss all the same. But where the others leave plainly more,
    and far more than with them, only how much there is of each of their numbers is not told."""
    if not 0 < len(stage.untold) < len(stage.causes):
        return None
    without = fitted_without(fitter, stage, stage.untold)
    needed = leaves_plainly_more(without.excess) and stage.excess.share_of(without.excess) < ANEW_SHARE
    return without if without.possible and not needed else None
