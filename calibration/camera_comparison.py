"""The change of a camera between a calibration and new pictures, with its uncertainty, tested kind by kind."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.stats import f as fisher

from calibration import lens
from calibration.bundle_adjustment import BundleFit
from calibration.camera import Camera, camera_from
from calibration.corner_detection import BoardView
from calibration.projection_uncertainty import board_information, rays_by_rotation

CHANGE_KINDS = ("focal length", "principal point", "aspect", "distortion")
"""changes that happen to cameras"""
_NAMED_SHARE = 0.1
"""share of the change that the named kinds may leave unexplained (docs/thresholds.md)"""
_NAMED_PROBABILITY = 0.01
"""probability of the unexplained change by chance, above which the kinds named are enough (docs/thresholds.md)"""


@dataclass(frozen=True)
class CameraComparison:
    """The change of the free parameters with its weight (inverse covariance), with which kinds of change are tested alone."""

    camera: Camera
    free: tuple[str, ...]
    change: np.ndarray  # shape (m,)
    weight: np.ndarray  # shape (m, m)
    freedom: float  # degrees of freedom of the weight's scale

    def directions(self, kinds: Sequence[str]) -> np.ndarray:
        """Columns that span the changes of the given kinds, shape (m, r)."""
        p = dict(zip(lens.PARAMETER_NAMES, self.camera.parameters.tolist(), strict=True))
        columns: list[dict[str, float]] = []
        if "focal length" in kinds:
            columns.append({"fx": p["fx"], "fy": p["fy"]})
        if "aspect" in kinds:
            columns.append({"fx": p["fx"], "fy": -p["fy"]})
        if "principal point" in kinds:
            columns += [{"cx": 1.0}, {"cy": 1.0}]
        if "distortion" in kinds:
            columns += [{name: 1.0} for name in ("k1", "k2", "p1", "p2", "k3")]
        spanning = np.array([[column.get(name, 0.0) for column in columns] for name in self.free])
        return spanning[:, np.any(spanning != 0, axis=0)]

    def alone(self, kinds: Sequence[str]) -> tuple[np.ndarray, float]:
        """The change if only the given kinds happened, shape (m,), and the squared distance that it explains."""
        D = self.directions(kinds)
        right = D.T @ self.weight @ self.change
        size = np.linalg.lstsq(D.T @ self.weight @ D, right, rcond=1e-15)[0] if D.size else np.zeros(0)
        return D @ size, float(right @ size)

    def probability(self, kinds: Sequence[str]) -> float:
        """Probability of so large a change of the given kinds where nothing changed."""
        rank = self.directions(kinds).shape[1]
        return float(fisher.sf(self.alone(kinds)[1] / rank, rank, self.freedom)) if rank else 1.0

    def significance(self) -> float:
        """Probability of so large a change where nothing changed; each kind is tested alone, and all together."""
        tests = (*((kind,) for kind in CHANGE_KINDS), CHANGE_KINDS)
        # one of five tests may be the most extreme by chance
        return min(1.0, len(tests) * min(self.probability(kinds) for kinds in tests))

    @property
    def focal_sigma(self) -> float:
        """Standard deviation of a change of the focal length alone, as a share of it; infinite where it was not estimated."""
        D = self.directions(("focal length",))
        return float((D.T @ self.weight @ D)[0, 0] ** -0.5) if D.size else float("inf")

    def named(self) -> tuple[str, ...]:
        """The fewest kinds of change that leave nothing significant unexplained, or less than a tenth."""
        whole = self.alone(CHANGE_KINDS)[1]
        for count in range(1, len(CHANGE_KINDS)):
            best = max(combinations(CHANGE_KINDS, count), key=lambda kinds: self.alone(kinds)[1])
            unexplained = whole - self.alone(best)[1]
            rest = len(self.free) - self.directions(best).shape[1]
            if (
                unexplained < _NAMED_SHARE * whole
                or fisher.sf(unexplained / rest, rest, self.freedom) > _NAMED_PROBABILITY
            ):
                return best
        return CHANGE_KINDS


def compare_cameras(
    camera: Camera, views: Sequence[BoardView], fit: BundleFit, free: Sequence[str]
) -> CameraComparison:
    """The change from `camera` to the optimum that lies one linear step from `fit`, and its weight.

    Let S_i and g_i be the normal matrix and the gradient of view i at the optimum, its pose eliminated; the gradients add up
    to zero. For independent corner errors of variance s2 the expected sum of g_i' S^-1 g_i is s2 sum tr(S^-1 S_i - (S^-1 S_i)^2).
    Errors that a view's corners have in common make it larger; the covariance s2 S^-1 grows by the same factor, at least 1.
    """
    columns = np.array([lens.PARAMETER_NAMES.index(name) for name in free])
    at = np.ix_(columns, columns)
    old = np.zeros((9, 9)) if camera.covariance is None else camera.covariance
    fitted = camera_from(fit.parameters, camera.size)
    normals, gradients, squares, count = [], [], 0.0, 0
    for view, R, t in zip(views, fit.poses.R, fit.poses.t, strict=True):
        points = view.object_points @ R.T + t
        rays = points[:, :2] / points[:, 2:]
        residuals = (lens.rays_to_pixels(rays, fit.parameters) - view.image_points).ravel()
        # the pose is at its optimum: the residuals are already free of what it absorbs
        A = lens.parameter_jacobian(rays, fit.parameters).reshape(-1, 9)
        normals.append(board_information(fitted, points)[at])
        gradients.append((A.T @ residuals)[columns])
        squares, count = squares + float(residuals @ residuals), count + len(residuals)
    scale = np.sqrt(np.diag(sum(normals)))  # k and f differ by orders of magnitude
    scaled = [normal / np.outer(scale, scale) for normal in normals]
    inverse = np.linalg.inv(sum(scaled))
    gradient = sum(gradients) / scale
    step = -inverse @ gradient
    slopes = [g / scale + normal @ step for g, normal in zip(gradients, scaled, strict=True)]
    variance = (squares - float(gradient @ inverse @ gradient)) / max(count - 6 * len(views) - len(columns), 1)
    shares = [inverse @ normal for normal in scaled]
    expected = variance * sum(float(np.trace(share - share @ share)) for share in shares)
    inflation = max(1.0, sum(float(g @ inverse @ g) for g in slopes) / expected)
    change = (fit.parameters - camera.parameters)[columns] + step / scale
    covariance = variance * inflation * inverse / np.outer(scale, scale) + old[at]
    if not np.all(np.diag(covariance) > 0):
        raise np.linalg.LinAlgError
    size = np.sqrt(np.diag(covariance))
    weight = np.linalg.inv(covariance / np.outer(size, size)) / np.outer(size, size)
    freedom = max((len(views) - 1) * len(columns) / 2, 1.0)
    return CameraComparison(camera=camera, free=tuple(free), change=change, weight=weight, freedom=freedom)


def direction_difference(camera: Camera, parameters: np.ndarray) -> tuple[float, float]:
    """How far directions differ between two cameras over the picture, the orientation refitted: rms, px and rad."""
    u, v = (np.linspace(0, side - 1, count) for side, count in zip(camera.size, (16, 12), strict=True))
    rays = camera.rays(np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2))
    rays = rays[np.all(np.isfinite(rays), axis=1)]
    B = (lens.ray_jacobian(rays, camera.parameters) @ rays_by_rotation(rays)).reshape(-1, 3)
    shift = (lens.rays_to_pixels(rays, parameters) - lens.rays_to_pixels(rays, camera.parameters)).ravel()
    residual = shift - B @ np.linalg.lstsq(B, shift, rcond=None)[0]
    px = float(np.sqrt(np.mean(residual**2) * 2))
    return px, px / float(np.mean(camera.parameters[:2]))
