"""What explains recordings: causes, and laws in what these leave, as far as recordings that were not fitted bear them out.

Where something short and strong outweighs all, as a hand that pushes the arm, its stretches are set aside.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from diagnosis.cause_search import Search, search_causes
from diagnosis.causes_beside_laws import with_laws
from diagnosis.fit_stage import FitStage
from diagnosis.held_out_gain import Gain, HeldOutResiduals, gains, held_out_excess, held_out_residuals
from diagnosis.hypothesis import Hypothesis
from diagnosis.law_gains import GainedLaw
from diagnosis.noise_ensemble import NoiseEnsemble
from diagnosis.noise_excess import ABOVE_NOISE_RATIO
from diagnosis.remainder import Remainder, leaves_plainly_more, remainders
from diagnosis.residual_episodes import Episode
from diagnosis.short_disturbances import set_aside, short_disturbances, short_disturbances_held_out
from diagnosis.worth_naming import MIN_EXPLAINED

_WORSE_SIGMAS = 3.0
"""standard deviations by which the extended model must be worse for its causes to be taken back (docs/thresholds.md)"""


@dataclass(frozen=True)
class HeldOut:
    """What recordings that were not fitted say of a stage; nothing, where there are none."""

    gains: tuple[Gain, ...] = ()
    """in the equations"""
    remainder: tuple[Remainder, ...] = ()
    """of all rows, also of those that are set aside for the rest"""
    holds: bool = True
    """whether the causes explain these too"""
    worse: tuple[str, ...] = ()
    """equations in which the extended model does worse than the base model"""
    residuals: HeldOutResiduals | None = None
    """what is left with the causes"""
    residuals_before: HeldOutResiduals | None = None
    """what is left without them"""
    ensembles: tuple[NoiseEnsemble, ...] = ()
    """the recordings, without stretches that are set aside"""
    stretches: tuple[Episode, ...] = ()
    """that are set aside"""


@dataclass(frozen=True)
class Findings:
    """What was named, what laws were found beside it, and what recordings that were not fitted say of both."""

    search: Search
    laws: tuple[GainedLaw, ...]
    stage: FitStage
    """the fit of both"""
    held: HeldOut
    taken_back: tuple[str, ...] = ()
    """effects that would explain more, but not on recordings that were not fitted"""
    stretches: tuple[Episode, ...] = ()
    """of the fitted recordings: beside them what is named explains all, or nothing stands above noise where nothing is named"""


def findings(
    h: Hypothesis,
    fitted: Sequence[NoiseEnsemble],
    others: Sequence[NoiseEnsemble],
    seed: int,
    progress: Callable[[str], object],
) -> Findings:
    """Beyond a hypothesis; others: recordings that are not fitted."""
    found = _findings(h, fitted, others, seed, progress)
    if not leaves_plainly_more(found.stage.excess):
        return found
    stretches = short_disturbances(found.stage)
    if not stretches:
        return found
    progress("without short disturbances")
    clear = _findings(h, set_aside(fitted, stretches), others, seed, progress)
    if leaves_plainly_more(clear.stage.excess):
        return found
    if clear.search.named:
        return replace(clear, stretches=stretches)
    return found if found.search.named or found.laws else replace(found, stretches=stretches)


def _findings(
    h: Hypothesis,
    fitted: Sequence[NoiseEnsemble],
    others: Sequence[NoiseEnsemble],
    seed: int,
    progress: Callable[[str], object],
) -> Findings:
    progress("causes")
    search = search_causes(h, fitted, seed)
    progress("gain")
    held = _held_out(search, search.last, others)
    taken_back: list[str] = []
    while held.worse and search.named:
        before, search = search, search.without_the_least()
        taken_back += [n.effect.name for n in before.named if n.effect not in {m.effect for m in search.named}]
        held = _held_out(search, search.last, others)
    found = Findings(search, (), search.last, held, tuple(taken_back))
    if not found.stage.excess.above_noise:
        return found
    progress("laws that nobody listed")
    beside = with_laws(search, held.residuals, fitted, held.ensembles, seed)
    if beside.stage is found.stage:
        return found
    with_them = _held_out(beside.search, beside.stage, others)
    if with_them.worse and not beside.laws:
        return found
    return replace(found, search=beside.search, laws=beside.laws, stage=beside.stage, held=with_them)


def first_beside(search: Search, last: FitStage) -> FitStage:
    """The first stage of a search, where rows at rest count as in the last: alike before and after."""
    as_held = replace(search.first.before_causes, held=last.before_causes.held)
    return replace(search.first, before_causes=as_held)


def _held_out(search: Search, last: FitStage, ensembles: Sequence[NoiseEnsemble]) -> HeldOut:
    """last: the stage whose causes are held against the first's."""
    if not ensembles:
        return HeldOut()
    before, after = _left(search, last, ensembles)
    everything = _held_out_rows(before, after, ensembles)
    excess = held_out_excess(after, after)
    stretches = short_disturbances_held_out(after, excess) if leaves_plainly_more(excess) else ()
    if not stretches:
        return everything
    rest = set_aside(ensembles, stretches)
    return replace(
        _held_out_rows(*_left(search, last, rest), rest), remainder=everything.remainder, stretches=stretches
    )


def _left(
    search: Search, last: FitStage, ensembles: Sequence[NoiseEnsemble]
) -> tuple[HeldOutResiduals, HeldOutResiduals]:
    """By the first stage, and by the last."""
    whiten, relaxed = search.fitter.whiten, bool(last.causes)
    before = held_out_residuals(first_beside(search, last), ensembles, whiten, relaxed)
    return before, held_out_residuals(last, ensembles, whiten, relaxed) if last.causes else before


def _held_out_rows(old: HeldOutResiduals, new: HeldOutResiduals, ensembles: Sequence[NoiseEnsemble]) -> HeldOut:
    """What is left of all their rows by the base model, and by causes."""
    motors = ensembles[0].data.arm.M
    of_equations = gains(old, new, motors)
    worse = tuple(
        g.measure
        for g in of_equations
        if g.after - g.before > _WORSE_SIGMAS * g.sigma and g.after > ABOVE_NOISE_RATIO * g.noise_floor
    )
    before, after = held_out_excess(old, new), held_out_excess(new, new)
    # causes must take from other recordings as much of what stands plainly above noise as where they were fitted
    holds = after.energy_above_limit <= (1 - MIN_EXPLAINED) * before.energy_above_limit
    return HeldOut(
        gains=of_equations,
        remainder=remainders(before, after, motors, held_out=True),
        holds=holds,
        worse=worse,
        residuals=new,
        residuals_before=old,
        ensembles=tuple(ensembles),
    )
