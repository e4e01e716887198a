"""Laws that no catalogue holds, looked for in what all causes leave: in each motor's, cable's and joint's equation.

What a law does to the equations is a sum over fine columns of its variable, which are formed once. Beside every law all numbers
of the base model, of nuisances and of causes stay free.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause_fit import FitStage
from diagnosis.cause_search import MIN_LOSS_SHARE
from diagnosis.comparison import FOLD_BLOCK_S, ColumnFit
from diagnosis.effect import Effect, Shape
from diagnosis.linearisation import RecordingLinearisation
from discovery.fine_basis import FineBasis, Function
from discovery.form import Kind
from discovery.found_law import FoundLaw
from discovery.problem import Candidate, Problem
from discovery.search import find_laws, fitted_laws
from identification.fitting import segment_starts
from identification.residuals import LawForces, residual_change
from identification.whitening import Whitener
from mechanism.friction import dry
from mechanism.laws import Term

Array = NDArray[np.float64]
Index = NDArray[np.intp]
Acts = Literal["friction", "pull", "resistance"]
"""against the motors, in the cables' tension, or against the joints"""
_EQUATIONS: dict[Acts, tuple[str, str, str]] = {
    "friction": ("motor", "N", "against the motors"),
    "pull": ("cable", "N", "in the cables"),
    "resistance": ("joint", "N m", "against the joints"),
}
_UNIT_FORCE = Term("unit", "N", low=-np.inf, high=np.inf, size=1.0)
_UNIT_TORQUE = Term("unit", "N m", low=-np.inf, high=np.inf, size=1.0, of="joint")


@dataclass(frozen=True)
class Followed:
    """A variable in an equation, at all its places."""

    acts: Acts
    name: str
    """as the contract has it"""
    unit: str
    kind: Kind
    values: Callable[[RecordingLinearisation], Array]
    """in a recording's rows, (T, places)"""
    along_motion: bool = False
    """whether it turns over with the motor's direction"""

    @property
    def detail(self) -> str:
        """Where it acts, in words."""
        return _EQUATIONS[self.acts][2]

    @property
    def follows(self) -> tuple[str, ...]:
        """What a law of it follows: the motor's speed too, where it turns over with that."""
        return (self.name, "motor_speed") if self.along_motion else (self.name,)

    def places(self, recording: RecordingLinearisation) -> int:
        """How many it has."""
        arm = recording.signals.arm
        return arm.N if self.acts == "resistance" else arm.M

    def values_at(self, recording: RecordingLinearisation) -> Array:
        """(T, places)."""
        return self.values(recording)[:, : self.places(recording)]

    def change(self, recording: RecordingLinearisation, pattern: Array) -> Array:
        """What a force or torque (T, places) does to the residuals, place by place, (C, S, places)."""
        s = recording.signals
        if self.along_motion:
            pattern = pattern * dry(s.speeds.mean).mean(axis=0)
        nothing = np.zeros_like(s.f)
        base = LawForces(nothing, nothing, nothing, np.zeros_like(s.alpha))
        term = _UNIT_TORQUE if self.acts == "resistance" else _UNIT_FORCE
        return residual_change(s, base, replace(base, **{self.acts: pattern}), term)


def _drum_angle(recording: RecordingLinearisation) -> Array:
    return recording.signals.theta / [motor.R for motor in recording.hypothesis.neck.motors]


def _time(recording: RecordingLinearisation) -> Array:
    s = recording.signals
    return np.repeat((s.time - s.time[0])[:, None], max(s.arm.M, s.arm.N), axis=1)


