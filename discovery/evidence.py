"""What blocks of time say of columns: their products, with which any sum of them is fitted, judged, and compared with chance."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

Array = NDArray[np.float64]
Index = NDArray[np.intp]

FOLDS = 5
"""of the cross-validation, dealt by blocks in turn (docs/thresholds.md)"""
TOLD_SHARE = 0.02
"""of what all blocks say of a function: where those of the other folds say less, amounts go to nothing (docs/thresholds.md)"""
_RIDGE = 1e-9
"""of columns scaled to one, for those that nothing tells apart"""


@dataclass(frozen=True)
class Evidence:
    """P columns that are always fitted, then K that are asked about, and the target last."""

    products: Array
    """by blocks, (B, P + K + 1, P + K + 1)"""
    precision: Array
    """of what is known of the first P numbers, (P,)"""

    @classmethod
    def of(cls, base: Array, precision: Array, asked: Array, target: Array, blocks: Index) -> "Evidence":
        """From rows (rows, P), (rows, K) and (rows,) and the block of each."""
        matrix = np.concatenate([base, asked, target[:, None]], axis=1)
        if np.any(np.diff(blocks) < 0):
            matrix = matrix[np.argsort(blocks, kind="stable")]
        parts = np.split(matrix, np.cumsum(np.bincount(blocks))[:-1])
        return cls(np.array([part.T @ part for part in parts]), precision)

    def of_columns(self, columns: Index) -> "Evidence":
        """The same where only some of the K columns are asked about."""
        kept = np.concatenate([np.arange(self.fitted), self.fitted + columns, [self.products.shape[1] - 1]])
        return Evidence(self.products[:, kept[:, None], kept], self.precision)

    @property
    def fitted(self) -> int:
        """P."""
        return len(self.precision)

    @cached_property
    def total(self) -> Array:
        """Products of all blocks together, (P + K + 1, P + K + 1)."""
        return self.products.sum(axis=0)

    @cached_property
    def reduced(self) -> tuple[Array, Array]:
        """x S x / 2 - v x of the columns asked about where the fitted ones are at their best: S (K, K), v (K,)."""
        p, last = self.fitted, self.total.shape[0] - 1
        G = self.total[p:last, p:last]
        across = self._across
        return G - self.total[p:last, :p] @ across, self.total[p:last, last] - across.T @ self.total[:p, last]

    @cached_property
    def _across(self) -> Array:
        """How the fitted columns answer to those asked about, (P, K)."""
        p, last = self.fitted, self.total.shape[0] - 1
        return _solved(self.total[:p, :p] + np.diag(self.precision), self.total[:p, p:last])

    def gains(self, functions: Array) -> Array:
        """What each of n sums of columns (n, K, k) takes from the loss, (n,)."""
        S, v = self.reduced
        return _energy(S, v[:, None], functions)[:, 0]

    def block_gradients(self, function: Array) -> Array:
        """Gradients of the columns asked about, reduced, by what is left with a function (K, k) fitted, by blocks, (B, K)."""
        p, last = self.fitted, self.total.shape[0] - 1
        x = np.append(-self.fit(function), 1.0)
        turned = self.products @ (self._turned(function) @ x)
        return turned[:, p:last] - turned[:, :p] @ self._across

    def chance_gains(self, functions: Array, gradients: Array, signs: Array) -> Array:
        """The most that any of n functions (n, K, k) takes where signs (worlds, B) turn the blocks over, (worlds,)."""
        S, _ = self.reduced
        return _energy(S, gradients.T @ signs.T, functions).max(axis=0)

    def fit(self, function: Array) -> Array:
        """Numbers of the fitted columns and of a function's (K, k), (P + k,)."""
        T = self._turned(function)
        return self._solve(T.T @ self.total @ T)

    @cached_property
    def folds(self) -> Index:
        """The fold of every block, (B,)."""
        return np.arange(len(self.products)) % FOLDS

    def fits_without_folds(self, function: Array) -> list[Array]:
        """Numbers as `fit` has them, (P + k,), where each fold in turn is not fitted.

        A fold may hold nearly all that tells a function, as the only time in which a force went beyond a hinge: amounts that
        the others would take from what else is wrong there would be anything, and are held at nothing.
        """
        T = self._turned(function)
        of_folds = T.T @ self._fold_products @ T
        whole = of_folds.sum(axis=0)
        held = np.zeros_like(whole)
        held[self.fitted : -1, self.fitted : -1] = TOLD_SHARE * function.T @ self.reduced[0] @ function
        return [self._solve(whole - own + held) for own in of_folds]

    @cached_property
    def _fold_products(self) -> Array:
        """Products of the blocks of each fold together, (folds, P + K + 1, P + K + 1)."""
        return np.array([self.products[self.folds == f].sum(axis=0) for f in range(min(FOLDS, len(self.products)))])

    def block_losses(self, function: Array) -> Array:
        """Loss of every block where all folds but its own were fitted, (B,)."""
        T = self._turned(function)
        out = np.zeros(len(self.products))
        for f, numbers in enumerate(self.fits_without_folds(function)):
            x, left_out = T @ np.append(-numbers, 1.0), self.products[self.folds == f]
            out[self.folds == f] = np.einsum("i,bij,j->b", x, left_out, x)
        return out

    def loss(self, function: Array) -> float:
        """The loss with the fitted columns' numbers and a function's (K, k) at their best, what is known beforehand included."""
        T = self._turned(function)
        whole = T.T @ self.total @ T
        return float(whole[-1, -1] - whole[-1, :-1] @ self._solve(whole))

    def covariance(self, function: Array) -> Array:
        """Covariance of the numbers of `fit`, (P + k, P + k), by what blocks do to the numbers.

        It is nowhere less than that of rows that are each for themselves.
        """
        T = self._turned(function)
        products = T.T @ self.products @ T
        whole, x = products.sum(axis=0), np.append(-self.fit(function), 1.0)
        size, count = len(x) - 1, len(products)
        inverse = np.linalg.pinv(whole[:-1, :-1] + self._prior(size), rcond=1e-12, hermitian=True)
        scores = (products @ x)[:, :-1]
        spread = np.einsum("bi,bj->ij", scores, scores) * count / max(count - 1, 1)
        known = inverse @ self._prior(size) @ inverse
        by_blocks = inverse @ spread @ inverse
        of_noise = inverse @ whole[:-1, :-1] @ inverse
        widened = np.sqrt(np.maximum(np.diag(of_noise) / np.maximum(np.diag(by_blocks), 1e-300), 1.0))
        return by_blocks * np.outer(widened, widened) + known

    def _turned(self, function: Array) -> Array:
        """From all columns to the fitted ones, a function's and the target, (P + K + 1, P + k + 1)."""
        p, (rows, k) = self.fitted, function.shape
        out = np.zeros((p + rows + 1, p + k + 1))
        out[:p, :p] = np.eye(p)
        out[p : p + rows, p : p + k] = function
        out[-1, -1] = 1.0
        return out

    def _solve(self, whole: Array) -> Array:
        return _solved(whole[:-1, :-1] + self._prior(len(whole) - 1), whole[:-1, -1])

    def _prior(self, size: int) -> Array:
        return np.diag(np.append(self.precision, np.zeros(size - self.fitted)))


