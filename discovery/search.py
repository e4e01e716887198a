"""The search: the likeliest law beside those found so far, simplest first, until chance would do as much.

Each candidate's forms are compared in its fine columns, their inner constants on a grid; what blocks say that were not fitted
decides. Chance is what the best of the whole dictionary takes from the same residual with blocks turned over at random.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from discovery.evidence import Evidence
from discovery.form import Constants, Form
from discovery.found_law import FoundLaw
from discovery.problem import Candidate, Problem

Array = NDArray[np.float64]

FALSE_ALARM = 0.005
"""probability that chance makes a law, of all that are looked for (docs/thresholds.md)"""
MIN_GAIN_SIGMAS = 2.5
"""of the gain over blocks that were not fitted (docs/thresholds.md)"""
MAX_LAWS = 8
"""that are looked for (docs/thresholds.md)"""
ALIKE_SIGMAS, ALIKE_SHARE = 2.0, 0.1
"""of the gain's difference, and of what is left: another law that leaves no more explains as well (docs/thresholds.md)"""
SIMPLER_SIGMAS, SIMPLER_SHARE = 1.0, 0.02
"""the same, by which a simpler law may leave more and is taken for a better one (docs/thresholds.md)"""
MIN_BLOCKS = 10
"""below which nothing can be judged (docs/thresholds.md)"""
_CHANCE_OF_TWO = 4.0
"""of the loss: what two numbers more take by chance"""
_NO_AMOUNT_SIGMAS = 4.0
"""up to which a place may have none of a law that another place has"""
_MIN_RIVAL_SHARE = 0.3
"""of the most that any takes where fitted: what takes less is not compared over blocks that were not fitted"""
_WORLDS = 200
_GRID_SHARES = (0.04, 0.04, 0.02, 0.02, 0.01, 0.005)
"""of a variable's range, and an eighth of the relative change of other constants: steps about the best of a grid"""
_STEPS = 12
_SMALL_STEP = 0.05
"""in sigmas of a number: a smaller step of all is the last"""


@dataclass(frozen=True)
class _Rival:
    """A form of a candidate, as compared."""

    candidate: Candidate
    form: Form
    constants: Constants
    gain: float
    """where fitted"""
    block_gains: Array
    """(B,), over blocks that were not fitted"""

    @property
    def held_out_gain(self) -> float:
        return float(self.block_gains.sum())

    @property
    def complexity(self) -> tuple[int, int]:
        """Simpler ones first."""
        extra = len(self.candidate.follows) - 1
        numbers = len(self.form.amounts) * self.candidate.places + len(self.constants) - len(self.form.fixed)
        return self.form.rank + extra, numbers


def find_laws(problem: Problem, seed: int = 0) -> tuple[FoundLaw, ...]:
    """The laws that the target follows, in the order in which they were found; none where chance would do as much.

    None either where there are fewer than MIN_BLOCKS blocks."""
    if int(problem.blocks.max()) + 1 < MIN_BLOCKS:
        return ()
    rng = np.random.default_rng(seed)
    laws: tuple[FoundLaw, ...] = ()
    while len(laws) < MAX_LAWS:
        found = _next_law(problem, laws, rng)
        if found is None:
            break
        refined = _where_alone(problem, _fitted(problem, (*laws, found)))
        kept = _without_needless(problem, refined)
        if len(kept) <= len(laws) and {law.words for law in kept} == {law.words for law in laws}:
            break
        laws = kept
    return laws


def _next_law(problem: Problem, laws: Sequence[FoundLaw], rng: np.random.Generator) -> FoundLaw | None:
    base, precision = _with_laws(problem, laws)
    count = int(problem.blocks.max()) + 1
    signs = rng.choice([-1.0, 1.0], (_WORLDS, count))
    rivals: list[_Rival] = []
    chance = np.zeros(_WORLDS)
    without: Array | None = None
    loss = most = 0.0
    for candidate in problem.candidates:
        forms = [form for form in candidate.forms if candidate.places * len(form.amounts) < count]
        if not forms:  # more numbers than blocks can judge
            continue
        fine = problem.columns(candidate, candidate.basis.columns)
        evidence = Evidence.of(base, precision, fine, problem.target, problem.blocks)
        if without is None:
            nothing = np.zeros((fine.shape[1], 0))
            without, loss = evidence.block_losses(nothing), evidence.loss(nothing)
        functions = [np.array([_coefficients(candidate, f, c) for c in f.starts(candidate.basis)]) for f in forms]
        gains = [evidence.gains(each) for each in functions]
        likeliest = int(np.argmax([each.max() for each in gains]))
        left_by = functions[likeliest][int(np.argmax(gains[likeliest]))]
        gradients = evidence.block_gradients(left_by)
        for form, each, gain in zip(forms, functions, gains, strict=True):
            chance = np.maximum(chance, evidence.chance_gains(each, gradients, signs))
            if gain.max() < _MIN_RIVAL_SHARE * most:
                continue
            start = form.starts(candidate.basis)[int(np.argmax(gain))]
            constants, best = _refined(evidence, candidate, form, start, float(gain.max()))
            most = max(most, best)
            block_gains = without - evidence.block_losses(_coefficients(candidate, form, constants))
            rivals.append(_Rival(candidate, form, constants, best, block_gains))
    level = max(_chance_level(chance), problem.least_gain)
    return _chosen(rivals, level, loss)


