"""Laws that no catalogue holds, looked for in what all causes leave: in each motor's, cable's and joint's equation.

What a law does to the equations is a sum over fine columns of its variable, which are formed once. Beside every law all numbers
of the base model, of nuisances and of causes stay free. What is found is fitted as a cause is, as a law of the machine.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause import Cause
from diagnosis.comparison import FOLD_BLOCK_S
from diagnosis.effect import LawEffect, Placement
from diagnosis.fit_stage import FitStage
from diagnosis.free_function import MAX_FORCE_SHARE
from diagnosis.linearisation import RecordingLinearisation
from diagnosis.shown_by import ShownBy
from diagnosis.worth_naming import MIN_EXPLAINED, MIN_LOSS_SHARE
from discovery.fine_basis import FineBasis, Function, stands_still
from discovery.form import Constants, Form
from discovery.found_law import FoundLaw
from discovery.problem import Candidate, Problem
from discovery.search import growing_laws
from identification.fitting import segment_starts
from identification.residuals import UNIT_FORCE, changes_by_forces
from identification.whitening import Whitener
from mechanism.arm import Arm
from mechanism.friction import dry
from mechanism.laws import Term
from mechanism.laws.unlisted import (
    VARIABLES,
    Misreading,
    UnlistedLaw,
    Variable,
    Winding,
    joint_direction,
    law_name,
    rubbing,
    unlisted_laws,
)

Array = NDArray[np.float64]
Index = NDArray[np.intp]
AGAINST_JOINTS, AGAINST_SEVERAL_JOINTS = "against the joints", "against the joints at once"
OF_ENCODERS = "in the encoder of the motors"
_ACTS = {
    "motor": ("friction", "against the motors"),
    "encoder": ("friction", OF_ENCODERS),
    "cable": ("pull", "in the cables"),
    "joint": ("resistance", AGAINST_JOINTS),
}
"""of what is acted on: the force that changes, and words"""
_VALUES: Mapping[str, Callable[[RecordingLinearisation], Array]] = {
    "force": lambda r: r.signals.f,
    "tension": lambda r: r.tension,
    "motor_angle": lambda r: r.signals.theta,
    "drum_angle": lambda r: r.signals.theta / r.signals.arm.gear,
    "motor_speed": lambda r: r.signals.theta_d,
    "joint_angle": lambda r: r.signals.alpha,
    "joint_speed": lambda r: r.signals.alpha_d,
    "time": lambda r: np.repeat(r.signals.since_began[:, None], max(r.signals.arm.M, r.signals.arm.N), axis=1),
}
"""in a recording's rows, (T, places), by the variable's name"""
_FACTORS: Mapping[str, Callable[[RecordingLinearisation], Array]] = {
    "sign(motor_speed)": lambda r: dry(r.signals.speeds.mean).mean(axis=0),
    "motor_speed": lambda r: r.signals.speeds.mean.mean(axis=0),
    "force": _VALUES["force"],
    "sign(joint_speed)": lambda r: joint_direction(r.signals.alpha_d),
    "joint_speed": _VALUES["joint_speed"],
}
"""what multiplies a function of a variable, (T, places)"""
MAX_BLOCKS = 60
"""that are looked at for laws; what is found is fitted to all rows (docs/thresholds.md)"""
_SMALL_MISREADING = 1e-6
"""of what an encoder reads too much: up to there what that does is in proportion to it"""
_UNIT_TORQUE = Term("unit", "N m", low=-np.inf, high=np.inf, size=1.0, of="joint")
_UNIT_TORQUE_OF_ARM = Term("unit", "N m", low=-np.inf, high=np.inf, size=1.0, of="arm")


@dataclass(frozen=True)
class _Rows:
    """Rows of a recording that are looked at: their places, and the block of each."""

    place: Index
    block: Index


class UnlistedEffect(LawEffect):
    """A law that was found, as a cause."""

    may_sit_everywhere = True

    def __init__(self, law: UnlistedLaw, words: str) -> None:
        self.name = self.law = law.name  # pyright: ignore[reportAttributeAccessIssue]
        self.words, self.place = words, _place(law.variable)  # pyright: ignore[reportAttributeAccessIssue]
        self.terms = law.amount_terms  # pyright: ignore[reportAttributeAccessIssue]
        fitted = (
            t for name, t in zip(law.form.constants, law.constant_terms, strict=True) if name not in law.form.fixed
        )
        self.shape_terms = tuple(fitted)  # pyright: ignore[reportAttributeAccessIssue]
        self.shown_by = _shown_by(law.variable)  # pyright: ignore[reportAttributeAccessIssue]


def _shown_by(variable: Variable) -> ShownBy:
    """Its variable, of the motor or joint on which it acts."""
    is_turn = variable.kind == "turn"

    def values(recording: RecordingLinearisation, place: int) -> Array:
        kept = _values_at(variable, recording)[recording.signals.low_pass.kept, 0 if variable.span else place]
        return kept / (2 * np.pi) % 1 if is_turn else kept

    return ShownBy(
        equation="joint" if variable.acts == "joint" else "motor",
        name=variable.name.replace("_", " ") + (f", sum over {variable.place}" if variable.span else ""),
        unit="turn" if is_turn else variable.unit,
        values=values,
        along_motion=variable.along_motion,
        is_cyclic=is_turn,
    )


def causes_of(laws: Sequence[FoundLaw], arm: Arm) -> tuple[Cause, ...]:
    """Laws as causes; of several of one kind each is a law of its own."""
    out: list[Cause] = []
    for law in laws:
        variable, place = _variable_at(law.candidate)
        same = [c for c in out if c.effect.name.startswith(law_name(variable, law.form))]
        machine_law = unlisted_laws()[law_name(variable, law.form, len(same) + 1)]
        effect = UnlistedEffect(machine_law, law.words)
        count = effect.place_count(arm)
        columns = range(len(law.amounts)) if place is None else range(place, len(law.amounts) * count, count)
        shape = {machine_law.term_name(name): float(value) for name, value in law.constants.items()}
        out.append(Cause(effect, Placement(law.candidate.where, tuple(columns)), law.amounts, shape))
    return tuple(out)


def as_fitted(laws: Sequence[FoundLaw], stage: FitStage) -> tuple[FoundLaw, ...]:
    """With the numbers of a stage whose last causes they are; sigma is wider where something is left above noise."""
    arm, covariance = stage.comparison.linearisation.hypothesis.arm, stage.comparison.covariance(stage.fit)
    out = []
    first = len(stage.causes) - len(laws)
    for law, cause, columns in zip(laws, stage.causes[first:], stage.columns_of_causes[first:], strict=True):
        rows = np.searchsorted(stage.fit.columns, columns)
        size = stage.widening * cause.sizes(arm)
        constants = {name.rsplit(".", 1)[-1]: value for name, value in cause.shape.items()}
        own = covariance[np.ix_(rows, rows)] * np.outer(size, size)
        out.append(replace(law, amounts=cause.amounts, constants=constants, covariance=own))
    return tuple(out)


def _variable_at(candidate: Candidate) -> tuple[Variable, int | None]:
    """The variable of a candidate, and its place counted from 0; None for all."""
    asked = candidate.detail, candidate.follows, candidate.factor
    same = (v for v in VARIABLES if (_detail(v), v.follows, v.factor) == asked)
    (variable,) = (v for v in same if v.place in ("", candidate.where))
    if variable.span:
        return variable, 0
    return variable, None if candidate.where == "all" else int(candidate.where.split()[-1]) - 1


def _place(variable: Variable) -> str:
    """What it has places of."""
    return "motor" if variable.misreads else variable.acts


def _detail(variable: Variable) -> str:
    """In which equations a law of it acts, in words."""
    return AGAINST_SEVERAL_JOINTS if variable.span else _ACTS[variable.acts][1]


def _values_at(variable: Variable, recording: RecordingLinearisation) -> Array:
    """(T, places)."""
    arm = recording.signals.arm
    return variable.spanned(_VALUES[variable.name](recording)[:, : arm.N if variable.acts == "joint" else arm.M])


def _forces(variable: Variable, recording: RecordingLinearisation, function: Function) -> dict[str, Array]:
    """What a function's columns add at every place, by field of `LawForces`, (k, T, places)."""
    s, values = recording.signals, recording.values

    def apart(x: Array) -> Array:
        return np.moveaxis(function(x.ravel()).reshape(*x.shape, -1), -1, 0)

    if variable.misreads:
        read, rubs = Misreading.of(lambda x: _SMALL_MISREADING * apart(x), s.theta), rubbing(values)
        pull = read.pull(values["k"], values["ca"], s.arm.drum * s.theta_d, s.arm)
        friction = read.friction(s.inertial + rubs(s.theta_d), rubs, s.theta_d, s.arm)
        return {"pull": pull / _SMALL_MISREADING, "friction": friction / _SMALL_MISREADING}
    if variable.winds:
        wound = Winding.of(variable, apart, s.theta, s.arm)
        damping = values["ca"] * wound.share_of_tension * s.arm.drum * s.theta_d
        pull, friction = values["k"] * wound.longer + damping, wound.share_of_tension * recording.tension
        return {"pull": pull, "friction": friction}
    # time last in memory, as filters take it
    patterns = np.stack([function(x).T for x in _values_at(variable, recording).T], axis=1)
    if variable.factor:
        patterns *= _FACTORS[variable.factor](recording)[:, : patterns.shape[1]].T
    return {_ACTS[variable.acts][0]: patterns.swapaxes(1, 2)}


