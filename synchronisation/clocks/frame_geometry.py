"""What the cables make of the camera's frames: how far each is wound in, how errors of angles and of the drawing enter there."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mechanism.arm import Arm
from mechanism.cable_lengths import Z, lengths
from mechanism.drawing_errors import ANGLE_ZERO_SIGMA_RAD, MAX_DRAWING_ERROR
from synchronisation.error_sizes import likelier_sizes

Array = NDArray[np.float64]

DIMENSIONS = ("L", "b", "r")
"""dimensions of each mechanism that a description may have slightly wrong"""
GEOMETRY_STEP = 1e-3
"""relative, rad of an angle: the change of a number whose effect gives its slope"""
MIN_CABLE_ERROR_M = 2e-6
"""m: a law of the cables is never believed to be better than this"""
MIN_NOISE_SCALE = 0.1
"""ratio: angles are never believed to be more than ten times better than their sigma"""
_FRAMES_OF_ERRORS, _ERROR_STEPS = 500, 8
"""frames, spread over all, by which errors are told, and steps of that: they go on from fit to fit"""
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
    correlation: Array
    """(N, N), of the noise of alpha"""
    winding: Array
    """(F, M), m: -(l(alpha) - l(0)), what rigid cables would have been wound in"""
    Z: Array
    """(F, N, M), m/rad"""
    winding_by_geometry: Array
    """(F, M, P), m: slope of the winding by each number of the geometry, in the order of `changed_geometries`"""
    middle: float
    """s, camera clock: the time at which a clock's offset holds"""

    def with_geometry_errors(self, errors: Array) -> "FrameGeometry":
        """The same frames of an arm whose geometry is larger than described by `errors` (P,)."""
        return replace(self, winding=self.winding + self.winding_by_geometry @ errors)

    def turns(self, residual: Array, cable_error: Array) -> Array:
        """Turns of the joints (F, N), rad, that explain residuals (F, M), m, best; cable_error: (M,), m, of the cables' laws."""
        return turns_of(self.Z, residual, cable_error)

    def with_slopes_beside_noise(self, arm: Arm, residual: Array, cable_error: Array) -> "FrameGeometry":
        """The same frames, with slopes by the geometry at the angles that residuals (F, M), m, of the cables tell.

        At angles as they were read the slopes hold the noise that the residuals hold too, and least squares shrink the arm: a
        smaller one makes less of the noise."""
        return replace(
            self, winding_by_geometry=_winding_by_geometry(arm, self.alpha + self.turns(residual, cable_error))
        )

    def part(self, kept: NDArray[np.bool_] | NDArray[np.intp] | slice) -> "FrameGeometry":
        """Some of the frames, with the same middle."""
        return FrameGeometry(
            time=self.time[kept],
            alpha=self.alpha[kept],
            sigma=self.sigma[kept],
            correlation=self.correlation,
            winding=self.winding[kept],
            Z=self.Z[kept],
            winding_by_geometry=self.winding_by_geometry[kept],
            middle=self.middle,
        )

    def whitening(self, cable_error: float | Array, noise_scale: float = 1.0) -> Array:
        """Matrices (F, M, M) that make a frame's residuals independent and of unit variance.

        cable_error: m, of the cables' laws, one, (M,) or (F, M); noise_scale: true over stated noise of the angles."""
        cables, by_noise = self.Z.shape[2], noise_scale * self._by_noise
        covariance = by_noise @ np.swapaxes(by_noise, 1, 2)
        covariance += np.square(cable_error)[..., None] * np.eye(cables)
        return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)), dtype=float)

    def error_sizes(self, residual: Array, cable_error: Array, noise_scale: float) -> tuple[Array, float]:
        """Errors of the cables' laws, (M,), m, and true over stated noise of the angles, from residuals (F, M), m, and a guess.

        One cable whose law is wrong leaves more than others, and angles' noise is common to all. With no more cables than joints
        angles explain all."""
        spread = slice(None, None, -(-len(residual) // _FRAMES_OF_ERRORS))
        by_noise, r, (joints, cables) = self._by_noise[spread], residual[spread], self.Z.shape[1:]
        of_noise = np.zeros(joints, dtype=np.intp)
        guess, least = np.array([noise_scale]), np.array([MIN_NOISE_SCALE])
        if cables <= joints:
            known = MIN_CABLE_ERROR_M**2 * np.eye(cables)
            size = likelier_sizes(r, by_noise, of_noise, guess, least, _ERROR_STEPS, known)
            return np.full(cables, MIN_CABLE_ERROR_M), float(size[0])
        factors = np.concatenate([by_noise, np.broadcast_to(np.eye(cables), (len(r), cables, cables))], axis=2)
        source = np.concatenate([of_noise, 1 + np.arange(cables)])
        guess, least = np.append(guess, cable_error), np.append(least, np.full(cables, MIN_CABLE_ERROR_M))
        size = likelier_sizes(r, factors, source, guess, least, _ERROR_STEPS)
        return size[1:], float(size[0])

    @cached_property
    def noise_factor(self) -> Array:
        """What makes noise of the angles (F, N), rad, of independent noise of unit variance: (F, N, N)."""
        return np.asarray(self.sigma[:, :, None] * np.linalg.cholesky(self.correlation), dtype=float)

    @cached_property
    def _by_noise(self) -> Array:
        """The same of the cables, m: (F, M, N)."""
        return np.swapaxes(self.Z, 1, 2) @ self.noise_factor

    def unexplained_rms(self, residual: Array) -> float:
        """RMS of what of residuals (F, M), m, no angles explain, m, for as many cables as there are beyond joints."""
        joints, cables = self.Z.shape[1:]
        left = residual - np.einsum("fij,fi->fj", self.Z, self.turns(residual, np.ones(cables)))
        return max(float(np.sqrt(np.mean(np.sum(left**2, axis=1)) / (cables - joints))), MIN_CABLE_ERROR_M)


def frame_geometry(
    arm: Arm, time: Array, alpha: Array, sigma: Array, middle: float, correlation: Array | None = None
) -> FrameGeometry:
    """The geometry of frames at time (F,), s, with alpha and its sigma (F, N), rad, all known; middle: s, camera clock.

    correlation: (N, N), of the noise of alpha; independent unless given."""
    jacobian = Z(arm, alpha)
    return FrameGeometry(
        time=time,
        alpha=alpha,
        sigma=sigma,
        correlation=np.eye(arm.N) if correlation is None else correlation,
        winding=cable_winding(arm, alpha),
        Z=jacobian,
        winding_by_geometry=_winding_by_geometry(arm, alpha),
        middle=middle,
    )


def turns_of(jacobian: Array, residual: Array, cable_error: Array) -> Array:
    """Turns (F, N), rad, that explain residuals (F, M), m, best, by levers (F, N, M); cable_error: (M,), m, of the cables' laws.

    A cable that errs by much tells little."""
    weight = np.min(cable_error) / cable_error
    weighted = weight * jacobian
    square = weighted @ np.swapaxes(weighted, 1, 2)
    square += _RIDGE * np.trace(square, axis1=1, axis2=2)[:, None, None] * np.eye(square.shape[1])
    pull = np.einsum("fij,fj->fi", weighted, weight * residual)
    return np.asarray(np.linalg.solve(square, pull[..., None])[..., 0], dtype=float)


def _winding_by_geometry(arm: Arm, alpha: Array) -> Array:
    described = cable_winding(arm, alpha)
    changes = [cable_winding(other.arm, alpha + other.turn) - described for other in changed_geometries(arm)]
    return np.stack(changes, axis=-1) / GEOMETRY_STEP


def of_pulleys(numbers: slice) -> slice:
    """Which of the numbers of a geometry, which stand at a slice of a vector, are the pulleys' radii."""
    count = _joints(numbers)
    first = numbers.start + DIMENSIONS.index("r") * count
    return slice(first, first + count)


def cable_winding(arm: Arm, alpha: Array) -> Array:
    """-(l(alpha) - l(0)), (..., M), m, at angles (..., N), rad: what rigid cables have been wound in since the straight pose."""
    return lengths(arm, np.zeros(arm.N)) - lengths(arm, alpha)


@dataclass(frozen=True)
class ChangedGeometry:
    """What the cables go by where one number is larger than described by GEOMETRY_STEP."""

    arm: Arm
    turn: Array
    """(N,), rad, to be added to the angles as they were read"""


def changed_geometries(arm: Arm) -> list[ChangedGeometry]:
    """One for each number (P,): L, b and r of the mechanisms, relative, then the zeros of the angles, rad."""
    each = GEOMETRY_STEP * np.eye(arm.N)
    enlarged = [replace(arm, **{name: getattr(arm, name) * (1 + one)}) for name in DIMENSIONS for one in each]
    return [ChangedGeometry(other, np.zeros(arm.N)) for other in enlarged] + [ChangedGeometry(arm, one) for one in each]


def geometry_sigma(numbers: slice) -> Array:
    """Standard deviations (P,) of these numbers, which stand at a slice of a vector, about what is described."""
    count = _joints(numbers)
    return np.repeat([MAX_DRAWING_ERROR, ANGLE_ZERO_SIGMA_RAD], [len(DIMENSIONS) * count, count])


def _joints(numbers: slice) -> int:
    """Of how many joints the numbers of a geometry are, which stand at a slice of a vector."""
    return (numbers.stop - numbers.start) // (len(DIMENSIONS) + 1)