def _refined(
    evidence: Evidence, candidate: Candidate, form: Form, constants: Constants, gain: float
) -> tuple[Constants, float]:
    """Inner constants moved to where they explain most, by ever finer grids about the best; the gain there."""
    free = [name for name in constants if name not in form.fixed]
    span = candidate.basis.high - candidate.basis.low
    for share in _GRID_SHARES if free else ():
        ways = [
            [constants[n] + by * share * span for by in (-1, 0, 1)]
            if n == "place"
            else [constants[n] * (1 + 8 * share) ** by for by in (-1, 0, 1)]
            for n in free
        ]
        tried = [{**constants, **dict(zip(free, each, strict=True))} for each in product(*ways)]
        gains = evidence.gains(np.array([_coefficients(candidate, form, c) for c in tried]))
        if gains.max() > gain:
            constants, gain = tried[int(np.argmax(gains))], float(gains.max())
    return constants, gain


def _coefficients(candidate: Candidate, form: Form, constants: Constants) -> Array:
    return candidate.expanded(candidate.basis.coefficients(lambda x: form.columns(x, constants)))


def _chance_level(gains: Array) -> float:
    """What the best of all takes by chance with a probability of FALSE_ALARM: the largest of many follow Gumbel's law."""
    scale = float(np.std(gains)) * np.sqrt(6) / np.pi
    return float(np.mean(gains) - scale * (np.euler_gamma + np.log(-np.log1p(-FALSE_ALARM))))


def _chosen(rivals: Sequence[_Rival], chance: float, loss: float) -> FoundLaw | None:
    """The simplest of those that explain as well as the best; none where chance would."""
    proved = [r for r in rivals if r.gain > chance and _sigmas(r.block_gains) > MIN_GAIN_SIGMAS]
    if not proved:
        return None
    best = max(proved, key=lambda r: r.held_out_gain)
    left = loss - best.gain
    near = [r for r in proved if _is_alike(best, r, SIMPLER_SIGMAS, SIMPLER_SHARE * left)]
    chosen = min(near, key=lambda r: (r.complexity, -r.held_out_gain))
    alike = [r for r in proved if r is not chosen and _is_alike(best, r, ALIKE_SIGMAS, ALIKE_SHARE * left)]
    alike = sorted((r for r in alike if r.form.name != "smooth"), key=lambda r: -r.held_out_gain)
    others = {(*r.candidate.follows, r.form.name): r for r in reversed(alike) if not _is_same(r, chosen)}
    return replace(
        _as_law(chosen, loss),
        alike=tuple(_as_law(r, loss) for r in sorted(others.values(), key=lambda r: -r.held_out_gain)),
    )


def _is_same(a: _Rival, b: _Rival) -> bool:
    """Whether they are of one variable and form, whatever their places."""
    return (a.candidate.detail, a.candidate.follows, a.form) == (b.candidate.detail, b.candidate.follows, b.form)


def _is_alike(best: _Rival, other: _Rival, sigmas: float, most: float) -> bool:
    """Whether another one takes no less than chance may, nor than `most` of the loss."""
    less = best.block_gains - other.block_gains
    spread = float(np.std(less)) * np.sqrt(len(less))
    return float(less.sum()) <= max(min(sigmas * spread, most), _CHANCE_OF_TWO)


def _sigmas(gains: Array) -> float:
    return float(gains.sum() / max(np.std(gains) * np.sqrt(len(gains)), 1e-300))


def _as_law(rival: _Rival, loss: float) -> FoundLaw:
    count = len(rival.form.amounts) * rival.candidate.places
    free = len(rival.constants) - len(set(rival.form.fixed) & set(rival.constants))
    return FoundLaw(
        candidate=rival.candidate,
        form=rival.form,
        constants=dict(rival.constants),
        amounts=np.zeros(count),
        covariance=np.zeros((count + free, count + free)),
        share=rival.gain / loss if loss else 0.0,
    )


def _with_laws(problem: Problem, laws: Sequence[FoundLaw]) -> tuple[Array, Array]:
    """The base columns with those of laws, and what is known of their numbers."""
    columns = [problem.base, *(_columns(problem, law) for law in laws)]
    base = np.concatenate(columns, axis=1)
    return base, np.append(problem.precision, np.zeros(base.shape[1] - len(problem.precision)))


