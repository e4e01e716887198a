"""Camera, board shape and board poses together, by least squares on the reprojection error: one routine serves every fit here.

Poses are eliminated by the Schur complement: with J = [A | B_1 .. B_n], A by what all views share, the normal equations
of the shared are S = sum_i A_i' A_i - (A_i' B_i)(B_i' B_i)^-1 (B_i' A_i), whose inverse times the residual variance is
their covariance. Huber's loss on the distance of each corner keeps a single bad one from bending the camera.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from calibration import board_shape, lens
from calibration.board_shape import BoardShape, ShapeModel, flat
from calibration.sightings import Sightings

DEFAULT_FREE = lens.MODELS["k1 k2 p1 p2"]
KNEE = 3.0
"""Beyond this distance, in sigmas of one coordinate, a corner counts for less: 1.1 % of Gaussian ones do"""


@dataclass(frozen=True)
class Poses:
    """T_camera_board of each view: p_camera = R p_board + t."""

    R: np.ndarray  # shape (n, 3, 3)
    t: np.ndarray  # shape (n, 3), m

    def of(self, index: np.ndarray | Sequence[int]) -> "Poses":
        """The poses of some of the views."""
        return Poses(self.R[index], self.t[index])

    def moved(self, steps: np.ndarray) -> "Poses":
        """Turned from the left by steps[:, :3], rad, and shifted by steps[:, 3:], m; shape (n, 6)."""
        return Poses(Rotation.from_rotvec(steps[:, :3]).as_matrix() @ self.R, self.t + steps[:, 3:])


@dataclass(frozen=True)
class Fit:
    """The least squares of a set of views."""

    parameters: np.ndarray  # order of lens.NAMES, shape (9,)
    poses: Poses
    free: tuple[str, ...]
    shape: BoardShape
    distances: np.ndarray  # predicted from seen, zero where not seen, shape (n, c), px
    knee: float  # px; infinite for plain least squares
    covariance: np.ndarray  # of the parameters for independent equal corner errors, shape (9, 9)
    shape_covariance: np.ndarray  # of shape.values, shape (3, 3)
    converged: bool
    seen: np.ndarray  # shape (n, c)
    normal: "_Normal"  # at the solution

    @property
    def rms(self) -> float:
        """px, over all corners."""
        return float(np.sqrt(np.sum(self.distances**2) / np.sum(self.seen)))

    @property
    def rms_views(self) -> np.ndarray:
        """Per view, px (over corners: sqrt of the mean squared distance), shape (n,)."""
        return np.sqrt(np.sum(self.distances**2, axis=1) / self.seen.sum(axis=1))

    @property
    def robust_rms_views(self) -> np.ndarray:
        """The same of Huber's loss, which single bad corners do not lift, shape (n,), px."""
        return np.sqrt(np.sum(huber(self.distances, self.knee), axis=1) / self.seen.sum(axis=1))


def start(sightings: Sightings, image_size: tuple[int, int]) -> tuple[np.ndarray, Poses]:
    """Parameters and poses close enough to iterate from: focal length and poses from homographies, no distortion.

    Raises cv2.error where OpenCV finds no start (views of lines, for example).
    """
    objects = [sightings.nominal[seen].astype(np.float32) for seen in sightings.seen]
    images = [
        at[seen].astype(np.float32).reshape(-1, 1, 2) for at, seen in zip(sightings.pixels, sightings.seen, strict=True)
    ]
    K = cv2.initCameraMatrix2D(objects, images, image_size)
    found = [cv2.solvePnP(o, i, K, None, flags=cv2.SOLVEPNP_IPPE)[1:] for o, i in zip(objects, images, strict=True)]
    rvecs, tvecs = (np.array(part, float).reshape(-1, 3) for part in zip(*found, strict=True))
    parameters = np.array([K[0, 0], K[1, 1], K[0, 2], K[1, 2], 0.0, 0.0, 0.0, 0.0, 0.0])
    return parameters, Poses(Rotation.from_rotvec(rvecs).as_matrix(), tvecs)


