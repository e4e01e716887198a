"""What the simulation gets wrong, its cause, and what the model gains by it: the whole diagnosis of recordings of one arm."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from diagnosis.arm_error import ArmError, arm_error
from diagnosis.cause import Cause
from diagnosis.cause_parameters import parameters_of
from diagnosis.cause_picture import CausePicture, cause_pictures
from diagnosis.cause_search import Search
from diagnosis.cause_share import CauseShare, cause_shares
from diagnosis.detectability import Detectability, detectability
from diagnosis.drawing_findings import DrawingFinding, drawing_findings, furthest_in_words
from diagnosis.findings import Findings, HeldOut, findings, first_beside
from diagnosis.fit_stage import FitStage
from diagnosis.held_out_gain import Gain
from diagnosis.hypothesis import Hypothesis, as_described
from diagnosis.law_gains import GainedLaw
from diagnosis.noise_ensemble import noise_ensemble
from diagnosis.noise_excess import NoiseExcess
from diagnosis.remainder import Remainder, plainly_left, remainders
from diagnosis.residual_episodes import Episode
from diagnosis.short_disturbances import stretches_in_words
from diagnosis.signature import Signature, signature
from diagnosis.simulated_gain import SimulatedModel, simulated_gains, simulated_shares
from diagnosis.worth_naming import MIN_EXPLAINED
from identification.dataset.dataset import DataSet
from identification.dataset.frames import frame_angles
from identification.estimates import common_arm
from xneck_foundation.errors import Refused
from xneck_foundation.one_blas_thread import one_blas_thread
from xneck_foundation.parameter import Parameter

TOO_MANY_TIED = 4
"""causes that explain alike from which the data cannot decide (docs/thresholds.md)"""
MIN_RATIO_ELSEWHERE = 3.0
"""times noise that an equation is left with on recordings that were not fitted, from which something acts there alone
(docs/thresholds.md)"""
MAX_INVISIBLE_SHARE = 0.5
"""of the effects: what recordings may not show at most, to say that there is none (docs/thresholds.md)"""
MOTORS_STICK = (
    "motors stick: dry friction holds them at rest by anything up to its greatest, and what is left there counts little"
)
_HELD_OUT_SEED = 100
"""added to the random seed of recordings that are not fitted"""
_MAX_WARNINGS = 3
"""of `sync`, that are repeated"""


@dataclass(frozen=True)
class Diagnosis:
    """A verdict with what it rests on."""

    verdict: str
    """consistent, cause, ambiguous, unknown or insufficient"""
    why: str
    search: Search
    detectability: Detectability
    """what these recordings could have shown"""
    signature: Signature
    """where, when and against what the base model errs"""
    gains: tuple[Gain, ...]
    """on recordings that were not fitted"""
    remainder: tuple[Remainder, ...]
    """of each equation what nothing named explains: on recordings that were not fitted, if there are any"""
    drawing: tuple[DrawingFinding, ...]
    """what the recordings say about numbers that have a tolerance"""
    extended_stage: FitStage
    """the fit of the causes and the laws"""
    found_laws: tuple[GainedLaw, ...] = ()
    """laws that no catalogue holds, in what the causes leave"""
    not_simulated: str = ""
    """why, where one of both models is none that moves"""
    simulated_shares: tuple[float | None, ...] = ()
    """of each cause, rad: by how much simulated joint angles differ without it; none where nothing was simulated"""
    set_aside: tuple[tuple[Episode, ...], tuple[Episode, ...]] = ((), ())
    """stretches of the recordings that were fitted, and of those that were not, in which something short acts that outweighs all"""
    arm_error: ArmError | None = None
    """how far the simulated arm is from the measured one; None where nothing was simulated"""

    @property
    def extended(self) -> Hypothesis:
        """The description with the causes and the laws in it."""
        return self.extended_stage.hypothesis

    @property
    def before(self) -> NoiseExcess:
        """What the base model leaves where it was fitted."""
        return self.search.first.excess

    @property
    def after(self) -> NoiseExcess:
        """What is left with the causes and the laws."""
        return self.extended_stage.excess

    @property
    def is_extended(self) -> bool:
        """Whether the extended model has anything that the base model lacks."""
        return bool(self.causes or self.found_laws)

    @property
    def causes(self) -> tuple[Cause, ...]:
        """As named, with numbers: those of the fit of causes and laws."""
        return self.extended_stage.causes[: len(self.search.named)]

    @property
    def numbers(self) -> tuple[tuple[Parameter, ...], ...]:
        """Of each cause, with sigma."""
        return parameters_of(self.extended_stage)[: len(self.search.named)]

    @property
    def shares(self) -> tuple[CauseShare, ...]:
        """What each cause does."""
        return cause_shares(self.extended_stage, self.simulated_shares)[: len(self.search.named)]

    @cached_property
    def pictures(self) -> tuple[CausePicture, ...]:
        """Of each cause, then of each law."""
        return cause_pictures(self.extended_stage)

    @property
    def something_remains(self) -> bool:
        """Whether something unknown remains beside what is named."""
        return bool(self.causes) and bool(plainly_left(self.remainder) or any(self.set_aside))

    @property
    def explained(self) -> float:
        """Share of what stood above noise that the causes take away."""
        return 1 - self.search.last.excess.share_of(self.before) if self.before.energy else 0.0


@one_blas_thread
def diagnose(
    recordings: Sequence[DataSet],
    held_out: Sequence[DataSet] = (),
    seed: int = 0,
    progress: Callable[[str], object] = lambda step: None,
) -> Diagnosis:
    """Recordings of one arm, fitted together, and others of it on which the gain is measured.

    Raises Refused where they are of different arms, one is both fitted and held out, a motor stands still, or forces are missing.

    >>> import xneck
    >>> found = xneck.diagnose([xneck.read_dataset("monday.mcap")], [xneck.read_dataset("tuesday.mcap")])
    >>> found.verdict, [cause.effect.name for cause in found.causes]
    ('cause', ['tip_payload'])
    >>> all(gain.after < gain.before / 2 for gain in found.gains)  # on tuesday's, which nothing was fitted to
    True
    """
    _check(recordings, held_out)
    h = as_described(recordings[0].neck)
    progress("noise")
    fitted = [noise_ensemble(data, frame_angles(data), seed + i) for i, data in enumerate(recordings)]
    others = [noise_ensemble(data, frame_angles(data), seed + _HELD_OUT_SEED + i) for i, data in enumerate(held_out)]
    found = findings(h, fitted, others, seed, progress)
    search, laws, stage, held = found.search, found.laws, found.stage, found.held
    simulation = _simulation(search, stage, held, progress)
    visible = detectability(search)
    left = held.remainder or remainders(search.first.excess, stage.excess, h.arm.M, held_out=False)
    verdict, why = _verdict(found, visible, left)
    drawing = drawing_findings(stage)
    if verdict == "consistent":
        # the arm that agrees is the one that the recordings tell, not the one that is drawn
        why = "; ".join(filter(None, [why, furthest_in_words(drawing)]))
    if found.taken_back:
        names = ", ".join(found.taken_back)
        why = "; ".join(filter(None, [why, f"{names} would explain more, but not on recordings that were not fitted"]))
    aside = [
        stretches_in_words(stretches, count) + of
        for stretches, count, of in (
            (found.stretches, len(recordings), ""),
            (held.stretches, len(held_out), " of what was not fitted"),
        )
        if stretches
    ]
    if aside:
        why = "; ".join(
            filter(None, [why, f"set aside, as something short outweighs all there: {', and '.join(aside)}"])
        )
    if stage.before_causes.held.motors:
        why = "; ".join(filter(None, [why, MOTORS_STICK]))
    if verdict == "unknown":
        # what was doubted of a log or of the arm's description may be what no cause explains
        why = "; ".join([why, *(f"`sync` warned: {words}" for words in _warnings(recordings))])
    return Diagnosis(
        verdict=verdict,
        why=why,
        search=search,
        detectability=visible,
        signature=_signature(found),
        gains=(*held.gains, *simulation.gains),
        remainder=left,
        drawing=drawing,
        extended_stage=stage,
        found_laws=laws,
        not_simulated=simulation.refused,
        simulated_shares=simulation.shares[: len(search.named)],
        arm_error=simulation.arm_error,
        set_aside=(found.stretches, held.stretches),
    )


def _signature(found: Findings) -> Signature:
    """Of what the base model leaves, with the stretches that were set aside for causes."""
    of_base = signature(found.search.first, found.search.last)
    return replace(of_base, episodes=found.stretches) if found.stretches and found.search.named else of_base


def _warnings(recordings: Sequence[DataSet]) -> list[str]:
    """Of the clocks of recordings, each once."""
    return list(dict.fromkeys(words for data in recordings for words in data.clock.get("warnings", ())))[:_MAX_WARNINGS]


def _check(recordings: Sequence[DataSet], held_out: Sequence[DataSet]) -> None:
    for data in (*recordings, *held_out):
        if "f1" not in data.state.columns:
            raise Refused("diagnose", "a data set holds no forces f", "log the force command of every motor")
    if any(_same(a, b) for a in recordings for b in held_out):
        raise Refused("diagnose", "a recording is fitted and held out at once", "hold out another one of the same arm")
    common_arm([*recordings, *held_out])


def _same(a: DataSet, b: DataSet) -> bool:
    return len(a.state) == len(b.state) and np.array_equal(a.state.matrix("theta"), b.state.matrix("theta"))


@dataclass(frozen=True)
class _Simulation:
    """What simulations of recordings that were not fitted say; nothing, where there are none."""

    gains: tuple[Gain, ...] = ()
    shares: tuple[float | None, ...] = ()
    """of each cause, rad"""
    arm_error: ArmError | None = None
    refused: str = ""
    """why, where one of both models is none that moves"""


def _simulation(
    search: Search,
    last: FitStage,
    held: HeldOut,
    progress: Callable[[str], object],
) -> _Simulation:
    """With the causes of the last stage, and without; held: what these recordings say of their equations."""
    if held.residuals is None or held.residuals_before is None or (held.worse and last.causes):
        return _Simulation()
    progress("simulation")
    try:
        with_them = SimulatedModel(last, held.residuals, held.ensembles)
        without = with_them
        if last.causes:
            first = first_beside(search, last)
            without = SimulatedModel(first, held.residuals_before, held.ensembles, noise_floor=False)
        return _Simulation(
            gains=simulated_gains(without, with_them),
            shares=simulated_shares(with_them, last.causes),
            arm_error=arm_error(without.simulated, with_them.simulated, last.before_causes.arm),
        )
    except Refused as refused:  # a model that cannot be simulated is a result, not the end of the diagnosis
        return _Simulation(refused=str(refused))


def _verdict(found: Findings, visible: Detectability, left: Sequence[Remainder]) -> tuple[str, str]:
    """The verdict and why; left: of each equation."""
    search, laws = found.search, found.laws
    law, plain = unlisted_law(search, laws), plainly_left(left)
    if not search.named:
        if found.stretches:
            return "unknown", "beside short disturbances nothing stands above noise"
        if search.first.excess.above_noise:
            why = "the data differ from the model, and no cause that is known explains it"
            return "unknown", "; ".join(filter(None, [why, law]))
        if plain and plain[0].ratio > MIN_RATIO_ELSEWHERE:
            there = (
                f"{plain[0].equation} is left with {plain[0].ratio:.1f} times noise on recordings that were not fitted"
            )
            return "unknown", f"nothing stands above noise where it was fitted, but {there}: fit those recordings too"
        if len(visible.invisible) > MAX_INVISIBLE_SHARE * len(visible.effects):
            return "insufficient", f"these recordings could not show {', '.join(visible.invisible)}"
        return "consistent", "nothing stands above noise"
    if not found.held.holds:
        worst = max(r.ratio for r in left)
        why = f"what explains the fitted recordings leaves {worst:.1f} times noise on those that were not fitted"
        return "insufficient", why
    remains = law if laws else ""
    if plain:
        remains = f"something unknown remains: {plain[0].equation} is left with {plain[0].ratio:.1f} times noise"
        remains = "; ".join(filter(None, [remains, law]))
    if max(len(named.tied) for named in search.named) >= TOO_MANY_TIED:
        return "insufficient", "; ".join(filter(None, ["too many causes explain the data alike", remains]))
    if any(len(named.tied) > 1 for named in search.named):
        return "ambiguous", "; ".join(filter(None, ["several causes explain the data alike", remains]))
    return "cause", remains


def unlisted_law(search: Search, laws: Sequence[GainedLaw]) -> str:
    """The laws that were found in the rest, in words, else what a function of one variable would explain of a good part of it."""
    if laws:
        return f"found beside the catalogue: {', and '.join(found.law.words for found in laws)}"
    rest = search.unlisted
    if rest is None or rest.explains < MIN_EXPLAINED:
        return ""
    function = rest.function
    return (
        f"a law of the {function.equation} that follows the {function.follows} would explain {rest.explains:.0%} of it"
    )