def _columns(problem: Problem, law: FoundLaw) -> Array:
    """Of its amounts, then of its inner constants at these amounts."""
    own = problem.columns(law.candidate, law.function)
    moved = []
    for name in law.free_constants if law.amounts.any() else ():
        step = 1e-3 * _scale(law, name)
        other = {**law.constants, name: law.constants[name] + step}
        changed = problem.columns(law.candidate, lambda x, other=other: law.form.columns(x, other))
        moved.append((changed - own) @ law.amounts / step)
    return np.column_stack([own, *moved])


def _scale(law: FoundLaw, name: str) -> float:
    basis = law.candidate.basis
    return basis.high - basis.low if name == "place" else max(abs(law.constants[name]), 1e-9)


def _fitted(problem: Problem, laws: tuple[FoundLaw, ...]) -> tuple[FoundLaw, ...]:
    """All numbers of all laws together, inner constants too; steps that do not help are halved."""
    laws, loss = _with_amounts(problem, laws)
    for _ in range(_STEPS):
        step, sigma = _step(problem, laws)
        moving = step[np.isfinite(sigma)]
        if not len(moving) or np.all(np.abs(step) < _SMALL_STEP * sigma):
            break
        for share in (1.0, 0.5, 0.25, 0.1):
            moved, after = _with_amounts(problem, _moved(laws, share * step))
            if after < loss:
                laws, loss = moved, after
                break
        else:
            break
    return _with_covariance(problem, laws)


def _with_amounts(problem: Problem, laws: tuple[FoundLaw, ...]) -> tuple[tuple[FoundLaw, ...], float]:
    """With amounts at their best under the inner constants, and the loss."""
    own = [problem.columns(law.candidate, law.function) for law in laws]
    evidence, every = _evidence(problem, own), np.eye(sum(c.shape[1] for c in own))
    ends = np.cumsum([c.shape[1] for c in own])[:-1]
    amounts = np.split(evidence.fit(every)[evidence.fitted :], ends)
    return tuple(replace(law, amounts=a) for law, a in zip(laws, amounts, strict=True)), evidence.loss(every)


def _evidence(problem: Problem, columns: Sequence[Array]) -> Evidence:
    asked = np.concatenate(list(columns), axis=1)
    return Evidence.of(problem.base, problem.precision, asked, problem.target, problem.blocks)


def _step(problem: Problem, laws: Sequence[FoundLaw]) -> tuple[Array, Array]:
    """Of the inner constants of all laws, with their sigmas."""
    columns = [_columns(problem, law) for law in laws]
    evidence = _evidence(problem, columns)
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
    """With inner constants moved; scales at most halve or double."""
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
    columns = [_columns(problem, law) for law in laws]
    evidence = _evidence(problem, columns)
    covariance = evidence.covariance(np.eye(sum(c.shape[1] for c in columns)))[evidence.fitted :, evidence.fitted :]
    out, first = [], 0
    for law, c in zip(laws, columns, strict=True):
        own = slice(first, first + c.shape[1])
        first += c.shape[1]
        out.append(replace(law, covariance=covariance[own, own]))
    return tuple(out)


def _where_alone(problem: Problem, laws: tuple[FoundLaw, ...]) -> tuple[FoundLaw, ...]:
    """The last law at the one place that has it, where the others are told to have none."""
    *others, law = laws
    places = law.candidate.places
    if places == 1:
        return laws
    sigma = np.sqrt(np.maximum(np.diag(law.covariance)[: len(law.amounts)], 1e-300))
    has = (np.abs(law.amounts) > _NO_AMOUNT_SIGMAS * sigma).reshape(-1, places).any(axis=0)
    if np.count_nonzero(has) != 1:
        return laws
    asked = law.candidate.detail, law.candidate.follows
    siblings = [c for c in problem.candidates if (c.detail, c.follows) == asked and c.places == 1]
    place = int(np.flatnonzero(has)[0])
    alone = replace(law, candidate=siblings[place], amounts=law.amounts[place::places])
    fewer = _fitted(problem, (*others, alone))
    more_loss = _with_amounts(problem, fewer)[1] - _with_amounts(problem, laws)[1]
    return fewer if more_loss < _CHANCE_OF_TWO * (len(law.amounts) - len(alone.amounts)) else laws


def _without_needless(problem: Problem, laws: tuple[FoundLaw, ...]) -> tuple[FoundLaw, ...]:
    """Without those that the others have made needless, one after the other."""
    while len(laws) > 1:
        evidence = _evidence(problem, [problem.columns(law.candidate, law.function) for law in laws])
        every = np.eye(sum(len(law.amounts) for law in laws))
        whole = evidence.block_losses(every)
        of = np.repeat(np.arange(len(laws)), [len(law.amounts) for law in laws])
        needed = [_sigmas(evidence.block_losses(every[:, of != i]) - whole) for i in range(len(laws))]
        least = int(np.argmin(needed))
        if needed[least] > MIN_GAIN_SIGMAS:
            break
        laws = _fitted(problem, (*laws[:least], *laws[least + 1 :]))
    return laws
