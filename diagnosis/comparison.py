"""All causes side by side: every number of every one is a column, and tables of their products answer for any choice of them.

loss = |whitened residual - columns x numbers|^2 + (numbers known beforehand / sigma)^2
The base model's numbers are free in every comparison, nuisances are known to their sigma and go no further than a wall.
Tables are kept by blocks of time, so that a choice can be fitted to some of them and judged on the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from diagnosis.bounded_least_squares import between_walls
from diagnosis.cause import Cause
from diagnosis.effect import Effect, Shape
from diagnosis.linearisation import Linearisation
from diagnosis.nuisances import WALL, Errors
from identification.fitting import stretch_starts
from identification.whitening import Whitener

Array = NDArray[np.float64]
Index = NDArray[np.intp]

DELAY_SIGMA = 1e-3
"""s: forces act about when the log says, no more than a row or two later"""
BLOCK_S = 2.0
"""s: longer than what residuals remember"""
FOLDS = 5
_MUCH = 0.1
"""of what is told of a column"""
_RIDGE = 1e-9
"""of columns scaled to one, for those that nothing tells apart"""


@dataclass(frozen=True)
class Group:
    """An effect in one of its shapes: where its columns stand."""

    effect: Effect
    shape: Shape
    columns: Index


@dataclass(frozen=True)
class Fitted:
    """A choice of causes fitted: columns in use, their numbers, and the loss."""

    columns: Index
    numbers: Array
    loss: float


@dataclass(frozen=True)
class Comparison:
    """Columns: the base model's, nuisances, then causes that are named and groups that are asked about."""

    point: Linearisation
    matrix: tuple[Array, ...]
    """of each recording, not whitened: columns and residual, (C, S, K + 1)"""
    base: int
    nuisances: tuple[str, ...]
    """the arm's, then of each recording its clock's two"""
    held: Index
    """columns of the causes named so far"""
    groups: tuple[Group, ...]
    blocks: Array
    """products of the columns with the residual last, (B, K + 1, K + 1)"""
    chance: Array
    """of the columns with draws of noise, (B, K, D)"""
    sigma: Array
    """of what is known beforehand, (K,); inf where nothing is"""
    doubt: Array
    """the same where the clock rests on a model that is wrong"""
    mean: Array
    """and what it is known to be, in the same units"""
    least: Array
    """below which numbers do not go, (K,); -inf where they may"""
    known: Errors
    """what small errors do"""
    doubted: bool
    """whether the clock is in doubt for the causes named so far"""
    rows: int
    """that count"""

    @cached_property
    def table(self) -> Array:
        """Of all blocks, (K + 1, K + 1)."""
        return self.blocks.sum(axis=0)

    def fit(self, more: Sequence[int] | Index = (), damping: float = 0.0, doubted: bool | None = None) -> Fitted:
        """The base model with nuisances, causes and further columns; damping (Marquardt's) for steps of what is not linear."""
        use, sigma = self._use(more), self._known(doubted)
        return Fitted(use, *self._solved(self.table, use, sigma, damping))

    def crossed(
        self, more: Sequence[int] | Index = (), doubted: bool | None = None, dealt: Index | None = None
    ) -> Array:
        """Loss of every block where all folds but its own were fitted, (B,). dealt: the blocks' folds, if not by what is in use."""
        use, sigma = self._use(more), self._known(doubted)
        fold = self.dealt(more) if dealt is None else dealt
        out = np.zeros(len(self.blocks))
        for f in range(min(FOLDS, len(out))):
            own = self.blocks[fold == f]
            x, _ = self._solved(self.table - own.sum(axis=0), use, sigma, 0.0)
            y = np.append(x, 1.0)
            at = np.append(use, len(self.sigma))
            out[fold == f] = np.einsum("i,bij,j->b", y, own[:, at[:, None], at], y)
        return out

    def dealt(self, more: Sequence[int] | Index = ()) -> Index:
        """The fold of every block, (B,): in turn, but of blocks that tell much of a cause none has more than others."""
        columns = np.append(self.held, np.asarray(more, dtype=int))
        fold = np.arange(len(self.blocks)) % FOLDS
        told = self.blocks[:, columns, columns]
        share = (told / np.maximum(told.sum(axis=0), 1e-300)).max(axis=1, initial=0.0)
        much = np.flatnonzero(share > _MUCH)
        fold[much[np.argsort(-share[much])]] = np.arange(len(much)) % FOLDS
        return fold

    @cached_property
    def merit(self) -> float:
        """Loss of the point as it is, but for nuisances."""
        use = np.arange(self.base, self.base + len(self.nuisances))
        known = np.sum((self.mean[: self.base] / self.sigma[: self.base]) ** 2)
        return self._solved(self.table, use, self._known(None), 0.0)[1] + float(known)

    @cached_property
    def with_causes_as_they_are(self) -> float:
        """Loss with the base model's numbers at their best, and the causes' at the point's."""
        return self._solved(self.table, np.arange(self.base + len(self.nuisances)), self._known(None), 0.0)[1]

    def covariance(self, fit: Fitted) -> Array:
        """Of a fit's numbers: what blocks do to them, each for itself, and what is not known of nuisances."""
        use, last = fit.columns, len(self.sigma)
        weight = 1 / self._known(None)[use] ** 2
        told = np.diag(self.table)[use] + weight
        scale = np.sqrt(np.where(told > 0, told, 1.0))
        H = (self.table[np.ix_(use, use)] + np.diag(weight)) / np.outer(scale, scale)
        inverse = np.linalg.inv(H + _RIDGE * np.eye(len(use))) / np.outer(scale, scale)
        pull = self.blocks[:, use[:, None], use] @ fit.numbers + self.blocks[:, use, last]
        count = len(self.blocks)
        spread = np.einsum("bi,bj->ij", pull, pull) * count / max(count - 1, 1)
        # rows that are told well by their own number count at least as noise does
        least = self.table[np.ix_(use, use)]
        alone, usual = inverse @ spread @ inverse, inverse @ least @ inverse
        wider = np.sqrt(np.maximum(np.diag(usual) / np.maximum(np.diag(alone), 1e-300), 1.0))
        return alone * np.outer(wider, wider) + inverse @ np.diag(weight) @ inverse

    def _use(self, more: Sequence[int] | Index) -> Index:
        first = self.base + len(self.nuisances)
        return np.concatenate([np.arange(first), self.held, np.asarray(more, dtype=int)])

    def _known(self, doubted: bool | None) -> Array:
        return self.doubt if (self.doubted if doubted is None else doubted) else self.sigma

    def _solved(self, table: Array, use: Index, sigma: Array, damping: float) -> tuple[Array, float]:
        """Numbers and loss."""
        sigma = sigma[use]
        nuisance = np.isfinite(sigma)
        last = len(self.sigma)
        G = table[np.ix_(use, use)] + np.diag(1 / sigma**2)
        known = self.mean[use] / sigma**2
        b = known - table[use, last]
        total = float(table[last, last] + known @ self.mean[use])
        scale = np.sqrt(np.where(np.diag(G) > 0, np.diag(G), 1.0))
        G, b = G / np.outer(scale, scale), b / scale
        H = G + np.diag(np.where(nuisance, _RIDGE, _RIDGE + damping))
        wall, middle = WALL * sigma * scale, self.mean[use] * scale
        low, high = np.maximum(middle - wall, self.least[use] * scale), middle + wall
        x = between_walls(H, b, low, high)
        loss = total - 2 * float(x @ b) + float(x @ G @ x)
        return x / scale, loss

    def by_chance(self, choices: Sequence[Index], rng: np.random.Generator, count: int) -> Array:
        """The most that any of these choices of columns takes from the loss where nothing is wrong, in `count` worlds.

        In each the base model holds: residuals are one draw of noise, blocks with signs at random, and what a drawing's errors do.
        """
        use, sigma = self._use(()), self._known(True)
        first, wrong = self.base, len(self.nuisances)
        signs = rng.choice([-1.0, 1.0], (count, len(self.blocks)))
        drawn = rng.integers(self.chance.shape[2], size=count)
        seen = np.einsum("nb,bkn->kn", signs, self.chance[:, :, drawn])
        off = np.clip(rng.normal(size=(wrong, count)), -WALL, WALL)
        seen += self.table[:-1, first : first + wrong] @ off
        G = self.table[:-1, :-1] + np.diag(1 / sigma**2)
        scale = np.sqrt(np.where(np.diag(G) > 0, np.diag(G), 1.0))
        G, seen = G / np.outer(scale, scale) + _RIDGE * np.eye(len(scale)), seen / scale[:, None]
        known = cho_factor(G[np.ix_(use, use)])
        most = np.zeros(count)
        for columns in choices:
            across = G[np.ix_(use, columns)]
            S = G[np.ix_(columns, columns)] - across.T @ cho_solve(known, across)
            v = seen[columns] - across.T @ cho_solve(known, seen[use])
            most = np.maximum(most, np.einsum("in,in->n", v, np.linalg.lstsq(S, v, rcond=1e-9)[0]))
        return most

    def shifted(self, numbers: Array) -> "Comparison":
        """With these numbers (K,) taken as given: what remains to be explained is other."""
        blocks = self.blocks.copy()
        A, r = self.blocks[:, :-1, :-1], self.blocks[:, :-1, -1]
        blocks[:, :-1, -1] = blocks[:, -1, :-1] = r + A @ numbers
        blocks[:, -1, -1] += 2 * r @ numbers + numbers @ (A @ numbers).T
        matrix = []
        for old in self.matrix:
            new = old.copy()
            new[..., -1] += old[..., :-1] @ numbers
            matrix.append(new)
        return replace(self, blocks=blocks, matrix=tuple(matrix))

    def silent(self) -> "Comparison":
        """With nothing to be explained: for asking what would be seen of something."""
        table = self.table.copy()
        table[-1, :] = table[:, -1] = 0.0
        return replace(self, blocks=table[None], matrix=(), mean=np.zeros_like(self.mean))

    def of_recordings(self) -> Fitted:
        """Only what each recording has of its own: pre-elongations, delay, clock."""
        entries = self.point.unknowns.entries
        own = [i for i, e in enumerate(entries) if e.recording is not None]
        clocks = self.base + np.arange(len(self.known.names), len(self.nuisances))
        use = np.append(own, clocks)
        return Fitted(use, *self._solved(self.table, use, self._known(None), 0.0))

    def left(self, fit: Fitted) -> list[Array]:
        """Residuals once fitted, of each recording, (C, S), in N and N m."""
        return [m[..., -1] + m[..., fit.columns] @ fit.numbers for m in self.matrix]

    def clock_moved(self, fit: Fitted) -> Array:
        """By how much a fit puts each recording's frames later than the point has them, s, (R,)."""
        count = len(self.matrix)
        columns = self.base + len(self.known.names) + 2 * np.arange(count)
        return fit.numbers[np.searchsorted(fit.columns, columns)] * np.array(self.known.clock)


