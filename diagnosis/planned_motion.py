"""What a planned motion would show of effects: their columns along it, beside the noise that its angles would have.

Nothing is recorded or fitted. The base model, the drawing within its tolerances and the clock are free, as in a diagnosis. An
effect shows by what is left of it when all these, and an effect that may stand in its place, have taken what they can.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.compare import compare
from diagnosis.comparison import Comparison
from diagnosis.effect import Effect, Shape
from diagnosis.hypothesis import BASE_LAWS, Hypothesis, as_described, base_terms
from diagnosis.linearisation import base_unknowns, linearise
from diagnosis.nuisances import MAX_TOLERANCES, nuisances_at
from diagnosis.planned_noise import planned_whitener
from diagnosis.worth_naming import MIN_LOSS_SHARE, tie_tolerance
from identification.design.information import AngleNoise, noise_free_signals
from identification.design.trajectory import Trajectory
from identification.signals import TRAVEL_CLOCK_SIGMA_S
from mechanism.description import Neck
from mechanism.machine import Machine
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

_CLOCK_SIGMA_S = 1e-4
"""s: sigma that `sync` gives the clock of a minute of lively motion (docs/thresholds.md)"""
_ENOUGH = 10.0
"""times what it needs to be told: a motion that shows an effect better is worth no more (docs/thresholds.md)"""


@dataclass(frozen=True)
class Suspect:
    """An effect that may be there, where, and how large."""

    effect: Effect
    shape: Shape
    columns: tuple[int, ...]
    """of the effect's columns"""
    numbers: Array
    """their amounts, in sizes, (len(columns),)"""


@dataclass(frozen=True)
class Question:
    """Whether a motion shows an effect, and tells it from one that may stand in its place."""

    suspects: tuple[Suspect, ...]
    """one effect in the places where it may be: the place that is told least counts"""
    beside: Effect | None = None
    """which may sit anywhere, and be of any size; None: whether the effect shows at all"""

    @property
    def effect(self) -> Effect:
        """The one that is asked about."""
        return self.suspects[0].effect


@dataclass(frozen=True)
class Answer:
    """Of one question: what is left of the effect, and what must be left to tell it, as losses."""

    question: Question
    loss: float
    needed: float

    @property
    def ratio(self) -> float:
        """Above one where the motion tells it."""
        return self.loss / self.needed


@dataclass(frozen=True)
class MotionJudge:
    """Answers questions by motions of one arm."""

    hypothesis: Hypothesis
    p: Array
    """numbers of the base model"""
    questions: tuple[Question, ...]
    noise: AngleNoise

    def answers(self, motion: Trajectory) -> tuple[Answer, ...]:
        """Of every question, by one motion."""
        planned = self.comparison(motion)
        nothing_else = planned.with_zero_residual()
        return tuple(
            min((_answer(planned, nothing_else, q, s) for s in q.suspects), key=lambda a: a.ratio)
            for q in self.questions
        )

    def shortfall(self, motion: Trajectory) -> float:
        """The less, the better a motion answers the questions: minus the sum of the logarithms of their ratios, up to _ENOUGH."""
        return -sum(float(np.log(np.clip(a.ratio, 1e-12, _ENOUGH))) for a in self.answers(motion))

    def comparison(self, motion: Trajectory) -> Comparison:
        """The motion with the effects of all questions side by side, with nothing to be explained yet."""
        signals = noise_free_signals(motion, (_CLOCK_SIGMA_S, TRAVEL_CLOCK_SIGMA_S))
        at = linearise(self.hypothesis, [replace(signals, arm=self.hypothesis.arm)], self.p, np.zeros(1))
        choices: dict[tuple[object, ...], tuple[Effect, Shape]] = {}
        for q in self.questions:
            others = [] if q.beside is None else [(q.beside, shape) for shape in q.beside.start_shapes]
            for effect, shape in [*((s.effect, s.shape) for s in q.suspects), *others]:
                choices[effect.name, *sorted(shape.items())] = effect, shape
        whiten = planned_whitener(at, self.noise)
        return compare(at, (), list(choices.values()), nuisances_at(at), whiten, clock_relaxed=True)


def motion_judge(neck: Neck, machine: Machine, questions: Sequence[Question], noise: AngleNoise) -> MotionJudge:
    """Of an arm as described, with a machine's laws and numbers. Raises Refused where these are not those of the base model."""
    for law in BASE_LAWS:
        if law not in machine.names:
            follows = ", ".join(machine.names)
            raise Refused(
                "design --for",
                f"effects are told beside the law {law}, and the model follows {follows}",
                "leave --model out",
            )
    laws = tuple(name for name in machine.names if name not in BASE_LAWS)
    own = {law_term: value for law_term, value in machine.values.items() if law_term not in base_terms()}
    h = replace(as_described(neck), laws=laws, values={name: np.atleast_1d(value) for name, value in own.items()})
    u = base_unknowns(h, 1)
    p = u.start()
    for (name, recording), slot in u.slots.items():
        if recording is None and name in machine.values:
            p[slot] = machine.values[name]
    return MotionJudge(h, p, tuple(questions), noise)


def loss_alone(nothing_else: Comparison, suspect: Suspect, beside: Sequence[int] | NDArray[np.intp] = ()) -> float:
    """What is left of a suspect where there is nothing else, once columns beside it have taken what they can.

    nothing_else: a comparison `with_zero_residual`, which holds the suspect's effect and shape.
    """
    columns = next(g.columns for g in nothing_else.groups if _is_of(g.effect, g.shape, suspect))
    numbers = np.zeros(len(nothing_else.prior_sigma))
    numbers[columns[list(suspect.columns)]] = suspect.numbers
    return nothing_else.with_fixed(numbers).fit(beside, clock_relaxed=not suspect.effect.is_clock).loss


def _answer(planned: Comparison, nothing_else: Comparison, question: Question, suspect: Suspect) -> Answer:
    alone, rows = loss_alone(nothing_else, suspect), planned.row_count
    if question.beside is None:
        by_tolerance = suspect.effect.has_tolerance
        return Answer(question, alone, MAX_TOLERANCES**2 if by_tolerance else MIN_LOSS_SHARE * (rows + alone))
    of_rival = [g.columns for g in planned.groups if g.effect is question.beside]
    left = min(loss_alone(nothing_else, suspect, columns) for columns in of_rival)
    return Answer(question, left, tie_tolerance(rows, alone))


def _is_of(effect: Effect, shape: Shape, suspect: Suspect) -> bool:
    return effect is suspect.effect and dict(shape) == dict(suspect.shape)