def fit(
    sightings: Sightings,
    parameters: np.ndarray,
    poses: Poses,
    free: Sequence[str] = DEFAULT_FREE,
    shape: BoardShape | None = None,
    shape_model: ShapeModel = board_shape.MODELS["rigid"],
    noise: float | None = None,
    iterations: int = 50,
) -> Fit:
    """Levenberg-Marquardt from a start. What is not `free` keeps its value; with none free poses alone are fitted.

    `noise` is the corners' standard deviation, px: it sets the knee of Huber's loss and the weight of what is believed of
    free offsets beforehand; without it plain least squares.
    """
    if shape_model.offsets and noise is None:
        raise ValueError("free offsets need the corners' noise")
    problem = _Problem(sightings, tuple(free), shape_model, noise)
    p = np.array(parameters, float)
    shape = replace(shape or flat(sightings.ids, sightings.nominal), model=shape_model)
    residuals = problem.residuals(p, shape.points, poses)
    cost = problem.cost(residuals, shape)
    damping, converged = 1e-6, False
    for _ in range(iterations):
        normal = problem.normal(p, shape, poses, residuals)
        while damping < 1e6:
            step, pose_steps = normal.step(damping)
            p_new, shape_new = problem.moved(p, shape, step)
            poses_new = poses.moved(pose_steps)
            new = problem.residuals(p_new, shape_new.points, poses_new)
            new_cost = problem.cost(new, shape_new)
            if new_cost <= cost:  # also false for NaN
                break
            damping *= 10
        else:
            converged = True  # no step improves: as far as floating point goes
            break
        gain = cost - new_cost
        p, shape, poses, residuals, cost = p_new, shape_new, poses_new, new, new_cost
        damping = max(damping / 10, 1e-9)
        if gain <= 1e-8 * cost + 1e-18:  # of 1000 corners: a few thousandths of a sigma
            converged = True
            break
    normal = problem.normal(p, shape, poses, residuals)
    distances = np.where(sightings.seen, np.linalg.norm(residuals, axis=2), 0.0)
    covariance, shape_covariance = problem.covariances(normal, distances)
    return Fit(
        p, poses, problem.free, shape, distances, problem.knee, covariance, shape_covariance, converged,
        sightings.seen, normal,
    )  # fmt: skip


def without(fitted: Fit, groups: Sequence[np.ndarray]) -> list[tuple[np.ndarray, BoardShape]]:
    """Parameters and board shape as they would be without the views of each group: one Gauss-Newton step from the whole.

    The step is of the order of sigma, where the problem is as good as linear; nothing is projected again.
    """
    found: list[tuple[np.ndarray, BoardShape]] = []
    for group in groups:
        step = fitted.normal.of(np.delete(np.arange(len(fitted.seen)), group)).step(0.0)[0]
        found.append(_moved(fitted.parameters, fitted.shape, step, fitted.free))
    return found


def predicted(
    sightings: Sightings, parameters: np.ndarray, points: np.ndarray, poses: Poses, knee: float = np.inf, steps: int = 4
) -> np.ndarray:
    """Distances of corners that each view's own camera (n, 9) and board (n, c, 3) leave, only the pose fitted; (n, c), px.

    All views at once, from poses that are nearly right; a view that a step would not improve keeps its pose.
    """
    p = parameters[:, None, :]
    residuals = _residuals(sightings, p, points, poses)
    distances = np.where(sightings.seen, np.linalg.norm(residuals, axis=2), 0.0)
    cost = huber(distances, knee).sum(axis=1)
    for _ in range(steps):
        _, B = _by_point_and_pose(sightings, p, points, poses)
        weight = np.sqrt(sightings.seen * np.minimum(1.0, knee / np.maximum(distances, 1e-300)))
        J = (weight[..., None, None] * B).reshape(len(cost), -1, 6)
        r = (weight[..., None] * residuals).reshape(len(cost), -1, 1)
        V = J.transpose(0, 2, 1) @ J
        scale = np.sqrt(np.einsum("nii->ni", V))
        step = -np.linalg.solve(V / (scale[:, :, None] * scale[:, None]), J.transpose(0, 2, 1) @ r / scale[..., None])
        moved = poses.moved(step[..., 0] / scale)
        new = _residuals(sightings, p, points, moved)
        new_distances = np.where(sightings.seen, np.linalg.norm(new, axis=2), 0.0)
        new_cost = huber(new_distances, knee).sum(axis=1)
        better = new_cost < cost
        poses = Poses(np.where(better[:, None, None], moved.R, poses.R), np.where(better[:, None], moved.t, poses.t))
        residuals = np.where(better[:, None, None], new, residuals)
        distances = np.where(better[:, None], new_distances, distances)
        cost = np.where(better, new_cost, cost)
    return distances


def huber(distances: np.ndarray, knee: float) -> np.ndarray:
    """Huber's loss, the square up to the knee and then a line: px^2."""
    if np.isinf(knee):
        return distances**2
    return np.where(distances <= knee, distances**2, knee * (2 * distances - knee))


def residuals_of(fitted: Fit, sightings: Sightings) -> np.ndarray:
    """Predicted less seen, shape (n, c, 2), px; zero where not seen."""
    return _residuals(sightings, fitted.parameters, fitted.shape.points, fitted.poses)


def noise_of(fitted: Fit) -> float:
    """Standard deviation of one coordinate, px, from the median distance, which bad corners do not move."""
    return max(float(np.median(fitted.distances[fitted.seen])) / np.sqrt(2 * np.log(2)), 1e-3)


