"""All causes side by side: every number of every one is a column, and tables of their products answer for any choice of them.

loss = |whitened residual - columns x numbers|^2 + ((numbers - prior mean) / prior sigma)^2
The base model's numbers are free in every comparison, nuisances are known to their sigma.
Tables are kept by blocks of time, so that a choice can be fitted to some of them and judged on the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from diagnosis.bounded_least_squares import bounded_minimum
from diagnosis.cause import Cause
from diagnosis.effect import Effect, Shape
from diagnosis.linearisation import Linearisation
from diagnosis.nuisances import Nuisances
from identification.fitting import segment_starts
from identification.unknowns import DELAY_SIGMA_S
from identification.whitening import Whitener

Array = NDArray[np.float64]
Index = NDArray[np.intp]

FOLD_BLOCK_S = 2.0
"""s: blocks that are dealt to folds, longer than what residuals remember (docs/thresholds.md)"""
FOLDS = 5
"""of the cross-validation (docs/thresholds.md)"""
_TELLING_SHARE = 0.1
"""of what all blocks tell of a column: a block that tells more is dealt by how much it tells (docs/thresholds.md)"""
_HELD_SIGMA = 1e-6
"""in sizes, of shape terms that are at the end of their range"""
_RIDGE = 1e-9
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
class Eliminated:
    """x G x / 2 - b x of the columns behind the nuisances, where all before them is at its best; loss where x is zero."""

    first: int
    """number of the first of these columns"""
    G: Array
    b: Array
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
    nuisances: Nuisances
    clock_relaxed: bool
    """whether the causes named so far put the clock in doubt"""
    row_count: int
    """of rows that count"""

    @cached_property
    def products(self) -> Array:
        """Of all blocks, (K + 1, K + 1)."""
        return self.block_products.sum(axis=0)

    def fit(
        self, extra: Sequence[int] | Index = (), damping: float = 0.0, clock_relaxed: bool | None = None
    ) -> ColumnFit:
        """The base model with nuisances, causes and extra columns; damping (Marquardt's) for steps of what is not linear."""
        use, sigma = self._columns_with(extra), self._sigma(clock_relaxed)
        return ColumnFit(use, *self._solve(self.products, use, sigma, damping))

    def fit_within(self, reach: float) -> ColumnFit:
        """As `fit`, with nuisances of the drawing and of the angles' zeros that go no further than `reach` tolerances."""
        free = self.fit()
        numbers, held = free.numbers.copy(), np.zeros(len(free.columns), dtype=bool)
        of_arm = (free.columns >= self.base_count) & (free.columns < self.base_count + self.nuisances.count)
        while np.any(beyond := of_arm & ~held & (np.abs(numbers) > reach)):
            held |= beyond
            numbers[held] = np.clip(numbers[held], -reach, reach)
            fixed = np.zeros(len(self.prior_sigma))
            fixed[free.columns[held]] = numbers[held]
            rest = free.columns[~held]
            numbers[~held] = self._solve(self.with_fixed(fixed).products, rest, self._sigma(None), 0.0)[0]
        return replace(free, numbers=numbers)

    def block_losses(
        self, extra: Sequence[int] | Index = (), clock_relaxed: bool | None = None, folds: Index | None = None
    ) -> Array:
        """Loss of every block where all folds but its own were fitted, (B,); folds: of the blocks, else those of `folds(extra)`."""
        use, sigma = self._columns_with(extra), self._sigma(clock_relaxed)
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

    def eliminated(self) -> Eliminated:
        """What any choice of causes and effects would leave, none of which the residual holds yet."""
        first, last = self.base_count + self.nuisance_count, len(self.prior_sigma)
        sigma = self._sigma(None)
        G = self.products[:last, :last] + np.diag(1 / sigma**2)
        prior = self.prior_mean / sigma**2
        b = prior - self.products[:last, last]
        total = float(self.products[last, last] + prior @ self.prior_mean)
        scale = np.sqrt(np.where(np.diag(G) > 0, np.diag(G), 1.0))
        G, b = G / np.outer(scale, scale) + _RIDGE * np.eye(last), b / scale
        factor = cho_factor(G[:first, :first])
        across = cho_solve(factor, G[:first, first:])
        S = G[first:, first:] - G[:first, first:].T @ across
        reduced = b[first:] - across.T @ b[:first]
        back = scale[first:]
        return Eliminated(
            first=first,
            G=S * np.outer(back, back),
            b=reduced * back,
            loss=total - float(b[:first] @ cho_solve(factor, b[:first])),
        )

    def with_held(self, columns: Index) -> "Comparison":
        """With numbers of these columns that stay as they are."""
        prior, relaxed = self.prior_sigma.copy(), self.relaxed_sigma.copy()
        prior[columns] = relaxed[columns] = _HELD_SIGMA
        return replace(self, prior_sigma=prior, relaxed_sigma=relaxed)

    def with_causes_off(self, numbers: Array) -> "Comparison":
        """As if the causes that the linearisation holds were not there; numbers: their amounts and shapes, in columns' sizes."""
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
        fit, sigma = self.fit(extra, clock_relaxed=clock_relaxed), self._sigma(clock_relaxed)
        beyond = (fit.numbers - self.prior_mean[fit.columns]) / sigma[fit.columns]
        return float(beyond @ beyond)

    @cached_property
    def profiled_loss(self) -> float:
        """Loss of the linearisation point as it is, with nuisances at their best."""
        use = np.arange(self.base_count, self.base_count + self.nuisance_count)
        return self._solve(self.products, use, self._sigma(None), 0.0)[1] + self._prior_of_rest(use)

    @cached_property
    def loss_with_fixed_causes(self) -> float:
        """Loss with the base model's numbers at their best, and the causes' at the linearisation point's."""
        use = np.arange(self.base_count + self.nuisance_count)
        return self._solve(self.products, use, self._sigma(None), 0.0)[1] + self._prior_of_rest(use)

    def _prior_of_rest(self, use: Index) -> float:
        """The part of the loss that is of what is known beforehand of numbers that are not fitted."""
        beyond = self.prior_mean / self._sigma(None)
        return float(np.sum(np.delete(beyond, use) ** 2))

    def plain_covariance(self, fit: ColumnFit) -> Array:
        """Of a fit's numbers, if all that is left were noise alike in all blocks: nowhere wider than what is known beforehand."""
        return self.temper * self._inverse(fit.columns)

    def covariance(self, fit: ColumnFit) -> Array:
        """Of a fit's numbers: what blocks do to them, each for itself, and what is not known of nuisances."""
        use, last = fit.columns, len(self.prior_sigma)
        precision, inverse = 1 / self._sigma(None)[use] ** 2, self._inverse(use)
        score = self.block_products[:, use[:, None], use] @ fit.numbers + self.block_products[:, use, last]
        count = len(self.block_products)
        spread = np.einsum("bi,bj->ij", score, score) * count / max(count - 1, 1)
        # rows that are told well by their own number count at least as noise does
        of_noise = self.products[np.ix_(use, use)]
        by_blocks, by_noise = inverse @ spread @ inverse, inverse @ of_noise @ inverse
        widened = np.sqrt(np.maximum(np.diag(by_noise) / np.maximum(np.diag(by_blocks), 1e-300), 1.0))
        return by_blocks * np.outer(widened, widened) + inverse @ np.diag(precision) @ inverse

    def _inverse(self, use: Index) -> Array:
        """Of the products of columns in use with what is known beforehand."""
        H = self.products[np.ix_(use, use)] + np.diag(1 / self._sigma(None)[use] ** 2)
        scale = np.sqrt(np.where(np.diag(H) > 0, np.diag(H), 1.0))
        return np.linalg.inv(H / np.outer(scale, scale) + _RIDGE * np.eye(len(use))) / np.outer(scale, scale)

    def _columns_with(self, extra: Sequence[int] | Index) -> Index:
        first = self.base_count + self.nuisance_count
        return np.concatenate([np.arange(first), self.cause_columns, np.asarray(extra, dtype=int)])

    def _sigma(self, clock_relaxed: bool | None) -> Array:
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
        scale = np.sqrt(np.where(np.diag(G) > 0, np.diag(G), 1.0))
        G, b = G / np.outer(scale, scale), b / scale
        H = G + np.diag(np.where(has_prior, _RIDGE, _RIDGE + damping))
        x = bounded_minimum(H, b, self.lower_bounds[use] * scale)
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
        scale = np.sqrt(np.where(np.diag(G) > 0, np.diag(G), 1.0))
        G, gradient = G / np.outer(scale, scale) + _RIDGE * np.eye(len(scale)), gradient / scale[:, None]
        factor = cho_factor(G[np.ix_(use, use)])
        most = np.zeros(worlds)
        for columns in choices:
            across = G[np.ix_(use, columns)]
            S = G[np.ix_(columns, columns)] - across.T @ cho_solve(factor, across)
            v = gradient[columns] - across.T @ cho_solve(factor, gradient[use])
            most = np.maximum(most, np.einsum("in,in->n", v, np.linalg.lstsq(S, v, rcond=1e-9)[0]))
        return most

    def with_fixed(self, numbers: Array) -> "Comparison":
        """With these numbers (K,) taken as given: only what they leave remains to be explained."""
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
        """With nothing to be explained: for asking what an effect would leave if there were nothing else."""
        products = self.products.copy()
        products[-1, :] = products[:, -1] = 0.0
        return replace(self, block_products=products[None], matrices=(), prior_mean=np.zeros_like(self.prior_mean))

    def fit_of_recordings(self) -> ColumnFit:
        """Of what each recording has for itself only: pre-elongations, delay, clock."""
        entries = self.linearisation.unknowns.entries
        numbers = [i for i, e in enumerate(entries) if e.recording is not None]
        clocks = self.base_count + np.arange(self.nuisances.count, self.nuisance_count)
        use = np.append(numbers, clocks)
        return ColumnFit(use, *self._solve(self.products, use, self._sigma(None), 0.0))

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


def compare(
    at: Linearisation,
    causes: Sequence[Cause],
    effects: Sequence[tuple[Effect, Shape]],
    nuisances: Nuisances,
    whiten: Whitener,
    noise: Sequence[Sequence[Array]] = (),
    clock_relaxed: bool | None = None,
) -> Comparison:
    """Causes that the linearisation's hypothesis holds, and effects beside them, each in the shape given.

    noise: draws of each recording. clock_relaxed: whether the clock is in doubt; unless said, it is where a cause is named that
    is not the clock itself.
    """
    matrices, widths = _matrices(at, causes, effects, nuisances)
    nuisance_count = nuisances.count + 2 * len(at.recordings)
    first = len(at.unknowns.size) + nuisance_count
    slots = [np.arange(a, b) for a, b in pairwise(first + np.cumsum([0, *widths]))]
    block_products, noise_products, row_count = _products(at, matrices, whiten, noise)
    prior_sigma, relaxed_sigma, prior_mean = _priors(at, nuisances, first, first + sum(widths))
    for cause, slot in zip(causes, slots, strict=False):
        held = slot[len(cause.amounts) :][cause.at_limit(at.hypothesis.arm)]
        prior_sigma[held] = relaxed_sigma[held] = _HELD_SIGMA
    if clock_relaxed is None:
        clock_relaxed = bool(causes) and not any(cause.effect.is_clock for cause in causes)
    return Comparison(
        linearisation=at,
        matrices=tuple(matrices),
        base_count=len(at.unknowns.size),
        nuisance_count=nuisance_count,
        cause_columns=np.concatenate([np.zeros(0, dtype=int), *slots[: len(causes)]]).astype(int),
        groups=tuple(
            EffectColumns(effect, shape, slot)
            for (effect, shape), slot in zip(effects, slots[len(causes) :], strict=True)
        ),
        block_products=block_products,
        noise_products=noise_products,
        prior_sigma=prior_sigma,
        relaxed_sigma=relaxed_sigma,
        prior_mean=prior_mean,
        lower_bounds=_lower_bounds(at, len(prior_sigma)),
        nuisances=nuisances,
        clock_relaxed=clock_relaxed,
        row_count=row_count,
    )


class WhitenedComparison:
    """A comparison whose columns are whitened once, to be taken with those of one effect or another beside it.

    No blocks are kept: it answers for fits, and not for what they leave where they were not fitted."""

    def __init__(self, comparison: Comparison, whiten: Whitener) -> None:
        self._comparison, self._whiten = comparison, whiten
        self._white = self._whitened(comparison.matrices)
        self._products = sum((w.T @ w for w in self._white), start=np.zeros(()))

    def beside(self, effect: Effect, shape: Shape) -> Comparison:
        """With an effect's columns behind all others."""
        c = self._comparison
        recordings, arm = c.linearisation.recordings, c.linearisation.hypothesis.arm
        further = [effect.columns(recording, shape) * effect.sizes(arm) for recording in recordings]
        white, count, width = self._whitened(further), len(c.prior_sigma), further[0].shape[2]
        of_base, new = [*range(count), count + width], slice(count, count + width)
        products = np.empty((count + width + 1, count + width + 1))
        products[np.ix_(of_base, of_base)] = self._products
        products[of_base, new] = sum((b.T @ w for b, w in zip(self._white, white, strict=True)), start=np.zeros(()))
        products[new, of_base] = products[of_base, new].T
        products[new, new] = sum((w.T @ w for w in white), start=np.zeros(()))
        free = np.full(width, np.inf)
        return replace(
            c,
            matrices=tuple(
                np.concatenate([m[..., :-1], f, m[..., -1:]], axis=2) for m, f in zip(c.matrices, further, strict=True)
            ),
            groups=(EffectColumns(effect, shape, np.arange(count, count + width)),),
            block_products=products[None],
            noise_products=np.zeros((1, count + width, 0)),
            prior_sigma=np.append(c.prior_sigma, free),
            relaxed_sigma=np.append(c.relaxed_sigma, free),
            prior_mean=np.append(c.prior_mean, np.zeros(width)),
            lower_bounds=np.append(c.lower_bounds, -free),
        )

    def _whitened(self, matrices: Sequence[Array]) -> list[Array]:
        pairs = zip(matrices, self._comparison.linearisation.recordings, strict=True)
        return [self._whiten(m, segment_starts(r.signals), r.input_variance).reshape(-1, m.shape[2]) for m, r in pairs]


def _matrices(
    at: Linearisation, causes: Sequence[Cause], effects: Sequence[tuple[Effect, Shape]], nuisances: Nuisances
) -> tuple[list[Array], list[int]]:
    """Columns and residual of each recording, (C, S, K + 1), and the number of columns of each cause and effect."""
    arm = at.recordings[0].signals.arm
    matrices: list[Array] = []
    widths: list[int] = []
    for r, recording in enumerate(at.recordings):
        clocks = np.zeros((*recording.rows.residual.shape, 2 * len(at.recordings)))
        clocks[..., 2 * r : 2 * r + 2] = nuisances.clock_columns[r]
        further = [cause.columns(recording) for cause in causes]
        further += [effect.columns(recording, shape) * effect.sizes(arm) for effect, shape in effects]
        widths = [part.shape[2] for part in further]
        base = recording.rows.jacobian * at.unknowns.size
        residual = recording.rows.residual[..., None]
        matrices.append(np.concatenate([base, nuisances.arm_columns[r], clocks, *further, residual], axis=2))
    return matrices, widths


def _products(
    at: Linearisation, matrices: Sequence[Array], whiten: Whitener, noise: Sequence[Sequence[Array]]
) -> tuple[Array, Array, int]:
    """By blocks: products of whitened columns with each other and with draws of noise; the number of rows that count."""
    block_products, noise_products, row_count = [], [], 0
    for r, (matrix, recording) in enumerate(zip(matrices, at.recordings, strict=True)):
        s, variance = recording.signals, recording.input_variance
        starts, width = segment_starts(s), matrix.shape[2]
        white = whiten(matrix, starts, variance)
        white_noise = whiten(np.stack(noise[r], axis=-1), starts, variance) if noise else white[..., :0]
        length = max(1, round(FOLD_BLOCK_S / (s.step * s.low_pass.factor)))
        for begin in range(0, white.shape[1], length):
            rows = white[:, begin : begin + length].reshape(-1, width)
            block_products.append(rows.T @ rows)
            noise_products.append(rows[:, :-1].T @ white_noise[:, begin : begin + length].reshape(len(rows), -1))
        row_count += int(np.count_nonzero(white[..., -1]))
    return np.array(block_products), np.array(noise_products), row_count


def _priors(at: Linearisation, nuisances: Nuisances, first: int, count: int) -> tuple[Array, Array, Array]:
    """Sigma, the same with clocks in doubt, and mean of what is known beforehand, (count,); first: behind the nuisances."""
    size = at.unknowns.size
    sigma, mean = np.full(count, np.inf), np.zeros(count)
    sigma[len(size) : first] = 1.0
    for i, entry in enumerate(at.unknowns.entries):
        if entry.term.name == "delay":
            sigma[i], mean[i] = DELAY_SIGMA_S / entry.term.size, -at.p[i] / entry.term.size
    relaxed = sigma.copy()
    recordings = len(at.recordings)
    for r in range(recordings):
        clock = first - 2 * recordings + 2 * r
        relaxed[clock] = nuisances.clock_relaxation[r]
        mean[clock] = -at.frame_lags[r] / nuisances.clock_sigma[r]
    return sigma, relaxed, mean


def _lower_bounds(at: Linearisation, count: int) -> Array:
    """Of the numbers (count,): what is nothing at zero may come out a little below by chance, but no further."""
    lowest = [e.term.low - (e.term.size if e.term.linear and e.term.low == 0 else 0.0) for e in at.unknowns.entries]
    bounds = np.full(count, -np.inf)
    bounds[: len(lowest)] = np.minimum(np.array(lowest) - at.p, 0.0) / at.unknowns.size
    return bounds
