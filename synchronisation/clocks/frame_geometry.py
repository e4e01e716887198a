"""What the cables make of the camera's frames: how far each is wound in, and how errors of angles and dimensions enter there."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mechanism.arm import Arm
from mechanism.cable_lengths import Z, lengths

Array = NDArray[np.float64]

DIMENSIONS = ("L", "b", "r")
"""dimensions of each mechanism that a description may have slightly wrong"""
DIMENSION_STEP = 1e-3
"""relative: the change of a dimension whose effect gives its slope"""
MIN_CABLE_ERROR_M = 2e-6
"""m: a law of the cables is never believed to be better than this"""
MIN_NOISE_SCALE = 0.1
"""ratio: angles are never believed to be more than ten times better than their sigma"""
_RIDGE = 1e-9
"""relative: with more joints than cables some turn moves no cable; the ridge keeps it at zero"""


@dataclass(frozen=True)
class FrameGeometry:
    """Frames in which all angles are known, and what the cables make of them."""

    time: Array
    """(F,), s, camera clock"""
    alpha: Array
    """(F, N), rad"""
    sigma: Array
    """(F, N), rad: standard deviation of alpha"""
    winding: Array
    """(F, M), m: -(l(alpha) - l(0)), what rigid cables would have been wound in"""
    Z: Array
    """(F, N, M), m/rad"""
    pseudo_inverse: Array
    """(F, N, M), rad/m: turns of the joints that explain changes of the windings best"""
    turn_variance: Array
    """(F, N), rad^2/m^2: variance of these turns for changes of unit variance"""
    winding_by_dimension: Array
    """(F, M, P), m: slope of the winding by the relative error of each dimension"""
    middle: float
    """s, camera clock: the time at which a clock's offset holds"""

    def with_dimensions(self, errors: Array) -> "FrameGeometry":
        """The same frames of an arm whose dimensions are larger than described by `errors` (P,), relative."""
        return replace(self, winding=self.winding + self.winding_by_dimension @ errors)

    def part(self, kept: NDArray[np.bool_] | NDArray[np.intp] | slice) -> "FrameGeometry":
        """Some of the frames, with the same middle."""
        return FrameGeometry(
            time=self.time[kept],
            alpha=self.alpha[kept],
            sigma=self.sigma[kept],
            winding=self.winding[kept],
            Z=self.Z[kept],
            pseudo_inverse=self.pseudo_inverse[kept],
            turn_variance=self.turn_variance[kept],
            winding_by_dimension=self.winding_by_dimension[kept],
            middle=self.middle,
        )

    def whitening(self, cable_error: float, noise_scale: float = 1.0) -> Array:
        """Matrices (F, M, M) that make a frame's residuals independent and of unit variance.

        cable_error: m, of the cables' law; noise_scale: true over stated noise of the angles."""
        cables = self.Z.shape[2]
        covariance = np.einsum("fij,fi,fik->fjk", self.Z, (noise_scale * self.sigma) ** 2, self.Z)
        covariance += cable_error**2 * np.eye(cables)
        return np.linalg.inv(np.linalg.cholesky(covariance))

    def error_sizes(self, residual: Array) -> tuple[float, float]:
        """Error of the cables' law, m, and true over stated noise of the angles, from residuals (F, M), m.

        The first is what of the residuals no angles explain, the second what angles do explain."""
        n, m = self.Z.shape[1:]
        turns = np.einsum("fij,fj->fi", self.pseudo_inverse, residual)
        unexplained = residual - np.einsum("fij,fi->fj", self.Z, turns)
        if m <= n:
            cable_error = MIN_CABLE_ERROR_M
        else:
            mean_square = np.mean(np.sum(unexplained**2, axis=1)) / (m - n)
            cable_error = max(float(np.sqrt(mean_square)), MIN_CABLE_ERROR_M)
        by_law = cable_error**2 * self.turn_variance
        mean_ratio = float(np.mean((turns**2 - by_law) / self.sigma**2))
        return cable_error, float(np.sqrt(max(mean_ratio, MIN_NOISE_SCALE**2)))


def frame_geometry(arm: Arm, time: Array, alpha: Array, sigma: Array, middle: float) -> FrameGeometry:
    """The geometry of frames at time (F,), s, with alpha and its sigma (F, N), rad, all known; middle: s, camera clock."""
    winding = cable_winding(arm, alpha)
    enlarged = [cable_winding(other, alpha) - winding for other in enlarged_arms(arm)]
    jacobian = Z(arm, alpha)
    square = np.einsum("fij,fkj->fik", jacobian, jacobian)
    inverse = np.linalg.inv(square + _RIDGE * np.trace(square, axis1=1, axis2=2)[:, None, None] * np.eye(arm.N))
    return FrameGeometry(
        time=time,
        alpha=alpha,
        sigma=sigma,
        winding=winding,
        Z=jacobian,
        pseudo_inverse=inverse @ jacobian,
        turn_variance=np.diagonal(inverse, axis1=1, axis2=2),
        winding_by_dimension=np.stack(enlarged, axis=-1) / DIMENSION_STEP,
        middle=middle,
    )


def of_pulleys(dimensions: slice) -> slice:
    """Which of an arm's dimensions, which stand at a slice of a vector, are its pulleys' radii."""
    count = (dimensions.stop - dimensions.start) // len(DIMENSIONS)
    first = dimensions.start + DIMENSIONS.index("r") * count
    return slice(first, first + count)


def cable_winding(arm: Arm, alpha: Array) -> Array:
    """-(l(alpha) - l(0)), (..., M), m, at angles (..., N), rad: what rigid cables have been wound in since the straight pose."""
    return lengths(arm, np.zeros(arm.N)) - lengths(arm, alpha)


def enlarged_arms(arm: Arm) -> list[Arm]:
    """Copies of the arm, each with one of its L, b and r larger by DIMENSION_STEP; in the order of the dimensions (P,)."""
    unit = np.eye(arm.N)
    return [
        replace(arm, **{name: getattr(arm, name) * (1 + DIMENSION_STEP * unit[i])})
        for name in DIMENSIONS
        for i in range(arm.N)
    ]
