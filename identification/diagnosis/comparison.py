"""All causes side by side: every number of every one is a column, and one table of their products answers for any choice of them.

loss = |whitened residual - columns x numbers|^2 + (numbers known beforehand / sigma)^2
The base model's numbers are free in every comparison, nuisances are known to their sigma and go no further than a wall.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from identification.diagnosis.cause import Cause
from identification.diagnosis.effect import Effect, Shape
from identification.diagnosis.nuisances import WALL, Errors
from identification.diagnosis.point import Place, Point
from identification.whitening import Whitener

Array = NDArray[np.float64]
Index = NDArray[np.intp]

DELAY_SIGMA = 2e-3
"""s: forces act about when the log says"""
_RIDGE = 1e-9
"""of columns scaled to one, for those that nothing tells apart"""
_TURNS = 12


@dataclass(frozen=True)
class Group:
    """An effect in one of its shapes: where its columns stand."""

    effect: Effect
    shape: Shape
    columns: Index


@dataclass(frozen=True)
class Fitted:
    """A choice of causes fitted: columns in use, their numbers, loss, and covariance of the numbers."""

    columns: Index
    numbers: Array
    loss: float
    covariance: Array


@dataclass(frozen=True)
class Comparison:
    """Columns: the base model's, nuisances, then groups; `table` their products, the residual and noise draws last."""

    point: Point
    matrix: tuple[Array, ...]
    """of each recording, not whitened: columns and residual, (C, S, K + 1)"""
    base: int
    nuisances: tuple[str, ...]
    """the arm's, then of each recording its clock's two"""
    held: Index
    """columns of the causes named so far"""
    groups: tuple[Group, ...]
    table: Array
    sigma: Array
    """of what is known beforehand, (K,); inf where nothing is"""
    mean: Array
    """and what it is known to be"""
    rows: int
    """that count"""

    def fit(self, more: Sequence[int] | Index = (), damping: float = 0.0) -> Fitted:
        """The base model with nuisances, causes and further columns; damping (Marquardt's) for steps of what is not linear."""
        first = self.base + len(self.nuisances)
        return self._fit(np.concatenate([np.arange(first), self.held, np.asarray(more, dtype=int)]), damping)

    @property
    def merit(self) -> float:
        """Loss of the point as it is, but for nuisances."""
        return self._fit(np.arange(self.base, self.base + len(self.nuisances)), 0.0).loss

    def _fit(self, use: Index, damping: float) -> Fitted:
        nuisance = (use >= self.base) & (use < self.base + len(self.nuisances))
        last = len(self.sigma)
        G = self.table[np.ix_(use, use)] + np.diag(1 / self.sigma[use] ** 2)
        known = self.mean[use] / self.sigma[use] ** 2
        b = known - self.table[use, last]
        total = float(self.table[last, last] + known @ self.mean[use])
        scale = np.sqrt(np.where(np.diag(G) > 0, np.diag(G), 1.0))
        G, b = G / np.outer(scale, scale), b / scale
        H = G + np.diag(np.where(nuisance, _RIDGE, _RIDGE + damping))
        wall = WALL * self.sigma[use] * scale
        x, free = np.zeros(len(use)), np.ones(len(use), dtype=bool)
        for _ in range(_TURNS):
            held = np.where(free, 0.0, x)
            x[free] = cho_solve(cho_factor(H[np.ix_(free, free)]), (b - H @ held)[free])
            over = np.where(nuisance & free, np.abs(x) / wall, 0.0)
            if over.max() <= 1:
                break
            beyond = over >= max(1.0, over.max() / 2)
            x[beyond] = np.sign(x[beyond]) * wall[beyond]
            free &= ~beyond
        covariance = np.zeros_like(G)
        covariance[np.ix_(free, free)] = np.linalg.inv(H[np.ix_(free, free)])
        loss = total - 2 * float(x @ b) + float(x @ G @ x)
        return Fitted(use, x / scale, loss, covariance / np.outer(scale, scale))

    def shifted(self, numbers: Array) -> "Comparison":
        """With these numbers (K,) taken as given: what remains to be explained is other."""
        A, r = self.table[:-1, :-1], self.table[:-1, -1]
        table = self.table.copy()
        table[:-1, -1] = table[-1, :-1] = r + A @ numbers
        table[-1, -1] += 2 * float(r @ numbers) + float(numbers @ A @ numbers)
        matrix = []
        for old in self.matrix:
            new = old.copy()
            new[..., -1] += old[..., :-1] @ numbers
            matrix.append(new)
        return replace(self, table=table, matrix=tuple(matrix))

    def silent(self) -> "Comparison":
        """With nothing to be explained: for asking what would be seen of something."""
        table = self.table.copy()
        table[-1, :] = table[:, -1] = 0.0
        return replace(self, table=table, matrix=(), mean=np.zeros_like(self.mean))

    def of_recordings(self) -> Fitted:
        """Only what each recording has of its own: pre-elongations, delay, clock."""
        entries = self.point.unknowns.entries
        own = [i for i, e in enumerate(entries) if e.recording is not None]
        clocks = self.base + np.arange(len(self.nuisances) - 2 * len(self.matrix), len(self.nuisances))
        return self._fit(np.append(own, clocks), 0.0)

    def left(self, fit: Fitted) -> list[Array]:
        """Residuals once fitted, of each recording, (C, S), in N and N m."""
        return [m[..., -1] + m[..., fit.columns] @ fit.numbers for m in self.matrix]

    def columns(self, group: Group, where: Sequence[int]) -> Index:
        """Of a group in a place."""
        return group.columns[list(where)]