@dataclass(frozen=True)
class _Problem:
    """Which numbers are free, and how residuals are weighed."""

    sightings: Sightings
    free: tuple[str, ...]
    model: ShapeModel
    noise: float | None

    @property
    def knee(self) -> float:
        return np.inf if self.noise is None else KNEE * self.noise

    @cached_property
    def precision(self) -> np.ndarray:
        """Weight of an offset's square beside that of a residual's, shape (3,), px^2/m^2."""
        return ((self.noise or 0.0) / board_shape.offset_sigma(self.sightings.nominal)) ** 2

    @cached_property
    def number_precision(self) -> np.ndarray:
        """The same of the board's three numbers, shape (3,)."""
        return ((self.noise or 0.0) / np.array(board_shape.NUMBER_SIGMA)) ** 2

    def residuals(self, p: np.ndarray, points: np.ndarray, poses: Poses) -> np.ndarray:
        return _residuals(self.sightings, p, points, poses)

    def cost(self, residuals: np.ndarray, shape: BoardShape) -> float:
        distances = np.linalg.norm(residuals[self.sightings.seen], axis=1)
        believed = float(np.sum(self.precision * shape.offsets**2)) if self.model.offsets else 0.0
        believed += float(np.sum(self.number_precision * shape.values**2))
        return float(np.sum(huber(distances, self.knee))) + believed

    def normal(self, p: np.ndarray, shape: BoardShape, poses: Poses, residuals: np.ndarray) -> "_Normal":
        n, c = self.sightings.seen.shape
        weight = self.sightings.seen.astype(float)
        if np.isfinite(self.knee):
            weight *= np.minimum(1.0, self.knee / np.maximum(np.linalg.norm(residuals, axis=2), 1e-300))
        root = np.sqrt(weight)[..., None, None]
        by_point, by_pose = _by_point_and_pose(self.sightings, p, shape.points, poses)
        parts: list[np.ndarray] = []
        if self.free:
            columns = [lens.NAMES.index(name) for name in self.free]
            parts.append(lens.parameter_jacobian(_rays(self.sightings, shape.points, poses), p)[..., columns])
        by_board = by_point @ poses.R[:, None] if self.model.free or self.model.offsets else None
        if self.model.free:
            shown = shape.modes[[board_shape.NAMES.index(name) for name in self.model.free]]
            parts.append(by_board @ shown.transpose(1, 2, 0))  # type: ignore[operator]
        parts += [by_pose, residuals[..., None]]
        all_of = root * np.concatenate(parts, axis=3)
        stacked = all_of.reshape(n, 2 * c, -1)
        products = stacked.transpose(0, 2, 1) @ stacked
        m = products.shape[1] - 7
        believed = np.zeros((m, 2))
        numbers = [board_shape.NAMES.index(name) for name in self.model.free]
        believed[len(self.free) :, 0] = self.number_precision[numbers]
        believed[len(self.free) :, 1] = (self.number_precision * shape.values)[numbers]
        if not self.model.offsets:
            return _Normal(products, weight, believed)
        E = (root * by_board).transpose(0, 1, 3, 2)
        own = E @ E.transpose(0, 1, 3, 2)
        return _Normal(
            products, weight, believed, E @ all_of, own, self.precision, shape.offsets, self.sightings.offset_basis
        )

    def moved(self, p: np.ndarray, shape: BoardShape, step: np.ndarray) -> tuple[np.ndarray, BoardShape]:
        return _moved(p, shape, step, self.free)

    def covariances(self, normal: "_Normal", distances: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
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
            columns = [lens.NAMES.index(name) for name in self.free]
            k = len(columns)
            camera[np.ix_(columns, columns)] = both[:k, :k]
            columns = [board_shape.NAMES.index(name) for name in self.model.free]
            shape[np.ix_(columns, columns)] = both[k:, k:]
        return camera, shape


@dataclass(frozen=True)
class _Normal:
    """Normal equations view by view: of the m shared numbers, the pose (6) and the residuals, and of each corner's offset."""

    products: np.ndarray  # shape (n, m + 7, m + 7)
    weight: np.ndarray  # of each corner, shape (n, c)
    believed: np.ndarray  # of the shared numbers beforehand: precision, and its pull, shape (m, 2)
    by_offset: np.ndarray | None = None  # offset by the same m + 7, shape (n, c, 3, m + 7)
    offset_squares: np.ndarray | None = None  # shape (n, c, 3, 3)
    precision: np.ndarray | None = None  # of what is believed of the offsets, shape (3,)
    offsets: np.ndarray | None = None  # where they are, shape (c, 3)
    basis: np.ndarray | None = None  # of the offsets, shape (3 c, b)

    def of(self, index: np.ndarray) -> "_Normal":
        """Of some views only."""
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
        """The damped Gauss-Newton step: of the shared numbers and offsets, shape (m + 3 c,), and of the poses, (n, 6)."""
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
        """Of the undamped matrix of shared numbers and the offsets in their basis."""
        S = self._reduced(0.0)[0]
        scale = np.sqrt(np.maximum(np.diag(S), 1e-300))
        return np.linalg.pinv(S / np.outer(scale, scale), hermitian=True) / np.outer(scale, scale)

    def _reduced(self, damping: float) -> tuple[np.ndarray, ...]:
        """Matrix and gradient with the poses eliminated, and what finishes a step: W (n, 6, M), inverse V, h (n, 6)."""
        m = self.products.shape[1] - 7
        total = self.products.sum(axis=0)
        U, g = total[:m, :m] + np.diag(self.believed[:, 0]), total[:m, -1] + self.believed[:, 1]
        V = self.products[:, m : m + 6, m : m + 6].copy()
        W, h = self.products[:, m : m + 6, :m], self.products[:, m : m + 6, -1]
        if self.by_offset is not None and self.offset_squares is not None:
            assert self.precision is not None
            assert self.offsets is not None
            assert self.basis is not None
            n, c = self.weight.shape
            summed = self.by_offset.sum(axis=0).reshape(3 * c, -1)
            own = np.zeros((c, 3, c, 3))
            each = np.arange(c)
            own[each, :, each, :] = self.offset_squares.sum(axis=0) + np.diag(self.precision)
            N = self.basis
            both = N.T @ summed
            U = np.block([[U, both[:, :m].T], [both[:, :m], N.T @ own.reshape(3 * c, 3 * c) @ N]])
            g = np.concatenate([g, both[:, -1] + N.T @ (self.precision * self.offsets).ravel()])
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


def _moved(p: np.ndarray, shape: BoardShape, step: np.ndarray, free: tuple[str, ...]) -> tuple[np.ndarray, BoardShape]:
    """Parameters and shape after a step of the free ones."""
    k, j = len(free), len(shape.model.free)
    p, values, offsets = p.copy(), shape.values.copy(), shape.offsets
    p[[lens.NAMES.index(name) for name in free]] += step[:k]
    values[[board_shape.NAMES.index(name) for name in shape.model.free]] += step[k : k + j]
    if shape.model.offsets:
        offsets = offsets + step[k + j :].reshape(-1, 3)
    return p, replace(shape, values=values, offsets=offsets)


def _rays(sightings: Sightings, points: np.ndarray, poses: Poses) -> np.ndarray:
    """Corners on the plane z = 1 of the camera frame, shape (n, c, 2); those not seen need no depth."""
    at = points @ poses.R.transpose(0, 2, 1) + poses.t[:, None]
    return at[..., :2] / np.where(sightings.seen, at[..., 2], 1.0)[..., None]


def _residuals(sightings: Sightings, p: np.ndarray, points: np.ndarray, poses: Poses) -> np.ndarray:
    """Predicted less seen, shape (n, c, 2), px; infinite in views with a corner behind the camera, zero where not seen."""
    at = points @ poses.R.transpose(0, 2, 1) + poses.t[:, None]
    depth = np.where(sightings.seen, at[..., 2], 1.0)
    behind = np.any(depth <= 0, axis=1)
    depth = np.where(behind[:, None], 1.0, depth)
    residuals = lens.distort(at[..., :2] / depth[..., None], p) - sightings.pixels
    residuals[behind] = np.inf
    residuals[~sightings.seen] = 0.0
    return residuals


def _by_point_and_pose(
    sightings: Sightings, p: np.ndarray, points: np.ndarray, poses: Poses
) -> tuple[np.ndarray, np.ndarray]:
    """Of the pixels, by the point in the camera frame, (n, c, 2, 3), and by the pose (rotation, then t), (n, c, 2, 6)."""
    turned = points @ poses.R.transpose(0, 2, 1)
    at = turned + poses.t[:, None]
    depth = np.where(sightings.seen, at[..., 2], 1.0)
    rays = at[..., :2] / depth[..., None]
    by_ray = lens.ray_jacobian(rays, p) / depth[..., None, None]
    by_pose = np.empty((*depth.shape, 2, 6))
    by_point = by_pose[..., 3:]
    by_point[..., :2] = by_ray
    by_point[..., 2] = -(by_ray[..., 0] * rays[..., None, 0] + by_ray[..., 1] * rays[..., None, 1])
    # d(exp(w) q)/dw at w = 0 is -[q]x, so the row g of by_point gives (q x g)
    x, y, z = (turned[..., None, i] for i in range(3))
    by_pose[..., 0] = y * by_point[..., 2] - z * by_point[..., 1]
    by_pose[..., 1] = z * by_point[..., 0] - x * by_point[..., 2]
    by_pose[..., 2] = x * by_point[..., 1] - y * by_point[..., 0]
    return by_point, by_pose
