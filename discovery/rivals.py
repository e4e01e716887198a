"""Forms of candidates that rival for one law: their inner constants, and which of them is taken."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import cast

import numpy as np
from numpy.typing import NDArray

from discovery.evidence import Evidence
from discovery.form import SMOOTH, Constants, Form
from discovery.found_law import FoundLaw
from discovery.problem import Candidate

Array = NDArray[np.float64]

MIN_GAIN_SIGMAS = 2.5
"""of the gain over blocks that were not fitted (docs/thresholds.md)"""
ALIKE_SIGMAS, ALIKE_SHARE = 2.0, 0.1
"""of the gain's difference, and of what is left: another law that leaves no more explains as well (docs/thresholds.md)"""
SIMPLER_SIGMAS, SIMPLER_SHARE = 1.0, 0.02
"""the same, by which a simpler law may leave more and is taken for a better one (docs/thresholds.md)"""
_MOST_OF_A_BLOCK = 3.0
"""middle gains that a block counts for at most, where more than half of the blocks gain (docs/thresholds.md)"""
CHANCE_OF_TWO = 4.0
"""of the loss: what two numbers more take by chance"""
_GRID_SHARES = (0.04, 0.04, 0.02, 0.02, 0.01, 0.005)
"""of a variable's range, and an eighth of the relative change of other constants: steps about the best of a grid"""


@dataclass(frozen=True)
class Rival:
    """A form of a candidate, and what it takes from the loss."""

    candidate: Candidate
    form: Form
    constants: Constants
    gain: float
    """where fitted"""
    block_gains: Array
    """(B,), over blocks that were not fitted"""
    of_constant: float = 0.0
    """of the gain: what a constant takes in the place of a function of the variable, where that is not all of the law"""

    @property
    def held_out_gain(self) -> float:
        return float(self.block_gains.sum())

    @property
    def complexity(self) -> tuple[int, int]:
        """Simpler ones first."""
        extra = len(self.candidate.follows) - 1
        numbers = len(self.form.amounts) * self.candidate.places + len(self.constants) - len(self.form.fixed)
        return self.form.rank + extra, numbers


def refined(
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
        gains = evidence.gains(all_coefficients(candidate, form, tried))
        if gains.max() > gain:
            constants, gain = tried[int(np.argmax(gains))], float(gains.max())
    return constants, gain


def coefficients(candidate: Candidate, form: Form, constants: Constants) -> Array:
    """A form with its constants as sums of the candidate's fine columns, (K places, k places)."""
    return all_coefficients(candidate, form, [constants])[0]


def all_coefficients(candidate: Candidate, form: Form, every: Sequence[Constants]) -> Array:
    """`coefficients` of a form with each of n sets of constants, (n, K places, k places)."""
    constants = {name: np.array([[c[name]] for c in every]) for name in every[0]}
    of_one = candidate.basis.coefficients(lambda x: form.columns(x, cast(Constants, constants)))
    return candidate.expanded(np.broadcast_to(of_one, (len(every), *of_one.shape[-2:])))


def chosen(rivals: Sequence[Rival], chance: float, loss: float) -> FoundLaw | None:
    """The simplest of the rivals that explain as well as the best; none where chance would.

    chance: the gain that chance makes. loss: without any of them. A law of which a constant would
    take as much, but for a small share of what is left, does not follow its variable.
    """
    told = [r for r in rivals if r.gain > chance and gain_sigmas(r.block_gains) > MIN_GAIN_SIGMAS]
    proved = [r for r in told if r.gain - r.of_constant > min(r.gain / 2, SIMPLER_SHARE * (loss - r.gain))]
    if not proved:
        return None
    best = max(proved, key=lambda r: r.held_out_gain)
    left = loss - best.gain
    near = [r for r in proved if _is_alike(best, r, SIMPLER_SIGMAS, SIMPLER_SHARE * left)]
    chosen = min(near, key=lambda r: (r.complexity, -r.held_out_gain))
    alike = [r for r in proved if r is not chosen and _is_alike(best, r, ALIKE_SIGMAS, ALIKE_SHARE * left)]
    alike = sorted((r for r in alike if r.form.name != SMOOTH), key=lambda r: -r.held_out_gain)
    others = {
        (*r.candidate.follows, r.candidate.factor, r.form.name): r for r in reversed(alike) if not _is_same(r, chosen)
    }
    return replace(
        _as_law(chosen, loss),
        alike=tuple(_as_law(r, loss) for r in sorted(others.values(), key=lambda r: -r.held_out_gain)),
    )


def _is_same(a: Rival, b: Rival) -> bool:
    """Whether they are of one variable and form, whatever their places."""
    return a.form == b.form and a.candidate.is_sibling(b.candidate)


def _is_alike(best: Rival, other: Rival, sigmas: float, most: float) -> bool:
    """Whether another one takes no less than chance may, nor than `most` of the loss."""
    less = best.block_gains - other.block_gains
    spread = float(np.std(less)) * np.sqrt(len(less))
    return float(less.sum()) <= max(min(sigmas * spread, most), CHANCE_OF_TWO)


def gain_sigmas(gains: Array) -> float:
    """The sum of blocks' gains (B,) in its standard deviations, where no block counts for much more than the middle one if that
    tells it better.

    A law of speed gains most where the arm was fastest: what it gains in all other blocks is no chance for that."""
    even = np.minimum(gains, _MOST_OF_A_BLOCK * max(float(np.median(gains)), 0.0))
    return max(_sum_in_sigmas(gains), _sum_in_sigmas(even))


def _sum_in_sigmas(gains: Array) -> float:
    return float(gains.sum() / max(np.std(gains) * np.sqrt(len(gains)), 1e-300))


def _as_law(rival: Rival, loss: float) -> FoundLaw:
    """The law that a rival says, whose amounts are still to be fitted; loss: without it."""
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
