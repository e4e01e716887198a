"""Normal equations of views that share a camera and a board, with the poses eliminated by the Schur complement.

With J = [A | B_1 .. B_n], A by the shared parameters and B_i by the pose of view i, the shared parameters' normal matrix is
S = sum_i A_i' A_i - (A_i' B_i)(B_i' B_i)^-1 (B_i' A_i), whose inverse times the residual variance is their covariance.
"""

from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True)
class BundleEquations:
    """Normal equations of n views: products of the derivatives by m shared parameters, by the pose (6), and the residuals."""

    products: np.ndarray  # of each view, the residuals last, shape (n, m + 7, m + 7)
    weight: np.ndarray  # of each corner, shape (n, c)
    prior: (
        np.ndarray
    )  # of the shared parameters: precision, and precision times the distance from the mean, shape (m, 2)
    by_offset: np.ndarray | None = None  # products of each corner's offset with the m + 7, shape (n, c, 3, m + 7)
    offset_squares: np.ndarray | None = None  # products of each corner's offset with itself, shape (n, c, 3, 3)
    precision: np.ndarray | None = None  # of the offsets' prior, shape (3,)
    offsets: np.ndarray | None = None  # their present values, shape (c, 3)
    basis: np.ndarray | None = None  # of the offsets, shape (3 c, b)

    def of(self, index: np.ndarray) -> "BundleEquations":
        """The normal equations of some of the views."""
        if self.by_offset is None or self.offset_squares is None:
            return replace(self, products=self.products[index], weight=self.weight[index])
        return replace(
            self,
            products=self.products[index],
            weight=self.weight[index],
            by_offset=self.by_offset[index],
            offset_squares=self.offset_squares[index],
        )

    def step(self, damping: float) -> tuple[np.ndarray, np.ndarray]:
        """The damped Gauss-Newton step of the shared parameters and offsets, shape (m + 3 c,), and of the poses, (n, 6)."""
        S, g, W, inverse, h = self._reduced(damping)
        step = np.zeros(len(g))
        if len(g):
            scale = np.sqrt(np.maximum(np.diag(S), 1e-300))  # k and f differ by orders of magnitude
            scaled, right = S / np.outer(scale, scale), g / scale
            try:
                step = -np.linalg.solve(scaled, right) / scale
            except np.linalg.LinAlgError:
                step = -np.linalg.lstsq(scaled, right, rcond=None)[0] / scale
        poses = -np.einsum("nab,nb->na", inverse, h + W @ step)
        if self.basis is not None:
            m = self.products.shape[1] - 7
            step = np.concatenate([step[:m], self.basis @ step[m:]])
        return step, poses

    def inverse(self) -> np.ndarray:
        """Inverse of the undamped normal matrix of the shared parameters and of the offsets in their basis."""
        S = self._reduced(0.0)[0]
        scale = np.sqrt(np.maximum(np.diag(S), 1e-300))
        return np.linalg.pinv(S / np.outer(scale, scale), hermitian=True) / np.outer(scale, scale)

    def _reduced(self, damping: float) -> tuple[np.ndarray, ...]:
        """Normal matrix and gradient with the poses eliminated; for the poses' step W (n, 6, M), the inverse of V, h (n, 6)."""
        m = self.products.shape[1] - 7
        total = self.products.sum(axis=0)
        U, g = total[:m, :m] + np.diag(self.prior[:, 0]), total[:m, -1] + self.prior[:, 1]
        V = self.products[:, m : m + 6, m : m + 6].copy()
        W, h = self.products[:, m : m + 6, :m], self.products[:, m : m + 6, -1]
        if self.by_offset is not None and self.offset_squares is not None:
            assert self.precision is not None
            assert self.offsets is not None
            assert self.basis is not None
            n, c = self.weight.shape
            summed = self.by_offset.sum(axis=0).reshape(3 * c, -1)
            between_offsets = np.zeros((c, 3, c, 3))
            each = np.arange(c)
            between_offsets[each, :, each, :] = self.offset_squares.sum(axis=0) + np.diag(self.precision)
            N = self.basis
            mixed = N.T @ summed
            U = np.block([[U, mixed[:, :m].T], [mixed[:, :m], N.T @ between_offsets.reshape(3 * c, 3 * c) @ N]])
            g = np.concatenate([g, mixed[:, -1] + N.T @ (self.precision * self.offsets).ravel()])
            W = np.concatenate([W, self.by_offset[..., m : m + 6].reshape(n, 3 * c, 6).transpose(0, 2, 1) @ N], axis=2)
        index = np.arange(6)
        V[:, index, index] *= 1 + damping
        U = U + damping * np.diag(np.diag(U))
        scale = np.sqrt(np.maximum(V[:, index, index], 1e-300))
        outer = scale[:, :, None] * scale[:, None]
        inverse = np.linalg.inv(V / outer) / outer
        rows = (6 * len(W), W.shape[2])
        eliminated = (inverse @ W).reshape(rows)
        return U - W.reshape(rows).T @ eliminated, g - h.ravel() @ eliminated, W, inverse, h