def compare(
    at: Linearisation,
    causes: Sequence[Cause],
    effects: Sequence[tuple[Effect, Shape]],
    known: Errors,
    whiten: Whitener,
    drawn: Sequence[Sequence[Array]] = (),
    doubted: bool | None = None,
) -> Comparison:
    """Causes that the point holds, and effects, each in the shape given, beside them. drawn: noise of each recording.

    doubted: whether the clock is; unless said it is where a cause is named that is not the clock itself.
    """
    places = at.places
    size, arm = at.unknowns.size, places[0].signals.arm
    own = 2 * len(places)
    matrices: list[Array] = []
    widths: list[int] = []
    for r, place in enumerate(places):
        recording = np.zeros((*place.rows.residual.shape, own))
        recording[..., 2 * r : 2 * r + 2] = known.own[r]
        further = [cause.columns(place) for cause in causes]
        further += [effect.columns(place, shape) * effect.sizes(arm) for effect, shape in effects]
        widths = [part.shape[2] for part in further]
        parts = [place.rows.jacobian * size, known.arm[r], recording, *further, place.rows.residual[..., None]]
        matrices.append(np.concatenate(parts, axis=2))
    first = len(size) + len(known.names) + own
    ends = first + np.cumsum([0, *widths])
    slots = [np.arange(a, b) for a, b in pairwise(ends)]
    groups = [Group(e, shape, s) for (e, shape), s in zip(effects, slots[len(causes) :], strict=True)]
    k = int(ends[-1])
    blocks, chance, rows = [], [], 0
    for r, (matrix, place) in enumerate(zip(matrices, places, strict=True)):
        s = place.signals
        starts = stretch_starts(s)
        white = whiten(matrix, starts, place.unsure)
        noise = whiten(np.stack(drawn[r], axis=-1), starts, place.unsure) if drawn else white[..., :0]
        length = max(1, round(BLOCK_S / (s.step * s.low_pass.factor)))
        for begin in range(0, white.shape[1], length):
            part = white[:, begin : begin + length].reshape(-1, k + 1)
            blocks.append(part.T @ part)
            chance.append(part[:, :k].T @ noise[:, begin : begin + length].reshape(len(part), -1))
        rows += int(np.count_nonzero(white[..., -1]))
    sigma, mean, least = np.full(k, np.inf), np.zeros(k), np.full(k, -np.inf)
    # what is nothing at zero may come out a little below by chance, but no further
    lowest = [e.term.low - (e.term.size if e.term.linear and e.term.low == 0 else 0.0) for e in at.unknowns.entries]
    least[: len(size)] = np.minimum(np.array(lowest) - at.p, 0.0) / size
    sigma[len(size) : first] = 1.0
    for i, entry in enumerate(at.unknowns.entries):
        if entry.term.name == "delay":
            sigma[i], mean[i] = DELAY_SIGMA / entry.term.size, -at.p[i] / entry.term.size
    doubt = sigma.copy()
    for r in range(len(places)):
        at_clock = first - own + 2 * r
        doubt[at_clock] = known.doubt[r]
        mean[at_clock] = -at.late[r] / known.clock[r]
    every = (*known.names, *(f"{name} of recording {r + 1}" for r in range(len(places)) for name in ("clock", "skew")))
    held = np.concatenate([np.zeros(0, dtype=int), *slots[: len(causes)]]).astype(int)
    if doubted is None:
        doubted = bool(causes) and not any(cause.effect.of_clock for cause in causes)
    return Comparison(
        at, tuple(matrices), len(size), every, held, tuple(groups), np.array(blocks), np.array(chance),
        sigma, doubt, mean, least, known, doubted, rows,
    )  # fmt: skip