def compare(
    at: Point, causes: Sequence[Cause], effects: Sequence[tuple[Effect, Shape]], known: Errors, whiten: Whitener
) -> Comparison:
    """Causes that the point holds, and effects, each in the shape given, beside them."""
    places = at.places
    size, arm = at.unknowns.size, places[0].signals.arm
    own = 2 * len(places)
    matrices: list[Array] = []
    names = known.names
    widths: list[int] = []
    for r, place in enumerate(places):
        recording = np.zeros((*place.rows.residual.shape, own))
        recording[..., 2 * r : 2 * r + 2] = known.own[r]
        further = [cause.columns(place) for cause in causes]
        further += [effect.columns(place, shape) * effect.sizes(arm) for effect, shape in effects]
        widths = [part.shape[2] for part in further]
        parts = [place.rows.jacobian * size, known.arm[r], recording, *further, place.rows.residual[..., None]]
        matrices.append(np.concatenate(parts, axis=2))
    first = len(size) + len(names) + own
    ends = first + np.cumsum([0, *widths])
    slots = [np.arange(a, b) for a, b in pairwise(ends)]
    groups = [Group(e, shape, s) for (e, shape), s in zip(effects, slots[len(causes) :], strict=True)]
    k = int(ends[-1])
    table, rows = np.zeros((k + 1, k + 1)), 0
    for matrix, place in zip(matrices, places, strict=True):
        flat = whiten(matrix, begins(place)).reshape(-1, k + 1)
        table += flat.T @ flat
        rows += int(np.count_nonzero(flat[:, -1]))
    sigma, mean = np.full(k, np.inf), np.zeros(k)
    sigma[len(size) : first] = 1.0
    for i, entry in enumerate(at.unknowns.entries):
        if entry.term.name == "delay":
            sigma[i], mean[i] = DELAY_SIGMA / entry.term.size, -at.p[i] / entry.term.size
    every = (*names, *(f"{name} of recording {r + 1}" for r in range(len(places)) for name in ("clock", "skew")))
    held = np.concatenate([np.zeros(0, dtype=int), *slots[: len(causes)]]).astype(int)
    return Comparison(at, tuple(matrices), len(size), every, held, tuple(groups), table, sigma, mean, rows)


def begins(place: Place) -> NDArray[np.bool_]:
    """Filtered rows that have none right before them."""
    keep = place.signals.low_pass
    return np.concatenate([[True], np.diff(keep.kept) > keep.factor])
