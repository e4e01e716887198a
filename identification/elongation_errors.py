"""Whole recordings err alike where angles follow from vision and cables together: by what frames left uncertain of the cables' law.

That law, elongations x = X beta with columns of tension and friction, is fitted along with the angles (state_estimation). An error
of beta moves all angles by one pattern, which goes with the tension and with the sense of motion. In the arm's equations it is the
twin of another friction, and no block of rows shows it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset import DataSet

Array = NDArray[np.float64]

NUISANCE_VARIANCE_RATIO = 1.7
"""of the cables' nuisances over what errors independent of their regressors would give: rounding of counts enters both
(docs/thresholds.md)"""
_MIN_EIGENVALUE = 1e-9
"""of the columns' correlations: what they do not tell apart is left out"""


@dataclass(frozen=True)
class ElongationErrors:
    """What angles and cables err by."""

    of_mean: Array
    """of an elongation's mean over all frames, by vision's noise, (M,), m"""
    own: Array
    """by which the cables are weighted, (M,), m; inf where one was left out"""
    vision: Array
    """of a frame's angles, which tell what cables do not, (N,), rad"""

    @classmethod
    def of(cls, data: DataSet, Z: Array) -> "ElongationErrors | None":
        """None where angles are by vision alone. Z: of the rows, (T, N, M), m."""
        state, sigma = data.clock.get("state") or {}, data.angles.matrix("sigma")
        own = state.get("cable_error_m")
        if state.get("method") != "fused" or own is None or not sigma.size:
            return None
        of_frames = np.nanmean(sigma**2, axis=0)
        return cls(
            of_mean=np.sqrt(np.mean(Z**2, axis=0).T @ of_frames / len(sigma)),
            own=np.array([np.inf if error is None else error for error in own], dtype=float),
            vision=np.sqrt(of_frames),
        )

    def of_angles(self, Z: Array, tension: Array, command: Array, dry: Array, theta_d: Array) -> list[Array]:
        """Errors of the angles, each (S, N), rad, independent of each other and of size one sigma.

        Z: (S, N, M), m; tension and command: (S, M), N; dry: friction for one newton, (S, M); theta_d: (S, M), rad/s.
        """
        weight = 1 / self.own**2
        stiffness = np.einsum("tij,j,tkj->tik", Z, weight, Z) + np.diag(1 / self.vision**2)
        out = []
        for j in np.flatnonzero(weight):
            t, d = tension[:, j], dry[:, j]
            columns = [np.ones_like(t), t, t**2, t**3, np.gradient(t), np.gradient(command[:, j]), d]
            columns += [d * (1 - d**2), theta_d[:, j]]
            for pattern in _independent(np.stack(columns, axis=-1)):
                pulled = Z[..., j] * (weight[j] * self.of_mean[j] * pattern)[:, None]
                out.append(np.linalg.solve(stiffness, pulled[..., None])[..., 0])
        return out


def _independent(X: Array) -> Array:
    """Errors X beta, (E, S), of one sigma each: beta errs as a fit to X does if the mean of all rows has a variance of one."""
    X = X / np.maximum(np.sqrt(np.mean(X**2, axis=0)), np.finfo(float).tiny)
    size, axes = np.linalg.eigh(X.T @ X / len(X))
    told = size > _MIN_EIGENVALUE
    return np.sqrt(NUISANCE_VARIANCE_RATIO) * (X @ (axes[:, told] / np.sqrt(size[told]))).T
