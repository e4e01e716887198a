"""The least-squares problem of a bundle adjustment: free parameters, their priors, robust weights, normal equations."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from calibration import board_shape, lens, reprojection
from calibration.board_poses import BoardPoses
from calibration.board_shape import BoardShape, ShapeModel
from calibration.normal_equations import BundleEquations
from calibration.stacked_views import StackedViews

HUBER_KNEE_SIGMA = 3.0
"""knee of Huber's loss in standard deviations of one coordinate; 1.1 % of Gaussian corners are beyond (docs/thresholds.md)"""


@dataclass(frozen=True)
class BundleProblem:
    """The views, the free parameters of camera and board, and the noise that sets the weights."""

    views: StackedViews
    free: tuple[str, ...]  # names of the free camera parameters
    model: ShapeModel
    noise: float | None  # standard deviation of a corner's coordinate, px; None for plain least squares

    @property
    def knee(self) -> float:
        """Knee of Huber's loss, px; infinite for plain least squares."""
        return np.inf if self.noise is None else HUBER_KNEE_SIGMA * self.noise

    @cached_property
    def offset_precision(self) -> np.ndarray:
        """Prior weight of a corner offset's square relative to a residual's square, shape (3,), px^2/m^2."""
        return ((self.noise or 0.0) / board_shape.offset_sigma(self.views.nominal)) ** 2

    @cached_property
    def shape_precision(self) -> np.ndarray:
        """Prior weight of the squares of the board's three shape parameters relative to a residual's square, shape (3,)."""
        return ((self.noise or 0.0) / np.array(board_shape.SHAPE_SIGMA)) ** 2

    def residuals(self, p: np.ndarray, points: np.ndarray, poses: BoardPoses) -> np.ndarray:
        """Predicted less observed corners, shape (n, c, 2), px."""
        return reprojection.reprojection_residuals(self.views, p, points, poses)

    def cost(self, residuals: np.ndarray, shape: BoardShape) -> float:
        """Huber's loss of all corners and the squares of the prior, px^2."""
        distances = np.linalg.norm(residuals[self.views.visible], axis=1)
        prior = float(np.sum(self.offset_precision * shape.offsets**2)) if self.model.offsets else 0.0
        prior += float(np.sum(self.shape_precision * shape.values**2))
        return float(np.sum(reprojection.huber_loss(distances, self.knee))) + prior

    def normal(self, p: np.ndarray, shape: BoardShape, poses: BoardPoses, residuals: np.ndarray) -> BundleEquations:
        """The weighted normal equations of all views at an estimate and its residuals."""
        n, c = self.views.visible.shape
        weight = self.views.visible.astype(float)
        if np.isfinite(self.knee):
            weight *= np.minimum(1.0, self.knee / np.maximum(np.linalg.norm(residuals, axis=2), 1e-300))
        root = np.sqrt(weight)[..., None, None]
        by_point, by_pose = reprojection.pixel_jacobians(self.views, p, shape.points, poses)
        parts: list[np.ndarray] = []
        if self.free:
            columns = [lens.PARAMETER_NAMES.index(name) for name in self.free]
            parts.append(
                lens.parameter_jacobian(reprojection.corner_rays(self.views, shape.points, poses), p)[..., columns]
            )
        by_board = by_point @ poses.R[:, None] if self.model.free or self.model.offsets else None
        if self.model.free:
            free_modes = shape.modes[[board_shape.SHAPE_NAMES.index(name) for name in self.model.free]]
            parts.append(by_board @ free_modes.transpose(1, 2, 0))  # type: ignore[operator]
        parts += [by_pose, residuals[..., None]]
        derivatives = root * np.concatenate(parts, axis=3)
        stacked = derivatives.reshape(n, 2 * c, -1)
        products = stacked.transpose(0, 2, 1) @ stacked
        m = products.shape[1] - 7
        prior = np.zeros((m, 2))
        numbers = [board_shape.SHAPE_NAMES.index(name) for name in self.model.free]
        prior[len(self.free) :, 0] = self.shape_precision[numbers]
        prior[len(self.free) :, 1] = (self.shape_precision * shape.values)[numbers]
        if not self.model.offsets:
            return BundleEquations(products=products, weight=weight, prior=prior)
        E = (root * by_board).transpose(0, 1, 3, 2)
        return BundleEquations(
            products=products,
            weight=weight,
            prior=prior,
            by_offset=E @ derivatives,
            offset_squares=E @ E.transpose(0, 1, 3, 2),
            precision=self.offset_precision,
            offsets=shape.offsets,
            basis=self.views.offset_basis,
        )

    def moved(self, p: np.ndarray, shape: BoardShape, step: np.ndarray) -> tuple[np.ndarray, BoardShape]:
        """Camera parameters and board shape after a step of the free ones."""
        return apply_step(p, shape, step, self.free)

    def covariances(self, normal: BundleEquations, distances: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Covariances of the camera parameters, (9, 9), and of the board's shape parameters, (3, 3); zero where fixed."""
        camera, shape = np.zeros((9, 9)), np.zeros((3, 3))
        shared = len(self.free) + len(self.model.free)
        visible = self.views.visible
        n, corners = len(visible), int(visible.sum())
        if shared:
            inverse = normal.inverse()
            # an offset costs as many degrees of freedom as the pictures, not the prior, determine
            determined = 0.0
            if self.model.offsets:
                basis = self.views.offset_basis
                prior = (basis.T * np.tile(self.offset_precision, visible.shape[1])) @ basis
                determined = len(prior) - float(np.sum(prior * inverse[shared:, shared:]))
            freedom = max(2 * corners - shared - 6 * n - determined, 1.0)
            psi = np.minimum(distances[visible], self.knee)
            slope = np.where(distances[visible] <= self.knee, 1.0, 0.5 * psi / np.maximum(distances[visible], 1e-300))
            # Huber's estimator: E psi^2 / (E psi')^2, the matrix with its weights' mean taken out
            variance = float(np.sum(psi**2)) / freedom * float(np.mean(normal.weight[visible]) / np.mean(slope) ** 2)
            both = variance * inverse[:shared, :shared]
            columns = [lens.PARAMETER_NAMES.index(name) for name in self.free]
            k = len(columns)
            camera[np.ix_(columns, columns)] = both[:k, :k]
            columns = [board_shape.SHAPE_NAMES.index(name) for name in self.model.free]
            shape[np.ix_(columns, columns)] = both[k:, k:]
        return camera, shape


def apply_step(
    p: np.ndarray, shape: BoardShape, step: np.ndarray, free: tuple[str, ...]
) -> tuple[np.ndarray, BoardShape]:
    """Camera parameters and board shape after a step of those that are free."""
    k, j = len(free), len(shape.model.free)
    p, values, offsets = p.copy(), shape.values.copy(), shape.offsets
    p[[lens.PARAMETER_NAMES.index(name) for name in free]] += step[:k]
    values[[board_shape.SHAPE_NAMES.index(name) for name in shape.model.free]] += step[k : k + j]
    if shape.model.offsets:
        offsets = offsets + step[k + j :].reshape(-1, 3)
    return p, replace(shape, values=values, offsets=offsets)
