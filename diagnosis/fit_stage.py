"""Recordings as they are fitted with causes, what is left of them, and which of the causes they tell."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause import Cause, with_causes
from diagnosis.comparison import ColumnFit, Comparison
from diagnosis.held_at_rest import HeldShares, held_share
from diagnosis.hypothesis import Hypothesis
from diagnosis.judged_rows import judged
from diagnosis.noise_excess import NoiseExcess, noise_excess

Array = NDArray[np.float64]

MAX_MISSED = 0.1
"""of the loss that noise makes: what a straight step may promise at the end of a fit (docs/thresholds.md)"""
FAR = 4.0
"""losses of noise from which a fit is far"""
IMPOSSIBLE_SIGMAS = 3.0
"""standard deviations below its least value from which an amount is impossible (docs/thresholds.md)"""
_AT_END = 1e-6
"""of a person's change: nearer to the least that a step can take, an amount is there"""
UNTOLD_SIGMAS = 2.0
"""standard deviations within which all amounts of a cause are nothing (docs/thresholds.md)"""
MAX_OPPOSED_SHARE = 0.2
"""of what a cause does in the equations: what amounts below their least value may do (docs/thresholds.md)"""


@dataclass(frozen=True)
class FitStage:
    """Recordings with the causes named so far."""

    before_causes: Hypothesis
    """to which the causes are added"""
    comparison: Comparison
    """at the end of the fit"""
    causes: tuple[Cause, ...]
    """with numbers"""
    noise: tuple[list[Array], ...]
    """residuals of noise alone, (C, S), by recording and draw"""
    noise_loss: float
    """loss that noise alone makes"""
    fit: ColumnFit

    @cached_property
    def hypothesis(self) -> Hypothesis:
        """With the causes in it."""
        return with_causes(self.before_causes, self.causes)

    def adjusted(self, h: Hypothesis) -> Hypothesis:
        """A hypothesis with what is known to a tolerance moved to where the recordings say it is."""
        c = self.comparison
        return c.nuisances.adjusted(h, self.fit.numbers[c.base_count : c.base_count + c.nuisances.count])

    @cached_property
    def _covariance(self) -> Array:
        """Of all numbers of the fit, in their sizes, (K, K)."""
        return self.comparison.covariance(self.fit)

    @cached_property
    def sigma(self) -> Array:
        """Of all numbers of the fit, in their sizes, (K,); infinite where nothing tells them."""
        variance = np.diag(self._covariance)
        return np.sqrt(np.where(variance > 0, variance, np.inf))

    @cached_property
    def sigma_of_causes(self) -> tuple[Array, ...]:
        """Of each cause's amounts, then its shape terms, in their units; infinite at the end of a shape's range."""
        c = self.comparison
        arm, sigma = c.linearisation.hypothesis.arm, self.sigma[c.base_count + c.nuisance_count :]
        out = []
        for cause in self.causes:
            sizes = cause.sizes(arm)
            of_amounts, of_shape = np.split(sizes * sigma[: len(sizes)], [len(cause.amounts)])
            out.append(np.append(of_amounts, np.where(cause.at_limit(arm), np.inf, of_shape)))
            sigma = sigma[len(sizes) :]
        return tuple(out)

    @cached_property
    def sigma_as_shaped(self) -> tuple[Array, ...]:
        """Of each cause's amounts in its shape as it is, in their units: how sure it is that there is any of it.

        With a power near one a cable that hardens is a stiff one, and beside that no amount is told: but the power is told too."""
        covariance, arm = self._covariance, self.comparison.linearisation.hypothesis.arm
        out = []
        for cause, columns in zip(self.causes, self.columns_of_causes, strict=True):
            amounts, shape = np.split(np.searchsorted(self.fit.columns, columns), [len(cause.amounts)])
            both, of_shape = covariance[np.ix_(amounts, shape)], covariance[np.ix_(shape, shape)]
            by_shape = np.einsum("is,si->i", both, np.linalg.pinv(of_shape) @ both.T) if len(shape) else 0.0
            variance = np.diag(covariance)[amounts] - by_shape
            sizes = cause.sizes(arm)[: len(amounts)]
            out.append(sizes * np.sqrt(np.where(variance > 0, variance, np.inf)))
        return tuple(out)

    @cached_property
    def widening(self) -> float:
        """Times by which what is left above noise widens each sigma, as it is told."""
        return float(self.excess.ratio.max()) if self.excess.above_noise else 1.0

    @property
    def possible(self) -> bool:
        """Whether no cause does surely less than nothing, or more than any such thing does."""
        return not self.impossible

    @cached_property
    def impossible(self) -> tuple[int, ...]:
        """Which causes do surely less than nothing, as friction that drives or a mass that lifts, or more than any such thing does,
        or act nowhere where the arm comes.

        A small part of a cause may do less: it mends the form of the law, which nobody knows better. What ends where its range does
        stands in for something else.
        """
        out = []
        c = self.comparison
        arm, norm = c.linearisation.hypothesis.arm, np.sqrt(np.diag(c.products))
        told = zip(self.causes, self.columns_of_causes, self.sigma_of_causes, strict=True)
        for i, (cause, columns, sigma) in enumerate(told):
            bounds, count = cause.effect.lower_bounds(arm)[list(cause.where.columns)], len(cause.amounts)
            does = cause.amounts / cause.sizes(arm)[:count] * norm[columns[:count]]
            # a step goes no further down than to the end of the range, whatever it would take to the loss
            at_end = cause.least_steps(arm) > -_AT_END
            beyond = at_end & (cause.amounts < bounds) | (cause.amounts < bounds - IMPOSSIBLE_SIGMAS * sigma[:count])
            is_opposed = np.any(beyond & (np.abs(does) > MAX_OPPOSED_SHARE * np.linalg.norm(does)))
            is_reached = any(cause.effect.is_reached(r, cause.where) for r in c.linearisation.recordings)
            if (
                is_opposed
                or not is_reached
                or np.any(cause.amounts >= cause.effect.upper_bounds(arm)[list(cause.where.columns)])
            ):
                out.append(i)
        return tuple(out)

    @cached_property
    def untold(self) -> tuple[int, ...]:
        """Which causes the recordings do not tell from nothing: no amount stands clear of its sigma, on the side it may be on."""
        return self.untold_within(UNTOLD_SIGMAS)

    @cached_property
    def untold_beside_what_is_left(self) -> tuple[int, ...]:
        """The same with sigmas as they are told."""
        return self.untold_within(UNTOLD_SIGMAS * self.widening)

    def untold_within(self, sigmas: float) -> tuple[int, ...]:
        """As `untold`, where nothing is what is within so many standard deviations of it."""
        arm, out = self.comparison.linearisation.hypothesis.arm, []
        for i, (cause, sigma) in enumerate(zip(self.causes, self.sigma_as_shaped, strict=True)):
            from_nothing = cause.effect.lower_bounds(arm)[list(cause.where.columns)] == 0
            does = np.where(from_nothing, cause.amounts, np.abs(cause.amounts))
            if np.all(does < sigmas * sigma):
                out.append(i)
        return tuple(out)

    @cached_property
    def columns_of_causes(self) -> tuple[NDArray[np.intp], ...]:
        """Of each cause in the comparison: its amounts, then its shape terms."""
        arm = self.comparison.linearisation.hypothesis.arm
        counts = [len(cause.sizes(arm)) for cause in self.causes]
        return tuple(np.split(self.comparison.cause_columns, np.cumsum(counts)[:-1])) if counts else ()

    @cached_property
    def loss(self) -> float:
        """Of blocks where all but their fold were fitted, of nuisances beyond tolerance, and what a last step would have taken."""
        return float(self.comparison.block_losses().sum()) + self.comparison.prior_loss() + max(0.0, self._missed)

    @property
    def _missed(self) -> float:
        """What a last step would take from the loss, by straight lines."""
        return self.comparison.profiled_loss - self.fit.loss

    @property
    def is_astray(self) -> bool:
        """Whether a straight step promises far more than the fit has found: it ended, but nowhere near a least loss."""
        return self._missed > MAX_MISSED * self.noise_loss

    @property
    def surplus(self) -> float:
        """Loss beyond what noise alone makes, which differs from stage to stage: a heavier arm makes more of the angles' noise.

        Of all blocks as they were fitted: what a single one of them tells may be anything where that is left out. Noise far beyond
        the weights' is no excuse: laws that are wrong may make much of the rounding of counts."""
        return self.comparison.profiled_loss - min(self.noise_loss, FAR * self.comparison.row_count)

    @cached_property
    def held(self) -> HeldShares:
        """What is seen of dry friction that holds joints at rest, and motors if they are known to stick."""
        known, seen = self.comparison.linearisation.hypothesis.held, self.held_if_motors_stick
        return seen if known.motors else HeldShares(joints=seen.joints)

    @cached_property
    def held_if_motors_stick(self) -> HeldShares:
        """The same where nothing is known of that yet."""
        at = self.comparison.linearisation
        motors, recordings = at.hypothesis.arm.M, at.recordings
        excess = [
            residual**2 - np.mean(np.square(draws), axis=0)
            for residual, draws in zip(self.comparison.residuals_after(self.fit), self.noise, strict=True)
        ]
        of_motors = held_share([e[:motors] for e in excess], [r.held.motor_squares(r.signals) for r in recordings])
        of_joints = held_share([e[motors:] for e in excess], [r.held.joint_squares(r.signals) for r in recordings])
        known = at.hypothesis.held
        return HeldShares(
            motors=float(np.clip(known.motors + of_motors, 0.0, 1.0)),
            joints=float(np.clip(known.joints + of_joints, 0.0, 1.0)),
        )

    @cached_property
    def excess(self) -> NoiseExcess:
        """What stands above noise."""
        variance = [recording.input_variance for recording in self.comparison.linearisation.recordings]
        return noise_excess(self.judged_residuals, self.judged_noise, variance)

    @cached_property
    def judged_residuals(self) -> list[Array]:
        """What is left of each recording, (C, S), as it is judged."""
        residuals = self.comparison.residuals_after(self.fit)
        return [
            judged(r, at.signals) for r, at in zip(residuals, self.comparison.linearisation.recordings, strict=True)
        ]

    @cached_property
    def judged_noise(self) -> list[list[Array]]:
        """Draws of noise alone of each recording, (C, S), as they are judged."""
        recordings = self.comparison.linearisation.recordings
        return [[judged(d, at.signals) for d in draws] for draws, at in zip(self.noise, recordings, strict=True)]