FOLLOWED = (
    Followed("friction", "force", "N", "line", lambda r: r.signals.f),
    Followed("friction", "force", "N", "line", lambda r: r.signals.f, along_motion=True),
    Followed("friction", "tension", "N", "line", lambda r: r.tension),
    Followed("friction", "tension", "N", "line", lambda r: r.tension, along_motion=True),
    Followed("friction", "motor_angle", "rad", "turn", lambda r: r.signals.theta),
    Followed("friction", "motor_angle", "rad", "turn", lambda r: r.signals.theta, along_motion=True),
    Followed("friction", "drum_angle", "rad", "turn", _drum_angle),
    Followed("friction", "drum_angle", "rad", "turn", _drum_angle, along_motion=True),
    Followed("friction", "motor_speed", "rad/s", "line", lambda r: r.signals.theta_d),
    Followed("friction", "time", "s", "time", _time),
    Followed("friction", "time", "s", "time", _time, along_motion=True),
    Followed("pull", "drum_angle", "rad", "turn", _drum_angle),
    Followed("pull", "tension", "N", "line", lambda r: r.tension),
    Followed("resistance", "joint_angle", "rad", "line", lambda r: r.signals.alpha),
    Followed("resistance", "joint_speed", "rad/s", "line", lambda r: r.signals.alpha_d),
    Followed("resistance", "time", "s", "time", _time),
)


@dataclass(frozen=True)
class UnlistedLaws:
    """Laws beside a stage, and the stage's numbers with them."""

    laws: tuple[FoundLaw, ...]
    fit: ColumnFit
    """of the base model, nuisances and causes with the laws"""
    effect: "AsFound"
    """all laws as one column"""


class AsFound(Effect):
    """Laws as they were found, as one column whose number is one."""

    name = "found_laws"
    words = "laws that nobody listed"
    place = "arm"
    terms = (_UNIT_FORCE,)

    def __init__(self, laws: Sequence[FoundLaw]) -> None:
        self._laws = tuple(laws)

    def columns(self, recording: RecordingLinearisation, shape: Shape) -> Array:
        out = np.zeros((*recording.rows.residual.shape, 1))
        for law in self._laws:
            followed, place = _followed_at(law.candidate)
            values = followed.values_at(recording)
            count = law.candidate.places
            pattern = np.zeros_like(values)
            for i, j in enumerate(range(values.shape[1]) if place is None else [place]):
                pattern[:, j] = law.function(values[:, j]) @ law.amounts[i::count]
            out[..., 0] += followed.change(recording, pattern).sum(axis=2)
        return out

    def sizes(self, arm: object) -> Array:
        return np.ones(1)


def _followed_at(candidate: Candidate) -> tuple[Followed, int | None]:
    """The variable of a candidate, and its place counted from 0; None for all."""
    (followed,) = (f for f in FOLLOWED if (f.detail, f.follows) == (candidate.detail, candidate.follows))
    return followed, None if candidate.where == "all" else int(candidate.where.split()[-1]) - 1


