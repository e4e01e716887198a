"""Laws in a residual that is given as an array, beside variables that it may follow: no arm is needed."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from discovery.array_problem import DIRECTION, ArrayProblem
from discovery.discovery import Discovery
from discovery.found_law import FoundLaw
from discovery.search import MIN_BLOCKS, find_laws
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]
Index = NDArray[np.intp]

TURNS = ("motor_angle", "drum_angle")
"""variables, rad, of which what comes round with a turn is looked for"""
BLOCKS = 40
"""of a recording, unless they are given (docs/thresholds.md)"""
_DIRECTION_WIDTHS = (0.005, 0.02, 0.05, 0.12)
"""of the largest speeds: within which the direction's sign may change"""


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

    Raises Refused where shapes differ, numbers are not finite, time goes back, or fewer than MIN_BLOCKS blocks are left.

    >>> import numpy as np, xneck
    >>> rng = np.random.default_rng(0)
    >>> time = np.arange(0.0, 60.0, 0.02)
    >>> angle = 9 * np.sin(0.9 * time) + 5 * np.sin(2.3 * time)
    >>> residual = 0.5 * np.sin(7 * angle) + rng.normal(0, 0.3, len(time))
    >>> found = xneck.discover(residual, {"motor_angle": angle}, time)
    >>> [(law.form.name, law.candidate.follows, law.constants) for law in found.laws]
    [('harmonic', ('motor_angle',), {'count': 7.0})]
    """
    if not isinstance(variables, Mapping):
        raise Refused("discover", f"variables are a {type(variables).__name__}", 'name them: {"motor_angle": angle}')
    y, t = _numbers("target", target), _numbers("time", time)
    values = {name: _numbers(name, v) for name, v in variables.items()}
    _check(y, t, values)
    block = _blocks(t, blocks)
    back = np.flatnonzero((np.diff(t) < 0) & (np.diff(block) == 0))
    if len(back):
        raise Refused(
            "discover", f"time goes back after row {back[0]}", "sort the rows, or give recordings blocks of their own"
        )
    largest = float(np.quantile(np.abs(values[DIRECTION]), 0.95)) if DIRECTION in values else 1.0
    widths = [share * (largest or 1.0) for share in _DIRECTION_WIDTHS]
    problems = [ArrayProblem(y, values | {"time": t}, block, tuple(turns), width) for width in widths]
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
        residual_after=left,
        busiest=(float(t[busiest].min()), float(t[busiest].max())),
        busiest_rms=float(np.sqrt(energy.max())),
        direction_width=problem.direction_width,
    )


def _numbers(name: str, array: ArrayLike) -> Array:
    try:
        return np.asarray(array, dtype=float)
    except (TypeError, ValueError):
        raise Refused("discover", f"{name} is no array of numbers", "give one number for each row") from None


def _check(y: Array, t: Array, values: Mapping[str, Array]) -> None:
    if y.ndim != 1:
        raise Refused("discover", f"target has shape {y.shape}", "give one number for each row: one residual at a time")
    for name, array in {"target": y, "time": t, **values}.items():
        if array.shape != y.shape:
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
