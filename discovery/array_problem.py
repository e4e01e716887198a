"""The problem of laws in a residual that is given as an array: its candidates, and its noise, whitened within blocks."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from discovery.fine_basis import FineBasis, Function
from discovery.form import SMOOTH_PIECES, Kind
from discovery.found_law import FoundLaw
from discovery.problem import Candidate, Problem
from xneck_foundation.unit_text import product_unit

Array = NDArray[np.float64]
Index = NDArray[np.intp]

DIRECTION = "motor_speed"
"""the variable whose sign turns a law over, where it is given"""
_ORDER = 8
"""of the autoregression by which noise is whitened"""
UNITS = {
    "motor_angle": "rad",
    "drum_angle": "rad",
    "joint_angle": "rad",
    "motor_speed": "rad/s",
    "joint_speed": "rad/s",
    "force": "N",
    "tension": "N",
    "time": "s",
}
"""of variables whose names are known; others have `1`"""


def columns_of(candidate: Candidate, function: Function, values: Mapping[str, Array], direction_width: float) -> Array:
    """Columns (T, k) of a function of a candidate's variable; values: (T,) by name; direction_width: as `Discovery` has it."""
    if candidate.factor:
        (name,) = (n for n in candidate.follows if n != DIRECTION)
        return function(values[name]) * np.tanh(values[DIRECTION] / direction_width)[:, None]
    product = values[candidate.follows[0]]
    for name in candidate.follows[1:]:
        product = product * values[name]
    return function(product)


@dataclass(frozen=True)
class ArrayProblem(Problem):
    """The problem of `discover`; its rows are those given, whitened by an autoregression within blocks."""

    y: Array
    values: Mapping[str, Array]
    block: Index
    """of each row"""
    turns: tuple[str, ...]
    direction_width: float
    """speed within which the direction's sign changes"""
    filter: Array = field(default_factory=lambda: np.ones(1))
    scale: float = 1.0

    def whitened_by(self, left: Array) -> "ArrayProblem":
        """This problem with the filter that whitens residuals `left`, (T,)."""
        starts = np.flatnonzero(np.diff(self.block, prepend=-1))
        lagged = np.stack([np.roll(left, k) for k in range(1, _ORDER + 1)], axis=1)
        inside = np.ones(len(left), dtype=bool)
        for k in range(_ORDER):
            inside[np.minimum(starts + k, len(left) - 1)] = False
        if inside.sum() < 20 * _ORDER:
            return self
        a = np.linalg.lstsq(lagged[inside], left[inside], rcond=1e-9)[0]
        innovation = left[inside] - lagged[inside] @ a
        scale = float(np.std(innovation)) or 1.0
        return replace(self, filter=np.append(1.0, -a), scale=scale)

    @cached_property
    def blocks(self) -> Index:
        return self.block

    @cached_property
    def target(self) -> Array:
        return self._white(self.y[:, None])[:, 0]

    @cached_property
    def base(self) -> Array:
        return self._white(np.ones((len(self.y), 1)))

    @cached_property
    def precision(self) -> Array:
        return np.zeros(1)

    @cached_property
    def candidates(self) -> tuple[Candidate, ...]:
        """Every variable, along the motion too, and products of two."""
        out = []
        along = f"sign({DIRECTION})" if DIRECTION in self.values else ""
        for name, values in self.values.items():
            usual: Kind = "time" if name == "time" else "arc" if name == "joint_angle" else "line"
            kind: Kind = "turn" if name in self.turns else usual
            basis, unit = FineBasis.of([values], kind == "turn"), UNITS.get(name, "1")
            out.append(Candidate("", (name,), unit, kind, basis))
            if along and name != DIRECTION:
                out.append(Candidate("", (name, DIRECTION), unit, kind, basis, factor=along))
        lines = [name for name in self.values if name not in self.turns and name != "time"]
        for i, a in enumerate(lines):
            for b in lines[i + 1 :]:
                basis = FineBasis.of([self.values[a] * self.values[b]], False)
                unit = product_unit(UNITS.get(a, "1"), UNITS.get(b, "1"))
                out.append(Candidate("", (a, b), unit, "line", basis))
        return tuple(out)

    def columns(self, candidate: Candidate, function: Function) -> Array:
        return self._white(self.plain_columns(candidate, function))

    def plain_columns(self, candidate: Candidate, function: Function) -> Array:
        """Not whitened, (T, k)."""
        return columns_of(candidate, function, self.values, self.direction_width)

    def left_by_any_function(self) -> Array:
        """What smooth functions of all candidates at once leave of the target, (T,): noise, where laws are among them."""
        columns = [np.ones((len(self.y), 1))]
        for c in self.candidates:
            basis = c.basis if c.kind == "turn" else FineBasis(np.linspace(c.basis.low, c.basis.high, SMOOTH_PIECES))
            columns.append(self.plain_columns(c, basis.columns))
        matrix = np.concatenate(columns, axis=1)
        G = matrix.T @ matrix
        ridge = 1e-6 * np.trace(G) / len(G)
        return self.y - matrix @ np.linalg.solve(G + ridge * np.eye(len(G)), matrix.T @ self.y)

    def left(self, laws: Sequence[FoundLaw]) -> Array:
        """What laws leave of the target about a constant, (T,)."""
        out = self.y.copy()
        for law in laws:
            out -= self.plain_columns(law.candidate, law.function) @ law.amounts
        return out - out.mean()

    def _white(self, columns: Array) -> Array:
        if len(self.filter) == 1:
            return columns / self.scale
        out = np.empty_like(columns)
        starts = np.flatnonzero(np.diff(self.block, prepend=-1))
        for begin, end in zip(starts, [*starts[1:], len(columns)], strict=True):
            out[begin:end] = lfilter(self.filter, [1.0], columns[begin:end], axis=0)
            out[begin : begin + len(self.filter) - 1] = 0.0
        return out / self.scale
