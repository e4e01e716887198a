"""Laws that nobody listed: any smooth function of one variable, in the equation of every motor or of every joint.

A cause stands in for such a law where it happens to do much of what that does. A free function then leaves far less than all causes
together, and what acts is not known. It also says where an unknown law acts, and by what.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from diagnosis.effect import Effect, Shape
from diagnosis.fit_stage import FitStage
from diagnosis.judged_rows import judged
from diagnosis.linearisation import RecordingLinearisation
from diagnosis.noise_excess import NoiseExcess, noise_excess
from diagnosis.shown_by import ShownBy
from diagnosis.whitened_comparison import WhitenedComparison
from identification.residuals import changes_by_forces
from identification.whitening import Whitener
from mechanism.friction import dry
from mechanism.laws import Term

Array = NDArray[np.float64]

_HATS = 8
"""pieces of a function along its variable, as many rows in each"""
MAX_FORCE_SHARE = 0.5
"""of the largest force that the motors are told: a function that takes more is the scale of all forces, not a law
(docs/thresholds.md)"""
_MOTOR_HARMONICS, _DRUM_HARMONICS = 12, 4
"""of a turn"""


@dataclass(frozen=True)
class Variable:
    """What a function may be of, and what it adds to."""

    name: str
    unit: str
    """SI; `turn` where its values are folded into one"""
    acts: Literal["friction", "pull", "resistance"]
    """against the motors, in the cables' tension, or against the joints"""
    values: Callable[[RecordingLinearisation], Array]
    """in a recording's rows, (T, places)"""
    turn_harmonics: int = 0
    """of what comes round with a turn; 0 where nothing does"""
    along_motion: bool = False
    """whether it turns over with the motor's direction"""


def _force(recording: RecordingLinearisation) -> Array:
    return recording.signals.f


def _motor_angle(recording: RecordingLinearisation) -> Array:
    return recording.signals.theta


def _drum_angle(recording: RecordingLinearisation) -> Array:
    return recording.signals.theta / [motor.R for motor in recording.hypothesis.neck.motors]


def _time(recording: RecordingLinearisation) -> Array:
    s = recording.signals
    return np.repeat(s.time[:, None], max(s.arm.M, s.arm.N), axis=1)


VARIABLES = (
    Variable("force", "N", "friction", _force),
    Variable("force", "N", "friction", _force, along_motion=True),
    Variable("tension", "N", "friction", lambda r: r.tension),
    Variable("tension", "N", "friction", lambda r: r.tension, along_motion=True),
    Variable("motor's turn", "turn", "friction", _motor_angle, turn_harmonics=_MOTOR_HARMONICS),
    Variable("motor's turn", "turn", "friction", _motor_angle, turn_harmonics=_DRUM_HARMONICS, along_motion=True),
    Variable("drum's turn", "turn", "friction", _drum_angle, turn_harmonics=_DRUM_HARMONICS),
    Variable("motor's speed", "rad/s", "friction", lambda r: r.signals.theta_d),
    Variable("time", "s", "friction", _time),
    Variable("time", "s", "friction", _time, along_motion=True),
    Variable("drum's turn", "turn", "pull", _drum_angle, turn_harmonics=_DRUM_HARMONICS),
    Variable("force", "N", "pull", _force),
    Variable("joint's angle", "rad", "resistance", lambda r: r.signals.alpha),
    Variable("joint's speed", "rad/s", "resistance", lambda r: r.signals.alpha_d),
    Variable("time", "s", "resistance", _time),
)


