"""The search: the likeliest law beside those found so far, simplest first, until chance would do as much.

Each candidate's forms are compared in its fine columns, their inner constants on a grid; what blocks say that were not fitted
decides. Chance is what the best of the whole dictionary takes from the same residual with blocks turned over at random.
"""

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from discovery.evidence import Evidence
from discovery.form import Constants, Form
from discovery.found_law import FoundLaw
from discovery.judge import Judge, Losses
from discovery.law_fit import evidence_of, fitted, with_amounts, with_laws
from discovery.problem import Candidate, Problem
from discovery.rivals import (
    CHANCE_OF_TWO,
    MIN_GAIN_SIGMAS,
    SIMPLER_SHARE,
    Rival,
    all_coefficients,
    chosen,
    coefficients,
    gain_sigmas,
    refined,
)

Array = NDArray[np.float64]

FALSE_ALARM = 0.005
"""probability that chance makes a law, of all that are looked for (docs/thresholds.md)"""
MAX_LAWS = 8
"""that are looked for (docs/thresholds.md)"""
MIN_BLOCKS = 10
"""below which nothing can be judged (docs/thresholds.md)"""
OWN_CONSTANTS_GAIN = 2.0
"""times what a law takes at a place by the inner constants of all, from which it has constants of its own there
(docs/thresholds.md)"""
_NO_AMOUNT_SIGMAS, _NO_AMOUNT_SHARE = 4.0, 0.03
"""up to which a place may have none of a law that another place has: sigmas, and of what the other has"""
_MIN_RIVAL_SHARE = 0.3
"""of the most that any takes where fitted: what takes less is not compared over blocks that were not fitted"""
_WORLDS = 200
"""of chance"""


def find_laws(problem: Problem, seed: int = 0) -> tuple[FoundLaw, ...]:
    """The laws that the target follows, in the order in which they were found; none where chance would do as much.

    None either where there are fewer than MIN_BLOCKS blocks."""
    last = deque(growing_laws(problem, seed), maxlen=1)
    return last[0] if last else ()


def growing_laws(problem: Problem, seed: int = 0) -> Iterator[tuple[FoundLaw, ...]]:
    """`find_laws` so far, after each law that is found; it is looked for when it is asked for."""
    if int(problem.blocks.max()) + 1 < MIN_BLOCKS:
        return
    rng = np.random.default_rng(seed)
    laws: tuple[FoundLaw, ...] = ()
    been: list[set[str]] = [set()]
    while len(laws) < MAX_LAWS:
        found = _next_law(problem, laws, rng)
        if found is None:
            break
        more = _where_alone(problem, fitted(problem, (*laws, found)))
        kept = _without_needless(problem, more)
        words = {law.words for law in kept}
        if len(kept) <= len(laws) and words in been:  # each makes another one needless, round and round
            break
        laws = kept
        been.append(words)
        yield laws


def _next_law(problem: Problem, laws: Sequence[FoundLaw], rng: np.random.Generator) -> FoundLaw | None:
    """The law of all candidates' forms that explains most of what the laws leave; none where chance would do as much."""
    base, precision = with_laws(problem, laws)
    count = int(problem.blocks.max()) + 1
    judge = Judge(problem, base)
    signs = rng.choice([-1.0, 1.0], (_WORLDS, count))
    rivals: list[Rival] = []
    chance = np.zeros(_WORLDS)
    without: Losses | None = None
    most = 0.0
    for of in _candidates(problem, base, precision, problem.candidates):
        candidate, evidence = of.candidate, of.evidence
        forms = [form for form in candidate.forms if candidate.places * len(form.amounts) < count]
        if not forms:  # more numbers than blocks can judge
            continue
        if without is None:
            without = judge.losses(evidence, of.fine, np.zeros((of.fine.shape[1], 0)))
        functions = [all_coefficients(candidate, f, f.starts(candidate.basis)) for f in forms]
        gains = [evidence.gains(each) for each in functions]
        likeliest = int(np.argmax([each.max() for each in gains]))
        left_by = functions[likeliest][int(np.argmax(gains[likeliest]))]
        gradients = evidence.block_gradients(left_by)
        of_constant = _gain_of_constant(evidence, candidate)
        for form, each, gain in zip(forms, functions, gains, strict=True):
            chance = np.maximum(chance, evidence.chance_gains(each, gradients, signs))
            if gain.max() < _MIN_RIVAL_SHARE * most:
                continue
            start = form.starts(candidate.basis)[int(np.argmax(gain))]
            constants, _ = refined(evidence, candidate, form, start, float(gain.max()))
            rival, amounts = _rival(judge, without, of, form, constants, of_constant)
            if not problem.allows(candidate, form, constants, amounts):
                continue
            rivals.append(rival)
            most = max(most, rival.gain)
    if without is None:
        return None
    level = max(_chance_level(chance), problem.least_gain)
    law = chosen(rivals, level, without.whole)
    if law is None or law.candidate.places == 1 or not law.constants:
        return law
    return _of_one_place(judge, precision, without, law, level) or law


def _rival(
    judge: Judge,
    without: Losses,
    of: "_Asked",
    form: Form,
    constants: Constants,
    of_constant: float,
) -> tuple[Rival, Array]:
    """A form of a candidate as it is judged against what is left without any further law, and its amounts.

    of_constant: as `_gain_of_constant`."""
    left = judge.losses(of.evidence, of.fine, coefficients(of.candidate, form, constants))
    gain, of_blocks = without.whole - left.whole, without.of_blocks - left.of_blocks
    return Rival(of.candidate, form, constants, gain, of_blocks, of_constant), left.amounts


