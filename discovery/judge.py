"""What laws leave beyond the noise that the model with them makes, by which rivals are compared."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discovery.evidence import Evidence
from discovery.problem import Problem

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Losses:
    """Of one function beside the base columns, in units of the noise that the model with it makes."""

    whole: float
    """where all blocks were fitted, what is known beforehand included"""
    of_blocks: Array
    """(B,), of every block where all folds but its own were fitted"""
    amounts: Array
    """of the function, where all blocks were fitted, (k,)"""


@dataclass(frozen=True)
class Judge:
    """Losses equation by equation, each over the noise in it: a law that halves all forces halves what is wrong and noise alike."""

    problem: Problem
    base: Array
    """columns that are fitted beside any law, those of laws found so far behind the problem's, (rows, P)"""

    def losses(self, evidence: Evidence, fine: Array, function: Array) -> Losses:
        """Of a function (K, k) of fine columns (rows, K); evidence: of the base columns, these and the target."""
        numbers = np.stack([evidence.fit(function), *evidence.fits_without_folds(function)], axis=1)
        p, problem = evidence.fitted, self.problem
        left = problem.target[:, None] - self.base @ numbers[:p] - fine @ (function @ numbers[p:])
        noise = np.stack([problem.noise(of[: problem.base.shape[1]]) for of in numbers.T], axis=1)
        energy = left**2 / (noise[problem.equation] if len(noise) > 1 else noise)
        known = float(np.sum(evidence.precision * numbers[:p, 0] ** 2))
        own = energy[np.arange(len(left)), 1 + evidence.folds[problem.blocks]]
        return Losses(float(energy[:, 0].sum()) + known, np.bincount(problem.blocks, own).astype(float), numbers[p:, 0])
