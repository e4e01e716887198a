"""Laws in a residual that is given as an array, beside variables that it may follow: no arm is needed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.signal import lfilter

from discovery.fine_basis import FineBasis, Function
from discovery.form import SMOOTH_PIECES, Kind
from discovery.found_law import FoundLaw
from discovery.problem import Candidate, Problem
from discovery.search import MIN_BLOCKS, find_laws
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import indexed
from xneck_foundation.unit_text import product_unit

Array = NDArray[np.float64]
Index = NDArray[np.intp]

TURNS = ("motor_angle", "drum_angle")
"""variables, rad, of which what comes round with a turn is looked for"""
DIRECTION = "motor_speed"
"""the variable whose sign turns a law over, where it is given"""
BLOCKS = 40
"""of a recording, unless they are given (docs/thresholds.md)"""
MAX_UNEXPLAINED = 1.2
"""times noise: what laws may leave and still be all (docs/thresholds.md)"""
_ORDER = 8
"""of the autoregression by which noise is whitened"""
_RESTS = (0.005, 0.02, 0.05, 0.12)
"""of the largest speeds: within which the direction's sign may change"""
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


@dataclass(frozen=True)
class Discovery:
    """What a residual follows."""

    laws: tuple[FoundLaw, ...]
    before: float
    """RMS of the residual about its mean"""
    after: float
    """RMS of what the laws leave"""
    noise: float | None
    """RMS of what nothing could explain; None where it was not given: then nobody knows whether what is left is noise"""
    left: Array = field(repr=False)
    """what the laws leave, (T,)"""
    busiest: tuple[float, float] = (0.0, 0.0)
    """begin and end, s, of the block in which most is left"""
    rest: float = 0.0
    """speed within which the direction's sign changes, in the unit of DIRECTION"""

    def values(self, variables: Mapping[str, ArrayLike], time: ArrayLike) -> Array:
        """What the laws make of variables (T,) at times (T,), s, of this recording or another, (T,)."""
        every = {name: np.asarray(v, dtype=float) for name, v in variables.items()}
        every["time"] = np.asarray(time, dtype=float)
        out = np.zeros(len(every["time"]))
        for law in self.laws:
            out += _columns_of(law.candidate, law.function, every, self.rest) @ law.amounts
        return out

    @property
    def something_remains(self) -> bool:
        """Whether plainly more than noise is left, which no function of these variables explains."""
        return self.noise is not None and self.after > MAX_UNEXPLAINED * self.noise

    @property
    def words(self) -> str:
        """For a person."""
        lines = [f"{law.words}: {law.equation}" for law in self.laws]
        for law, at in zip(self.laws, range(len(lines)), strict=True):
            numbers = ", ".join(f"{indexed(p.name, p.index)} = {p.value:.4g} +- {p.sigma:.2g}" for p in law.parameters)
            lines[at] += f"\n  {numbers}"
            if law.alike:
                lines[at] += f"\n  explains it as well: {'; '.join(other.words for other in law.alike[:3])}"
        level = "not given: what is left may be more than noise" if self.noise is None else f"{self.noise:.4g}"
        lines.append(f"residual {self.before:.4g} -> {self.after:.4g}, noise {level}")
        if self.something_remains:
            first, last = self.busiest
            lines.append(
                "something is left that no function of these variables explains, "
                f"most of it from {first:.1f} to {last:.1f} s"
            )
        if not self.laws:
            lines.append("no law was found")
        return "\n".join(lines)

    def as_json(self) -> dict[str, Any]:
        """The same as a record."""
        return {
            "found_laws": [law.as_json() for law in self.laws],
            "before": self.before,
            "after": self.after,
            "noise": self.noise,
            "something_remains": self.something_remains,
            "busiest_s": list(self.busiest),
        }