def _of_one_place(judge: Judge, precision: Array, without: Losses, law: FoundLaw, level: float) -> FoundLaw | None:
    """The law where it acts at one place with inner constants of its own, if it takes far more there than by those of all.

    Of such places the one where it takes most."""
    best: Rival | None = None
    every = [law.candidate, *_siblings(judge.problem, law.candidate)]
    for of in list(_candidates(judge.problem, judge.base, precision, every))[1:]:
        candidate, evidence = of.candidate, of.evidence
        starts = law.form.starts(candidate.basis)
        gains = evidence.gains(all_coefficients(candidate, law.form, starts))
        own, _ = refined(evidence, candidate, law.form, starts[int(np.argmax(gains))], float(gains.max()))
        of_constant = _gain_of_constant(evidence, candidate)
        rival, as_all = (_rival(judge, without, of, law.form, c, of_constant)[0] for c in (own, law.constants))
        more = rival.block_gains - as_all.block_gains
        is_other = rival.held_out_gain > OWN_CONSTANTS_GAIN * as_all.held_out_gain
        if is_other and gain_sigmas(more) > MIN_GAIN_SIGMAS and (best is None or rival.gain > best.gain):
            best = rival
    return chosen([best], level, without.whole) if best else None


def _siblings(problem: Problem, candidate: Candidate) -> list[Candidate]:
    """A candidate's single places, in their order."""
    return [c for c in problem.candidates if c.places == 1 and c.is_sibling(candidate)]


@dataclass(frozen=True)
class _Asked:
    """A candidate that is asked about."""

    candidate: Candidate
    evidence: Evidence
    """what blocks say of its fine columns"""
    every: Array
    """fine columns of all places, (rows, columns)"""
    own: slice
    """its own among them"""

    @property
    def fine(self) -> Array:
        """Its fine columns, (rows, K)."""
        return self.every[:, self.own]


def _candidates(problem: Problem, base: Array, precision: Array, asked: Sequence[Candidate]) -> Iterator[_Asked]:
    """Those that are asked about, in the problem's order."""
    of_all: _Asked | None = None
    place = 0
    for candidate in asked:
        if of_all is not None and candidate.places == 1 and candidate.is_sibling(of_all.candidate):
            own = slice(place, None, of_all.candidate.places)
            place += 1
            columns = np.arange(of_all.every.shape[1])[own]
            yield _Asked(candidate, of_all.evidence.of_columns(columns), of_all.every, own)
            continue
        fine = problem.columns(candidate, candidate.basis.columns)
        evidence = Evidence.of(base, precision, fine, problem.target, problem.blocks)
        one = _Asked(candidate, evidence, fine, slice(None))
        of_all, place = one if candidate.places > 1 else None, 0
        yield one


def _gain_of_constant(evidence: Evidence, candidate: Candidate) -> float:
    """What a candidate takes whose variable is left out, as friction that only turns over; nothing where that is all of it."""
    if not candidate.factor:
        return 0.0
    ones = candidate.basis.coefficients(lambda x: np.ones((len(x), 1)))
    return float(evidence.gains(candidate.expanded(ones)[None])[0])


def _chance_level(gains: Array) -> float:
    """What the best of all takes by chance with a probability of FALSE_ALARM: the largest of many follow Gumbel's law."""
    scale = float(np.std(gains)) * np.sqrt(6) / np.pi
    return float(np.mean(gains) - scale * (np.euler_gamma + np.log(-np.log1p(-FALSE_ALARM))))


def _where_alone(problem: Problem, laws: tuple[FoundLaw, ...]) -> tuple[FoundLaw, ...]:
    """Laws at the one place that has them, where the others are told to have none: beside laws found later they may."""
    for i in range(len(laws)):
        laws = _alone(problem, laws, i)
    return laws


def _alone(problem: Problem, laws: tuple[FoundLaw, ...], i: int) -> tuple[FoundLaw, ...]:
    """Law `i` at the one place that has it, where the others are told to have none."""
    law = laws[i]
    places = law.candidate.places
    if places == 1:
        return laws
    sigma = np.sqrt(np.maximum(np.diag(law.covariance)[: len(law.amounts)], 1e-300)).reshape(-1, places)
    amounts = np.abs(law.amounts).reshape(-1, places)
    least = np.maximum(_NO_AMOUNT_SIGMAS * sigma, _NO_AMOUNT_SHARE * amounts.max(axis=1, keepdims=True))
    has = (amounts > least).any(axis=0)
    if np.count_nonzero(has) != 1:
        return laws
    place = int(np.flatnonzero(has)[0])
    alone = replace(law, candidate=_siblings(problem, law.candidate)[place], amounts=law.amounts[place::places])
    fewer = fitted(problem, (*laws[:i], alone, *laws[i + 1 :]))
    loss = with_amounts(problem, laws)[1]
    by_chance = CHANCE_OF_TWO * (len(law.amounts) - len(alone.amounts))
    return fewer if with_amounts(problem, fewer)[1] - loss < max(by_chance, SIMPLER_SHARE * loss) else laws


def _without_needless(problem: Problem, laws: tuple[FoundLaw, ...]) -> tuple[FoundLaw, ...]:
    """Laws without those that the others have made needless, given up one after the other."""
    while len(laws) > 1:
        evidence = evidence_of(problem, [problem.columns(law.candidate, law.function) for law in laws])
        every = np.eye(sum(len(law.amounts) for law in laws))
        whole = evidence.block_losses(every)
        of = np.repeat(np.arange(len(laws)), [len(law.amounts) for law in laws])
        needed = [gain_sigmas(evidence.block_losses(every[:, of != i]) - whole) for i in range(len(laws))]
        least = int(np.argmin(needed))
        if needed[least] > MIN_GAIN_SIGMAS:
            break
        laws = fitted(problem, (*laws[:least], *laws[least + 1 :]))
    return laws
