"""The covariance of the state: of noise and priors, of the cables' nuisances, and of errors that all frames share."""

import numpy as np
from numpy.typing import NDArray

from identification.dataset.frames import FrameAngles
from identification.elongation_errors import NUISANCE_VARIANCE_RATIO
from state_estimation.banded import inverse_windows
from state_estimation.fusion import SplineSolution
from state_estimation.motion_prior import PARTS
from state_estimation.spline import SUPPORT

Array = NDArray[np.float64]


def state_covariance(
    solution: SplineSolution, frames: FrameAngles, at: Array, clock_sigma: tuple[float, float]
) -> Array:
    """Covariance (K, 3 N, 3 N) of alpha, alpha', alpha'' at times `at` (K,), s.

    clock_sigma: of the offset (s) and of the skew (ratio, about the middle of the frames).
    """
    n, knots = len(solution.mean), solution.knots
    first, _ = knots.rows(at)
    weights = np.stack([knots.rows(at, d)[1] for d in range(3)], axis=1)
    local = first[:, None] + np.arange(SUPPORT)
    shared = _response_to_shared_errors(solution, frames, clock_sigma)
    # shifts of the coefficients by unit errors, and the covariance of these: of the nuisances, and of shared errors
    shifts_and_covariances = [
        (solution.H.solve_second_half(solution.W), NUISANCE_VARIANCE_RATIO * np.linalg.inv(solution.schur)),
        (shared, np.eye(shared.shape[1])),
    ]
    shifts_and_covariances = [
        (shift.reshape(knots.count, n, PARTS, -1).sum(axis=2), C) for shift, C in shifts_and_covariances
    ]
    per_knot, covariance, diagonal = PARTS * n, np.empty((len(at), 3 * n, 3 * n)), np.arange(3 * n)
    windows = inverse_windows(solution.H, len(solution.H.lower), first * per_knot, SUPPORT * per_knot, PARTS)
    for rows, window in windows:
        to_state = np.einsum("tdk,ij->tdikj", weights[rows], np.eye(n)).reshape(-1, 3 * n, SUPPORT * n)
        part = to_state @ window @ np.swapaxes(to_state, 1, 2)
        part[:, diagonal, diagonal] += solution.unresolved.ravel()
        for shift, C in shifts_and_covariances:
            state_shift = np.einsum("tdk,tkiq->tdiq", weights[rows], shift[local[rows]]).reshape(len(part), 3 * n, -1)
            part += state_shift @ C @ np.swapaxes(state_shift, 1, 2)
        covariance[rows] = part
    return covariance


def _response_to_shared_errors(
    solution: SplineSolution, frames: FrameAngles, clock_sigma: tuple[float, float]
) -> Array:
    """Change of the coefficients by one sigma of each error that all frames share: clock offset, skew, each joint's; (n, 2 + N)."""
    joints = range(len(solution.mean))
    speed = solution.alpha(frames.time, 1)
    age = (frames.time - (frames.time[0] + frames.time[-1]) / 2)[:, None]
    errors = [clock_sigma[0] * speed, clock_sigma[1] * age * speed]
    errors += [frames.common * (np.arange(len(joints)) == i) for i in joints]
    design = solution.knots.design(frames.time)
    right = [design.T @ np.nan_to_num(np.where(np.isnan(frames.alpha), 0.0, e) / frames.sigma**2) for e in errors]
    return solution.response(np.stack([np.repeat(r.ravel(), PARTS) for r in right], axis=-1))