class FreeFunction(Effect):
    """A function of one variable, as columns: a force on the motors, or a torque on the joints."""

    name = "free_function"
    words = "a law that nobody listed"
    may_sit_alone = False

    variable: ClassVar[Variable]

    def columns(self, recording: RecordingLinearisation, shape: Shape) -> Array:
        s = recording.signals
        patterns = self.patterns(recording)
        if self.variable.along_motion:
            patterns = patterns * dry(s.speeds.mean).mean(axis=0)
        term = self.terms[0]
        changes = changes_by_forces(s, term, **{self.variable.acts: patterns})
        return changes.reshape(*changes.shape[:2], -1)

    def patterns(self, recording: RecordingLinearisation) -> Array:
        """What a unit of each term adds, (K, T, places), before the motion's sign."""
        values = self.variable.values(recording)[:, : self.terms[0].count(recording.signals.arm)]
        if harmonics := self.variable.turn_harmonics:
            phase = np.arange(1, harmonics + 1)[:, None, None] * values
            return np.concatenate([np.sin(phase), np.cos(phase)])
        ranks = np.linspace(0, 1, _HATS)
        knots = np.quantile(values, ranks, axis=0)
        out = np.empty((_HATS, *values.shape))
        for place in range(values.shape[1]):
            at = np.interp(values[:, place], np.maximum.accumulate(knots[:, place]), np.arange(_HATS))
            out[:, :, place] = np.maximum(0.0, 1 - np.abs(at - np.arange(_HATS)[:, None]))
        return out

    @property
    def picture(self) -> ShownBy:
        """Its variable, of the motor or joint on which it acts."""
        of = self.variable

        def values(recording: RecordingLinearisation, place: int) -> Array:
            kept = of.values(recording)[recording.signals.low_pass.kept, place]
            return kept / (2 * np.pi) % 1 if of.turn_harmonics else kept

        return ShownBy(
            equation="joint" if of.acts == "resistance" else "motor",
            name=of.name,
            unit=of.unit,
            values=values,
            along_motion=of.along_motion,
            is_cyclic=bool(of.turn_harmonics),
        )

    @property
    def equation(self) -> str:
        """In which equations it acts, in words."""
        return {"friction": "motors", "pull": "cables", "resistance": "joints"}[self.variable.acts]

    @property
    def follows(self) -> str:
        """What it is a function of, in words."""
        return self.variable.name + (", along the motion" if self.variable.along_motion else "")


def _function_of(of: Variable) -> FreeFunction:
    count = range(1, 1 + (2 * of.turn_harmonics or _HATS))

    class Of(FreeFunction):
        variable = of
        place = "joint" if of.acts == "resistance" else "motor"
        terms = (
            tuple(Term(f"b{i}", "N m", low=-np.inf, high=np.inf, size=0.01, of="joint") for i in count)
            if of.acts == "resistance"
            else tuple(Term(f"b{i}", "N", low=-np.inf, high=np.inf, size=1.0) for i in count)
        )

    return Of()


FREE_FUNCTIONS = tuple(_function_of(variable) for variable in VARIABLES)


@dataclass(frozen=True)
class FreeFit:
    """The function that explains most, and what it leaves."""

    function: FreeFunction
    explains: float
    """share of what stood above noise"""
    excess: NoiseExcess
    residuals: tuple[Array, ...]
    """what it leaves of each recording, (C, S), as it is judged"""
    done: tuple[Array, ...]
    """what it does to them, (C, S)"""

    def as_json(self) -> dict[str, Any]:
        """For the record."""
        function = self.function
        return {"equation": function.equation, "follows": function.follows, "explains": self.explains}


def best_free_function(stage: FitStage, whiten: Whitener) -> FreeFit | None:
    """Beside a stage's numbers, causes and nuisances; none that takes back most of what the motors are told."""
    at = stage.comparison.linearisation
    whitened = WhitenedComparison(stage.comparison, whiten)
    variance = [recording.input_variance for recording in at.recordings]
    largest = MAX_FORCE_SHARE * max(float(np.abs(recording.signals.f).max()) for recording in at.recordings)
    fits = []
    for function in FREE_FUNCTIONS:
        beside = whitened.beside(function, {})
        (group,) = beside.groups
        fit = beside.fit(group.columns)
        if function.place == "motor" and np.abs(fit.numbers[np.isin(fit.columns, group.columns)]).max() > largest:
            continue
        left = beside.residuals_after(fit)
        residuals = [judged(r, recording.signals) for r, recording in zip(left, at.recordings, strict=True)]
        excess = noise_excess(residuals, stage.judged_noise, variance)
        own = np.isin(fit.columns, group.columns)
        done = [
            judged(matrix[..., fit.columns[own]] @ fit.numbers[own], recording.signals)
            for matrix, recording in zip(beside.matrices, at.recordings, strict=True)
        ]
        explains = 1 - excess.energy / stage.excess.energy
        fits.append(FreeFit(function, explains, excess, tuple(residuals), tuple(done)))
    return max(fits, key=lambda fit: fit.explains, default=None)


class FreeFits:
    """The best free function beside each stage that is asked about, each found once."""

    def __init__(self) -> None:
        self._known: list[tuple[FitStage, Whitener, FreeFit | None]] = []

    def best(self, stage: FitStage, whiten: Whitener) -> FreeFit | None:
        """As `best_free_function`."""
        for known, known_whiten, fit in self._known:
            if known is stage and known_whiten is whiten:
                return fit
        self._known.append((stage, whiten, best_free_function(stage, whiten)))
        return self._known[-1][2]