def discover(
    target: ArrayLike,
    variables: Mapping[str, ArrayLike],
    time: ArrayLike,
    blocks: ArrayLike | None = None,
    *,
    noise: float | None = None,
    turns: Sequence[str] = TURNS,
    seed: int = 0,
) -> Discovery:
    """The laws that a residual follows among functions of the variables, of their products, and of time.

    target: (T,), any unit. variables: (T,) each, by name; SI units where names are those of `UNITS`. time: (T,), s, increasing.
    blocks: (T,), a number for each row, by which rows are judged together, else BLOCKS pieces of the time; blocks of several
    recordings must not share a number. noise: RMS of the target's noise, by which what is left is judged. turns: names of
    angles, rad, that are folded into a turn. `motor_speed`, where it is among the variables, turns functions of the others over.

    Raises Refused where shapes differ, numbers are not finite, or fewer than MIN_BLOCKS blocks are left.

    >>> import numpy as np, xneck
    >>> rng = np.random.default_rng(0)
    >>> time = np.arange(0.0, 60.0, 0.02)
    >>> angle = 9 * np.sin(0.9 * time) + 5 * np.sin(2.3 * time)
    >>> residual = 0.5 * np.sin(7 * angle) + rng.normal(0, 0.3, len(time))
    >>> found = xneck.discover(residual, {"motor_angle": angle}, time)
    >>> [(law.form.name, law.candidate.follows, law.constants) for law in found.laws]
    [('harmonic', ('motor_angle',), {'count': 7.0})]
    """
    y, t = np.asarray(target, dtype=float), np.asarray(time, dtype=float)
    values = {name: np.asarray(v, dtype=float) for name, v in variables.items()}
    _check(y, t, values)
    block = _blocks(t, blocks)
    largest = float(np.quantile(np.abs(values[DIRECTION]), 0.95)) if DIRECTION in values else 1.0
    rests = [share * (largest or 1.0) for share in _RESTS]
    problems = [_Arrays(y, values | {"time": t}, block, tuple(turns), rest) for rest in rests]
    # how fast the direction's sign changes is told by what any functions leave
    least = [problem.left_by_any_function() for problem in (problems if DIRECTION in values else problems[:1])]
    best = int(np.argmin([np.sum(each**2) for each in least]))
    problem, left = problems[best], least[best]
    laws: tuple[FoundLaw, ...] = ()
    for _ in range(2):  # noise is told apart from laws once these are known
        whitened = problem.whitened_by(left)
        laws = find_laws(whitened, seed)
        left = problem.left(laws)
    energy = np.bincount(block, left**2) / np.maximum(np.bincount(block), 1)
    busiest = block == int(np.argmax(energy))
    return Discovery(
        laws=laws,
        before=float(np.std(y)),
        after=float(np.sqrt(np.mean(left**2))),
        noise=noise,
        left=left,
        busiest=(float(t[busiest].min()), float(t[busiest].max())),
        rest=problem.rest,
    )


def _check(y: Array, t: Array, values: Mapping[str, Array]) -> None:
    for name, array in {"target": y, "time": t, **values}.items():
        if array.shape != y.shape or array.ndim != 1:
            raise Refused("discover", f"{name} has shape {array.shape}", f"give as many rows as target's {y.shape}")
        if not np.isfinite(array).all():
            raise Refused("discover", f"{name} has numbers that are not finite", "leave these rows out, of all arrays")
    if "time" in values and not np.array_equal(values["time"], t):
        raise Refused("discover", "`time` is among the variables and is another one", "leave it out: it is always one")


def _blocks(t: Array, given: ArrayLike | None) -> Index:
    if given is None:
        if len(t) < 5 * MIN_BLOCKS:
            raise Refused("discover", f"{len(t)} rows", f"at least {5 * MIN_BLOCKS} are needed to judge a law")
        return (np.arange(len(t)) * BLOCKS // len(t)).astype(np.intp)
    numbers = np.asarray(given)
    if numbers.shape != t.shape:
        raise Refused("discover", f"blocks have shape {numbers.shape}", f"give a number for each of {len(t)} rows")
    block = np.unique(numbers, return_inverse=True)[1].astype(np.intp)
    if block.max() + 1 < MIN_BLOCKS:
        raise Refused("discover", f"{block.max() + 1} blocks", f"at least {MIN_BLOCKS} are needed to judge a law")
    return block


def _columns_of(candidate: Candidate, function: Function, values: Mapping[str, Array], rest: float) -> Array:
    """A function's columns, (T, k); rest: as `Discovery` has it."""
    if candidate.factor:
        (name,) = (n for n in candidate.follows if n != DIRECTION)
        return function(values[name]) * np.tanh(values[DIRECTION] / rest)[:, None]
    product = values[candidate.follows[0]]
    for name in candidate.follows[1:]:
        product = product * values[name]
    return function(product)


@dataclass(frozen=True)
class _Arrays(Problem):
    """The problem of `discover`; its rows are those given, whitened by an autoregression within blocks."""

    y: Array
    values: Mapping[str, Array]
    block: Index
    """of each row"""
    turns: tuple[str, ...]
    rest: float
    """speed within which the direction's sign changes"""
    filter: Array = field(default_factory=lambda: np.ones(1))
    scale: float = 1.0

    def whitened_by(self, left: Array) -> "_Arrays":
        """With the filter that whitens `left`, (T,)."""
        order = _ORDER
        starts = np.flatnonzero(np.diff(self.block, prepend=-1))
        lagged = np.stack([np.roll(left, k) for k in range(1, order + 1)], axis=1)
        inside = np.ones(len(left), dtype=bool)
        for k in range(order):
            inside[np.minimum(starts + k, len(left) - 1)] = False
        if inside.sum() < 20 * order:
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
            kind: Kind = "turn" if name in self.turns else "time" if name == "time" else "line"
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
        return _columns_of(candidate, function, self.values, self.rest)

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