def _change(variable: Variable, recording: RecordingLinearisation, forces: Mapping[str, Array]) -> Array:
    """What forces or torques (k, T, places), by field of `LawForces`, do to the residuals, place by place, (C, S, k, places)."""
    s = recording.signals
    if variable.span:
        return changes_by_forces(s, _UNIT_TORQUE_OF_ARM, resistance=variable.at_joints(forces["resistance"], s.alpha))
    return changes_by_forces(s, _UNIT_TORQUE if variable.acts == "joint" else UNIT_FORCE, **forces)


@dataclass(frozen=True)
class _StageProblem(Problem):
    """Where laws are looked for beside a stage."""

    stage: FitStage
    whiten: Whitener
    noise_columns: Sequence[Array]
    """of each recording: what noise changes of the stage's columns and residual, (C, S, K + 1)"""
    least_gain: float = 0.0
    _fine: dict[Variable, NDArray[np.float32]] = field(default_factory=dict)
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
        parts = []
        for recording, rows in zip(self._recordings, self._rows, strict=True):
            parts.append(np.repeat(rows.block, len(recording.rows.residual)))
        return np.concatenate(parts)

    @cached_property
    def equation(self) -> Index:
        each = zip(self._recordings, self._rows, strict=True)
        return np.concatenate([np.tile(np.arange(len(r.rows.residual)), len(rows.place)) for r, rows in each])

    def noise(self, numbers: Array) -> Array:
        moved = np.append(numbers, 1.0)
        energy = np.einsum("cij,i,j->c", self._noise_products, moved, moved)
        return np.minimum(energy / self._noise_products[:, -1, -1], 1.0)

    def allows(self, candidate: Candidate, form: Form, constants: Constants, amounts: Array) -> bool:
        variable, place = _variable_at(candidate)
        if variable.acts != "motor":
            return True
        for recording in self._recordings:
            values, f = _values_at(variable, recording), np.abs(recording.signals.f).max(axis=0)
            of_places = amounts.reshape(len(form.amounts), -1)
            for i, j in enumerate([place] if place is not None else range(values.shape[1])):
                taken = form.columns(values[:, j], constants) @ of_places[:, i]
                if np.abs(taken).max() > MAX_FORCE_SHARE * f[j]:
                    return False
        return True

    @cached_property
    def _noise_products(self) -> Array:
        """Of each equation: products of what noise adds to the base columns and, last, to the residual, (C, P + 1, P + 1)."""
        each = zip(self._recordings, self._rows, self.noise_columns, strict=True)
        noise = np.concatenate([self._white(*of_recording) for of_recording in each])
        noise = np.column_stack([noise[:, self.columns_of_stage], noise[:, -1]])
        return np.array(
            [noise[own].T @ noise[own] for own in self.equation == np.arange(self.equation.max() + 1)[:, None]]
        )

    @cached_property
    def _rows(self) -> tuple[_Rows, ...]:
        """Of each recording those that are looked at: of long ones MAX_BLOCKS blocks in all, evenly spread."""
        of_rows, first = [], 0
        for recording in self._recordings:
            s = recording.signals
            length = max(1, round(FOLD_BLOCK_S / (s.step * s.low_pass.factor)))
            of_rows.append(first + np.arange(recording.rows.residual.shape[1]) // length)
            first = int(of_rows[-1][-1]) + 1
        kept = np.unique(np.linspace(0, first - 1, min(first, MAX_BLOCKS)).round().astype(int))
        out = []
        for block in of_rows:
            place = np.flatnonzero(np.isin(block, kept))
            out.append(_Rows(place, np.searchsorted(kept, block[place])))
        return tuple(out)

    @cached_property
    def candidates(self) -> tuple[Candidate, ...]:
        out = []
        for variable in VARIABLES:
            if variable.joints > self._recordings[0].signals.arm.N:
                continue
            values = [_values_at(variable, r) for r in self._recordings]
            place = _place(variable)
            count = values[0].shape[1]
            for where in [0] if variable.span else [None, *range(count)]:
                seen = [v if where is None else v[:, where] for v in values]
                basis = self._basis(variable)
                if where is not None:  # forms are tried where this place went, in the columns of all
                    reach = (float(min(v.min() for v in seen)), float(max(v.max() for v in seen)))
                    if stands_still(*reach):  # a force that never changes, of one motor: what it does is a constant
                        continue
                    basis = replace(basis, reach=reach)
                out.append(
                    Candidate(
                        where=variable.place or ("all" if where is None else f"{place} {where + 1}"),
                        follows=variable.follows,
                        unit=variable.unit,
                        kind=variable.kind,
                        basis=basis,
                        target_unit=variable.unit_of_law,
                        places=count if where is None else 1,
                        factor=variable.factor,
                        detail=_detail(variable),
                    )
                )
        return tuple(out)

    def columns(self, candidate: Candidate, function: Function) -> Array:
        variable, place = _variable_at(candidate)
        if function == candidate.basis.columns:
            if variable not in self._fine:
                self._fine[variable] = self._columns_of_places(variable, function).astype(np.float32)
            every = self._fine[variable]
        else:
            every = self._columns_of_places(variable, function)
        chosen = every.reshape(len(every), -1) if place is None else every[..., place]
        return chosen.astype(float, copy=False)

    def _columns_of_places(self, variable: Variable, function: Function) -> Array:
        """Of a function at every place, whitened, (rows, k, places)."""
        parts = []
        for recording, rows in zip(self._recordings, self._rows, strict=True):
            columns = _change(variable, recording, _forces(variable, recording, function))
            parts.append(self._white(recording, rows, columns))
        return np.concatenate(parts)

    def _basis(self, variable: Variable) -> FineBasis:
        """Common to all places."""
        return FineBasis.of([_values_at(variable, r).ravel() for r in self._recordings], variable.kind == "turn")

    @cached_property
    def _matrix(self) -> Array:
        each = zip(self._recordings, self._rows, self.stage.comparison.matrices, strict=True)
        return np.concatenate([self._white(*of_recording) for of_recording in each])

    @property
    def _recordings(self) -> tuple[RecordingLinearisation, ...]:
        return self.stage.comparison.linearisation.recordings

    def _white(self, recording: RecordingLinearisation, rows: _Rows, columns: Array) -> Array:
        """Columns (C, S, ...) whitened, of the rows that are looked at, time by time, (rows C, ...)."""
        white = self.whiten(columns, segment_starts(recording.signals), recording.input_variance)
        return np.moveaxis(white, 0, 1)[rows.place].reshape(-1, *columns.shape[2:])


def found_laws(
    stage: FitStage, whiten: Whitener, noise_columns: Sequence[Array], seed: int = 0
) -> Iterator[tuple[FoundLaw, ...]]:
    """The laws in what a stage leaves, so far, after each that is found; none where chance would do as much."""
    # what shows slowly, in one equation, is a small share of all that noise makes, though it stands far above noise there
    least = min(MIN_LOSS_SHARE * stage.noise_loss, MIN_EXPLAINED * max(stage.surplus, 0.0))
    return growing_laws(_StageProblem(stage, whiten, noise_columns, least), seed)
