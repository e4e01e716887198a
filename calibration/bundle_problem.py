"""Which numbers of camera and board are free, what is believed of them, and how residuals are weighed."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from calibration import board_shape, lens, reprojection
from calibration.board_poses import BoardPoses
from calibration.board_shape import BoardShape, ShapeModel
from calibration.normal_equations import BundleEquations
from calibration.stacked_views import StackedViews

HUBER_KNEE_SIGMA = 3.0
"""Beyond this distance, in sigmas of one coordinate, a corner counts for less: 1.1 % of Gaussian ones do"""


@dataclass(frozen=True)
class BundleProblem:
    """Which numbers are free, and how residuals are weighed."""

    sightings: StackedViews
    free: tuple[str, ...]
    model: ShapeModel
    noise: float | None

    @property
    def knee(self) -> float:
        return np.inf if self.noise is None else HUBER_KNEE_SIGMA * self.noise

    @cached_property
    def precision(self) -> np.ndarray:
        """Weight of an offset's square beside that of a residual's, shape (3,), px^2/m^2."""
        return ((self.noise or 0.0) / board_shape.offset_sigma(self.sightings.nominal)) ** 2

    @cached_property
    def number_precision(self) -> np.ndarray:
        """The same of the board's three numbers, shape (3,)."""
        return ((self.noise or 0.0) / np.array(board_shape.SHAPE_SIGMA)) ** 2

    def residuals(self, p: np.ndarray, points: np.ndarray, poses: BoardPoses) -> np.ndarray:
        return reprojection.reprojection_residuals(self.sightings, p, points, poses)

    def cost(self, residuals: np.ndarray, shape: BoardShape) -> float:
        distances = np.linalg.norm(residuals[self.sightings.seen], axis=1)
        believed = float(np.sum(self.precision * shape.offsets**2)) if self.model.offsets else 0.0
        believed += float(np.sum(self.number_precision * shape.values**2))
        return float(np.sum(reprojection.huber_loss(distances, self.knee))) + believed

    def normal(self, p: np.ndarray, shape: BoardShape, poses: BoardPoses, residuals: np.ndarray) -> BundleEquations:
        n, c = self.sightings.seen.shape
        weight = self.sightings.seen.astype(float)
        if np.isfinite(self.knee):
            weight *= np.minimum(1.0, self.knee / np.maximum(np.linalg.norm(residuals, axis=2), 1e-300))
        root = np.sqrt(weight)[..., None, None]
        by_point, by_pose = reprojection.pixel_jacobians(self.sightings, p, shape.points, poses)
        parts: list[np.ndarray] = []
        if self.free:
            columns = [lens.PARAMETER_NAMES.index(name) for name in self.free]
            parts.append(
                lens.parameter_jacobian(reprojection.corner_rays(self.sightings, shape.points, poses), p)[..., columns]
            )
        by_board = by_point @ poses.R[:, None] if self.model.free or self.model.offsets else None
        if self.model.free:
            shown = shape.modes[[board_shape.SHAPE_NAMES.index(name) for name in self.model.free]]
            parts.append(by_board @ shown.transpose(1, 2, 0))  # type: ignore[operator]
        parts += [by_pose, residuals[..., None]]
        all_of = root * np.concatenate(parts, axis=3)
        stacked = all_of.reshape(n, 2 * c, -1)
        products = stacked.transpose(0, 2, 1) @ stacked
        m = products.shape[1] - 7
        believed = np.zeros((m, 2))
        numbers = [board_shape.SHAPE_NAMES.index(name) for name in self.model.free]
        believed[len(self.free) :, 0] = self.number_precision[numbers]
        believed[len(self.free) :, 1] = (self.number_precision * shape.values)[numbers]
        if not self.model.offsets:
            return BundleEquations(products, weight, believed)
        E = (root * by_board).transpose(0, 1, 3, 2)
        own = E @ E.transpose(0, 1, 3, 2)
        return BundleEquations(
            products, weight, believed, E @ all_of, own, self.precision, shape.offsets, self.sightings.offset_basis
        )

    def moved(self, p: np.ndarray, shape: BoardShape, step: np.ndarray) -> tuple[np.ndarray, BoardShape]:
        return apply_step(p, shape, step, self.free)

    def covariances(self, normal: BundleEquations, distances: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Of the nine parameters and of the board's three numbers; zero where fixed."""
        camera, shape = np.zeros((9, 9)), np.zeros((3, 3))
        shared = len(self.free) + len(self.model.free)
        seen = self.sightings.seen
        n, corners = len(seen), int(seen.sum())
        if shared:
            inverse = normal.inverse()
            # an offset counts by how much of it the pictures decide
            decided = 0.0
            if self.model.offsets:
                basis = self.sightings.offset_basis
                believed = (basis.T * np.tile(self.precision, seen.shape[1])) @ basis
                decided = len(believed) - float(np.sum(believed * inverse[shared:, shared:]))
            freedom = max(2 * corners - shared - 6 * n - decided, 1.0)
            felt = np.minimum(distances[seen], self.knee)
            steep = np.where(distances[seen] <= self.knee, 1.0, 0.5 * felt / np.maximum(distances[seen], 1e-300))
            # Huber's estimator: E psi^2 / (E psi')^2, the matrix with its weights' mean taken out
            variance = float(np.sum(felt**2)) / freedom * float(np.mean(normal.weight[seen]) / np.mean(steep) ** 2)
            both = variance * inverse[:shared, :shared]
            columns = [lens.PARAMETER_NAMES.index(name) for name in self.free]
            k = len(columns)
            camera[np.ix_(columns, columns)] = both[:k, :k]
            columns = [board_shape.SHAPE_NAMES.index(name) for name in self.model.free]
            shape[np.ix_(columns, columns)] = both[k:, k:]
        return camera, shape


def apply_step(p: np.ndarray, shape: BoardShape, step: np.ndarray, free: tuple[str, ...]) -> tuple[np.ndarray, BoardShape]:
    """Parameters and shape after a step of the free ones."""
    k, j = len(free), len(shape.model.free)
    p, values, offsets = p.copy(), shape.values.copy(), shape.offsets
    p[[lens.PARAMETER_NAMES.index(name) for name in free]] += step[:k]
    values[[board_shape.SHAPE_NAMES.index(name) for name in shape.model.free]] += step[k : k + j]
    if shape.model.offsets:
        offsets = offsets + step[k + j :].reshape(-1, 3)
    return p, replace(shape, values=values, offsets=offsets)