def _solved(G: Array, b: Array) -> Array:
    """x of G x = b, G symmetric; directions that nothing tells stay near zero."""
    scale = _sizes(np.diag(G))
    factor = cho_factor(G / np.outer(scale, scale) + _RIDGE * np.eye(len(G)))
    rows = scale if b.ndim == 1 else scale[:, None]
    return np.asarray(cho_solve(factor, b / rows)) / rows


def _sizes(energies: Array) -> Array:
    """Sizes of columns by their energies, to scale them to one; one where a column is so small that its square is no number.

    So is a bump at a place to which a motor never turns."""
    return np.sqrt(np.where(energies > np.finfo(float).tiny, energies, 1.0))


def _energy(S: Array, v: Array, functions: Array) -> Array:
    """v' F (F' S F)^-1 F' v of functions F (n, K, k) and vectors v (K, m), (n, m)."""
    n, rows, k = functions.shape
    side_by_side = functions.swapaxes(0, 1).reshape(rows, n * k)
    G = functions.swapaxes(1, 2) @ (S @ side_by_side).reshape(rows, n, k).swapaxes(0, 1)
    w = (side_by_side.T @ v).reshape(n, k, -1)
    diagonal = np.einsum("nkk->nk", G)
    scale = _sizes(diagonal)
    G = G / (scale[:, :, None] * scale[:, None, :]) + 1e-7 * np.eye(G.shape[1])
    w = w / scale[:, :, None]
    return np.einsum("nkm,nkm->nm", w, np.linalg.solve(G, w))
