"""All causes side by side: every number of every one is a column, and tables of their products answer for any choice of them.

loss = |whitened residual - columns x numbers|^2 + ((numbers - prior mean) / prior sigma)^2
The base model's numbers are free in every comparison, nuisances are known to their sigma.
Tables are kept by blocks of time, so that a choice can be fitted to some of them and judged on the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from diagnosis.bounded_least_squares import bounded_minimum
from diagnosis.effect import Effect, Shape
from diagnosis.linearisation import Linearisation
from diagnosis.nuisances import Nuisances

Array = NDArray[np.float64]
Index = NDArray[np.intp]

FOLD_BLOCK_S = 2.0
"""s: blocks that are dealt to folds, longer than what residuals remember (docs/thresholds.md)"""
FOLDS = 5
"""of the cross-validation (docs/thresholds.md)"""
_TELLING_SHARE = 0.1
"""of what all blocks tell of a column: a block that tells more is dealt by how much it tells (docs/thresholds.md)"""
HELD_SIGMA = 1e-6
"""in sizes, of shape terms that are at the end of their range"""
RIDGE = 1e-9
"""of columns scaled to one, for those that nothing tells apart"""


@dataclass(frozen=True)
class EffectColumns:
    """An effect in one of its shapes, and the columns it has."""

    effect: Effect
    shape: Shape
    columns: Index


@dataclass(frozen=True)
class ColumnFit:
    """Columns that were fitted together, their numbers, and the loss."""

    columns: Index
    numbers: Array
    loss: float


@dataclass(frozen=True)
class Comparison:
    """K columns: the base model's, nuisances, then the causes named so far and the effects that are asked about."""

    linearisation: Linearisation
    matrices: tuple[Array, ...]
    """of each recording, not whitened: columns and residual, (C, S, K + 1)"""
    base_count: int
    """of columns of the base model"""
    nuisance_count: int
    """the arm's and the angles', then each recording's clock and skew"""
    cause_columns: Index
    """columns of the causes named so far"""
    groups: tuple[EffectColumns, ...]
    block_products: Array
    """products of whitened columns with the residual last, by blocks of time, (B, K + 1, K + 1)"""
    noise_products: Array
    """products of whitened columns with draws of noise, (B, K, D)"""
    prior_sigma: Array
    """of what is known beforehand, (K,); inf where nothing is"""
    relaxed_sigma: Array
    """the same where the clock rests on a model that is wrong"""
    prior_mean: Array
    """what the numbers are known to be beforehand, (K,)"""
    lower_bounds: Array
    """below which numbers do not go, (K,); -inf where they may"""
    upper_bounds: Array
    """above which they do not go, (K,)"""
    nuisances: Nuisances
    clock_relaxed: bool
    """whether the causes named so far put the clock in doubt"""
    row_count: int
    """of rows that count"""

    @cached_property
    def products(self) -> Array:
        """Products of all blocks together, (K + 1, K + 1)."""
        return self.block_products.sum(axis=0)

    def fit(
        self, extra: Sequence[int] | Index = (), damping: float = 0.0, clock_relaxed: bool | None = None
    ) -> ColumnFit:
        """The base model with nuisances, causes and extra columns; damping (Marquardt's) for steps of what is not linear."""
        use, sigma = self._columns_with(extra), self.sigma(clock_relaxed)
        return ColumnFit(use, *self._solve(self.products, use, sigma, damping))

    def block_losses(
        self, extra: Sequence[int] | Index = (), clock_relaxed: bool | None = None, folds: Index | None = None
    ) -> Array:
        """Loss of every block where all folds but its own were fitted, (B,); folds: of the blocks, else those of `folds(extra)`."""
        use, sigma = self._columns_with(extra), self.sigma(clock_relaxed)
        folds = self.folds(extra) if folds is None else folds
        out = np.zeros(len(self.block_products))
        for f in range(min(FOLDS, len(out))):
            left_out = self.block_products[folds == f]
            x, _ = self._solve(self.products - left_out.sum(axis=0), use, sigma, 0.0)
            y = np.append(x, 1.0)
            at = np.append(use, len(self.prior_sigma))
            out[folds == f] = np.einsum("i,bij,j->b", y, left_out[:, at[:, None], at], y)
        return out

    def folds(self, extra: Sequence[int] | Index = ()) -> Index:
        """The fold of every block, (B,): in turn, but blocks that tell much of a cause are spread evenly."""
        columns = np.append(self.cause_columns, np.asarray(extra, dtype=int))
        fold = np.arange(len(self.block_products)) % FOLDS
        information = self.block_products[:, columns, columns]
        share = (information / np.maximum(information.sum(axis=0), 1e-300)).max(axis=1, initial=0.0)
        telling = np.flatnonzero(share > _TELLING_SHARE)
        fold[telling[np.argsort(-share[telling])]] = np.arange(len(telling)) % FOLDS
        return fold

    def with_held(self, columns: Index) -> "Comparison":
        """The comparison with numbers of these columns (k,) that stay as they are."""
        prior, relaxed, mean = self.prior_sigma.copy(), self.relaxed_sigma.copy(), self.prior_mean.copy()
        prior[columns] = relaxed[columns] = HELD_SIGMA
        mean[columns] = 0.0
        return replace(self, prior_sigma=prior, relaxed_sigma=relaxed, prior_mean=mean)

    def without_noise_in_columns(self, score: Array) -> "Comparison":
        """The comparison with the products of columns and residual less what noise that is in both makes of them, (K,)."""
        products, share = self.block_products.copy(), score / len(self.block_products)
        products[:, :-1, -1] -= share
        products[:, -1, :-1] -= share
        return replace(self, block_products=products)

    def with_causes_off(self, numbers: Array) -> "Comparison":
        """The comparison without the causes that the linearisation holds.

        numbers: their amounts and shapes, in columns' sizes.
        """
        fixed = np.zeros(len(self.prior_sigma))
        fixed[self.cause_columns] = -numbers
        return self.with_fixed(fixed)

    @cached_property
    def temper(self) -> float:
        """How many times the loss stands above what noise would leave, at least 1.

        A model that is wrong tells less: what is known beforehand counts for as many times more, so that nuisances do not go
        far beyond their tolerances to make good for it."""
        use, sigma = self._columns_with(()), self.relaxed_sigma if self.clock_relaxed else self.prior_sigma
        return max(1.0, self._solve(self.products, use, sigma, 0.0)[1] / self.row_count)

    def prior_loss(self, extra: Sequence[int] | Index = (), clock_relaxed: bool | None = None) -> float:
        """The part of a fit's loss that is of what is known beforehand: what it makes of nuisances, over their tolerances."""
        fit, sigma = self.fit(extra, clock_relaxed=clock_relaxed), self.sigma(clock_relaxed)
        beyond = (fit.numbers - self.prior_mean[fit.columns]) / sigma[fit.columns]
        return float(beyond @ beyond)

    @cached_property
    def profiled_loss(self) -> float:
        """Loss of the linearisation point as it is, with nuisances at their best."""
        return self._loss_with_best_from(self.base_count)

    @cached_property
    def loss_with_fixed_causes(self) -> float:
        """Loss with the base model's numbers at their best, and the causes' at the linearisation point's."""
        return self._loss_with_best_from(0)

    @cached_property
    def loss_with_clocks_at_best(self) -> float:
        """Loss of the linearisation point as it is, but for each recording's clock and skew."""
        return self._loss_with_best_from(self.base_count + self.nuisances.count)

    @cached_property
    def promised(self) -> float:
        """What a straight step would take from the loss."""
        return self.profiled_loss - self.fit().loss

    def _loss_with_best_from(self, first: int) -> float:
        """Loss of the linearisation point with the numbers of columns from `first` to the last nuisance at their best."""
        use = np.arange(first, self.base_count + self.nuisance_count)
        return self._solve(self.products, use, self.sigma(), 0.0)[1] + self._prior_of_rest(use)

    def _prior_of_rest(self, use: Index) -> float:
        """The part of the loss that is of what is known beforehand of numbers that are not fitted."""
        beyond = self.prior_mean / self.sigma()
        return float(np.sum(np.delete(beyond, use) ** 2))

    def plain_covariance(self, fit: ColumnFit) -> Array:
        """Covariance of a fit's numbers, if all that is left were noise alike in all blocks.

        It is nowhere wider than what is known beforehand.
        """
        return self.temper * self._inverse(fit.columns)

    def covariance(self, fit: ColumnFit) -> Array:
        """Covariance of a fit's numbers: what blocks do to them, each for itself, and what is not known of nuisances."""
        use, last = fit.columns, len(self.prior_sigma)
        precision, inverse = 1 / self.sigma()[use] ** 2, self._inverse(use)
        score = self.block_products[:, use[:, None], use] @ fit.numbers + self.block_products[:, use, last]
        count = len(self.block_products)
        spread = np.einsum("bi,bj->ij", score, score) * count / max(count - 1, 1)
        # rows that are told well by their own number count at least as noise does
        of_noise = self.products[np.ix_(use, use)]
        by_blocks, by_noise = inverse @ spread @ inverse, inverse @ of_noise @ inverse
        widened = np.sqrt(np.maximum(np.diag(by_noise) / np.maximum(np.diag(by_blocks), 1e-300), 1.0))
        return by_blocks * np.outer(widened, widened) + inverse @ np.diag(precision) @ inverse

    def _inverse(self, use: Index) -> Array:
        """Inverse of the products of columns in use (k,) with what is known beforehand, (k, k)."""
        H = self.products[np.ix_(use, use)] + np.diag(1 / self.sigma()[use] ** 2)
        H, scale = with_unit_diagonal(H)
        return np.linalg.inv(H + RIDGE * np.eye(len(use))) / np.outer(scale, scale)

    def _columns_with(self, extra: Sequence[int] | Index) -> Index:
        first = self.base_count + self.nuisance_count
        return np.concatenate([np.arange(first), self.cause_columns, np.asarray(extra, dtype=int)])

    def sigma(self, clock_relaxed: bool | None = None) -> Array:
        """Sigma of what is known beforehand, tempered, (K,); clock_relaxed: is the clock in doubt, else as causes say."""
        relaxed = self.clock_relaxed if clock_relaxed is None else clock_relaxed
        return (self.relaxed_sigma if relaxed else self.prior_sigma) / np.sqrt(self.temper)

    def _solve(self, products: Array, use: Index, sigma: Array, damping: float) -> tuple[Array, float]:
        """Numbers of the columns in use, and the loss."""
        sigma = sigma[use]
        has_prior = np.isfinite(sigma)
        last = len(self.prior_sigma)
        G = products[np.ix_(use, use)] + np.diag(1 / sigma**2)
        prior = self.prior_mean[use] / sigma**2
        b = prior - products[use, last]
        total = float(products[last, last] + prior @ self.prior_mean[use])
        G, scale = with_unit_diagonal(G)
        b = b / scale
        H = G + np.diag(np.where(has_prior, RIDGE, RIDGE + damping))
        x = bounded_minimum(H, b, self.lower_bounds[use] * scale, self.upper_bounds[use] * scale)
        loss = total - 2 * float(x @ b) + float(x @ G @ x)
        return x / scale, loss

    def chance_gains(self, choices: Sequence[Index], rng: np.random.Generator, worlds: int) -> Array:
        """The most that any of these choices of columns takes from the loss where nothing is wrong, (worlds,).

        In each world the base model holds: residuals are one draw of noise, blocks with signs at random, and what a drawing's
        errors do.
        """
        use, sigma = self._columns_with(()), self.relaxed_sigma
        first, count = self.base_count, self.nuisance_count
        signs = rng.choice([-1.0, 1.0], (worlds, len(self.block_products)))
        draws = rng.integers(self.noise_products.shape[2], size=worlds)
        gradient = np.einsum("nb,bkn->kn", signs, self.noise_products[:, :, draws])
        errors = rng.normal(size=(count, worlds))
        gradient += self.products[:-1, first : first + count] @ errors
        G = self.products[:-1, :-1] + np.diag(1 / sigma**2)
        G, scale = with_unit_diagonal(G)
        G, gradient = G + RIDGE * np.eye(len(scale)), gradient / scale[:, None]
        factor = cho_factor(G[np.ix_(use, use)])
        most = np.zeros(worlds)
        for columns in choices:
            across = G[np.ix_(use, columns)]
            S = G[np.ix_(columns, columns)] - across.T @ cho_solve(factor, across)
            v = gradient[columns] - across.T @ cho_solve(factor, gradient[use])
            most = np.maximum(most, np.einsum("in,in->n", v, np.linalg.lstsq(S, v, rcond=1e-9)[0]))
        return most

    def with_fixed(self, numbers: Array) -> "Comparison":
        """The comparison with these numbers (K,) taken as given: only what they leave remains to be explained."""
        products = self.block_products.copy()
        A, r = self.block_products[:, :-1, :-1], self.block_products[:, :-1, -1]
        products[:, :-1, -1] = products[:, -1, :-1] = r + A @ numbers
        products[:, -1, -1] += 2 * r @ numbers + numbers @ (A @ numbers).T
        matrices = []
        for old in self.matrices:
            new = old.copy()
            new[..., -1] += old[..., :-1] @ numbers
            matrices.append(new)
        return replace(self, block_products=products, matrices=tuple(matrices))

    def with_zero_residual(self) -> "Comparison":
        """The comparison with nothing to be explained: for asking what an effect would leave if there were nothing else."""
        products = self.products.copy()
        products[-1, :] = products[:, -1] = 0.0
        of_arm, low = slice(self.base_count, self.base_count + self.nuisances.count), self.lower_bounds.copy()
        low[of_arm] = -np.inf
        return replace(
            self,
            block_products=products[None],
            matrices=(),
            prior_mean=np.zeros_like(self.prior_mean),
            lower_bounds=low,
            upper_bounds=np.full_like(low, np.inf),
        )

    def fit_of_recordings(self) -> ColumnFit:
        """The fit of what each recording has for itself only: pre-elongations, delay, clock."""
        entries = self.linearisation.unknowns.entries
        numbers = [i for i, e in enumerate(entries) if e.recording is not None]
        clocks = self.base_count + np.arange(self.nuisances.count, self.nuisance_count)
        use = np.append(numbers, clocks)
        return ColumnFit(use, *self._solve(self.products, use, self.sigma(), 0.0))

    def answer(self, fitted: Index, moved: Index) -> Array:
        """By how much the numbers of columns that are `fitted` go back where those of others are `moved` by one, (len, len)."""
        return self._inverse(fitted) @ self.products[np.ix_(fitted, moved)]

    def residuals_after(self, fit: ColumnFit) -> list[Array]:
        """Residuals once fitted, of each recording, (C, S), in N and N m."""
        return [m[..., -1] + m[..., fit.columns] @ fit.numbers for m in self.matrices]

    def clock_shifts(self, fit: ColumnFit) -> Array:
        """By how much a fit puts each recording's frames later than the linearisation point has them, s, (R,)."""
        recordings = len(self.matrices)
        columns = self.base_count + self.nuisances.count + 2 * np.arange(recordings)
        return fit.numbers[np.searchsorted(fit.columns, columns)] * np.array(self.nuisances.clock_sigma)


def with_unit_diagonal(G: Array) -> tuple[Array, Array]:
    """Products G (k, k) of columns scaled to one, and the columns' own sizes, (k,)."""
    scale = np.sqrt(np.where(np.diag(G) > 0, np.diag(G), 1.0))
    return G / np.outer(scale, scale), scale