@dataclass(frozen=True)
class _StageProblem(Problem):
    """Where laws are looked for beside a stage."""

    stage: FitStage
    whiten: Whitener
    least_gain: float = 0.0
    _fine: dict[tuple[str, tuple[str, ...]], NDArray[np.float32]] = field(default_factory=dict)
    """whitened fine columns of every variable, (rows, K, places)"""

    @cached_property
    def target(self) -> Array:
        return -self._matrix[:, -1]

    @cached_property
    def base(self) -> Array:
        return self._matrix[:, self.columns_of_stage]

    @cached_property
    def columns_of_stage(self) -> Index:
        """Those that the stage fits."""
        return self.stage.fit.columns

    @cached_property
    def precision(self) -> Array:
        sigma = self.stage.comparison.relaxed_sigma[self.columns_of_stage]
        return np.where(np.isfinite(sigma), sigma, np.inf) ** -2.0

    @cached_property
    def blocks(self) -> Index:
        out, first = [], 0
        for recording in self._recordings:
            s = recording.signals
            length = max(1, round(FOLD_BLOCK_S / (s.step * s.low_pass.factor)))
            channels, rows = recording.rows.residual.shape
            of_rows = first + np.arange(rows) // length
            out.append(np.tile(of_rows, channels))
            first = int(of_rows[-1]) + 1
        return np.concatenate(out)

    @cached_property
    def candidates(self) -> tuple[Candidate, ...]:
        out = []
        for followed in FOLLOWED:
            values = [followed.values_at(r) for r in self._recordings]
            place, unit, _ = _EQUATIONS[followed.acts]
            count = values[0].shape[1]
            for where in (None, *range(count)):
                seen = [v if where is None else v[:, where] for v in values]
                basis = self._basis(followed)
                if where is not None:  # forms are tried where this place went, in the columns of all
                    basis = replace(basis, reach=(float(min(v.min() for v in seen)), float(max(v.max() for v in seen))))
                out.append(
                    Candidate(
                        where="all" if where is None else f"{place} {where + 1}",
                        follows=followed.follows,
                        unit=followed.unit,
                        kind=followed.kind,
                        basis=basis,
                        target_unit=unit,
                        places=count if where is None else 1,
                        factor="sign(motor_speed)" if followed.along_motion else "",
                        detail=followed.detail,
                    )
                )
        return tuple(out)

    def columns(self, candidate: Candidate, function: Function) -> Array:
        followed, place = _followed_at(candidate)
        if function == candidate.basis.columns:
            fine = self._fine_columns(followed)
            chosen = fine.reshape(len(fine), -1) if place is None else fine[..., place]
            return chosen.astype(float)
        parts = []
        for recording in self._recordings:
            values = followed.values_at(recording)
            patterns = np.stack([function(values[:, j]) for j in range(values.shape[1])], axis=-1)  # (T, k, places)
            columns = [followed.change(recording, patterns[:, k]) for k in range(patterns.shape[1])]
            parts.append(self._white(recording, np.stack(columns, axis=2)))
        out = np.concatenate(parts)
        return out.reshape(len(out), -1) if place is None else out[..., place]

    def _fine_columns(self, followed: Followed) -> NDArray[np.float32]:
        key = followed.detail, followed.follows
        if key not in self._fine:
            basis = self._basis(followed)
            parts = []
            for recording in self._recordings:
                values = followed.values_at(recording)
                patterns = np.stack([basis.columns(v) for v in values.T], axis=-1)
                columns = [followed.change(recording, patterns[:, k]) for k in range(patterns.shape[1])]
                parts.append(self._white(recording, np.stack(columns, axis=2)).astype(np.float32))
            self._fine[key] = np.concatenate(parts)
        return self._fine[key]

    def _basis(self, followed: Followed) -> FineBasis:
        """Common to all places."""
        return FineBasis.of([followed.values_at(r).ravel() for r in self._recordings], followed.kind == "turn")

    @cached_property
    def _matrix(self) -> Array:
        pairs = zip(self.stage.comparison.matrices, self._recordings, strict=True)
        return np.concatenate([self._white(recording, matrix) for matrix, recording in pairs])

    @property
    def _recordings(self) -> tuple[RecordingLinearisation, ...]:
        return self.stage.comparison.linearisation.recordings

    def _white(self, recording: RecordingLinearisation, columns: Array) -> Array:
        """Columns (C, S, ...) whitened, (C S, ...)."""
        white = self.whiten(columns, segment_starts(recording.signals), recording.input_variance)
        return white.reshape(-1, *columns.shape[2:])


def unlisted_laws(stage: FitStage, whiten: Whitener, seed: int = 0) -> tuple[UnlistedLaws, ...]:
    """The laws beside a stage: the first alone, the first two, and so on, each time with all numbers fitted; none by chance."""
    problem = _StageProblem(stage, whiten, MIN_LOSS_SHARE * stage.noise_loss)
    laws = find_laws(problem, seed)
    return tuple(_with_numbers(problem, laws[: n + 1]) for n in range(len(laws)))


def _with_numbers(problem: _StageProblem, laws: tuple[FoundLaw, ...]) -> UnlistedLaws:
    fitted, numbers, loss = fitted_laws(problem, laws)
    return UnlistedLaws(fitted, ColumnFit(problem.columns_of_stage, numbers, loss), AsFound(fitted))
