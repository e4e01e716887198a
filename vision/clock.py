"""One clock: log time = camera time + offset + skew (camera time - its middle).

What vision predicts of each cable's winding, w_j = -(l_j(alpha) - l_j(0)), is held against (rd/R) theta_j. They differ by
the cable's elongation, which the motor force explains: (rd/R) theta = w + c0 + c1 n + c2 n^2 + h dry(theta'), with
n = f - Ia (R/rd) theta''. Offset, skew and these nuisances are fitted together; without them elasticity and friction pull
the clock by milliseconds. Every signal passes the same low-pass.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.signal import butter, correlate, sosfiltfilt

from identification.series import Series
from mechanism.arm import Arm
from mechanism.cable_lengths import lengths
from mechanism.friction import dry
from vision.angles import Angles
from xneck.errors import Refused
from xneck.estimate import nonlinear

Array = NDArray[np.float64]

CUTOFF = 8.0
"""Hz: the low-pass that every signal passes"""
GRID = 100.0
"""Hz: the common rate of the comparison"""
EDGE = 0.75
"""s left out at both ends, where filters settle"""
BLOCK = 1.0
"""s: residuals are taken as independent from block to block only"""
_UNIT, _SKEW = 1e-4, 1e-4
"""m and ratio: bring residuals and skew to the size of one"""
MIN_OVERLAP = 5.0
"""s"""
LADDER = (("constant", "tension", "friction"), ("constant", "tension", "stiffening", "friction"))
"""nuisance models; the last is the one reported, the spread over all enters its sigma. Without friction the clock would be
wrong by 50 ms on the sample, so no rung leaves it out"""


@dataclass(frozen=True)
class Clock:
    """Camera to log: offset in s at the middle of the camera's time, skew as a ratio, with their sigmas."""

    offset: float
    offset_sigma: float
    skew: float
    skew_sigma: float
    middle: float
    """camera time at which the offset holds, s"""
    likeness: float
    """correlation of predicted and logged cable speeds at the coarse match"""
    second: float
    """the next best match's correlation over the best one's"""
    residual: Array
    """RMS of the fit of each cable, (M,), m"""

    def log_time(self, camera_time: Array) -> Array:
        """Camera times on the log's clock, s."""
        return camera_time + self.offset + self.skew * (camera_time - self.middle)


def fit_clock(arm: Arm, angles: Angles, log: Series) -> Clock:
    """Offset and skew from angles (camera clock) and a log of equal steps.

    Raises Refused where the two do not show the same motion, show too little of it, repeat so that a period could be
    mistaken, or where cables or signs are swapped.
    """
    good = angles.complete
    time, alpha = angles.time[good], angles.alpha[good]
    if len(time) < 30:
        raise Refused(
            "sync", f"only {len(time)} frames have all angles", "check the overlay for what hides the markers"
        )
    winding = -(lengths(arm, alpha) - lengths(arm, np.zeros(arm.N)))
    camera_grid = np.arange(time[0], time[-1], 1 / GRID)
    seen = np.stack([np.interp(camera_grid, time, column) for column in winding.T], axis=-1)
    moved = np.ptp(seen, axis=0)
    if moved.max() < 1e-3:
        raise Refused(
            "sync", f"the cables move by {1e3 * moved.max():.2f} mm only", "record a motion of at least 10 deg"
        )
    travel = arm.drum * log.matrix("theta")
    if np.ptp(travel, axis=0).max() < 1e-3:
        raise Refused("sync", "the motors of the log stand still", "is it the log of this recording?")
    log_grid = np.arange(log.time[0], log.time[-1], 1 / GRID)
    logged = np.stack([np.interp(log_grid, log.time, column) for column in travel.T], axis=-1)
    coarse, likeness, second = _coarse(camera_grid, seen, log_grid, logged)
    if second > 0.9:
        raise Refused(
            "sync",
            f"the motion repeats itself: another shift fits {100 * second:.0f} % as well",
            "record a motion that is not periodic",
        )
    return _fine(arm, time, winding, log, coarse, likeness, second)


def _coarse(camera_grid: Array, seen: Array, log_grid: Array, logged: Array) -> tuple[float, float, float]:
    """Shift in s, its correlation, and the next best peak's share of it, from the cables' speeds."""
    a, b = (np.diff(_low_pass(part, GRID), axis=0) for part in (seen, logged))
    least = int(min(MIN_OVERLAP, 0.5 * len(a) / GRID) * GRID)
    if min(len(a), len(b)) < 2 * GRID:
        raise Refused("sync", "video or log is shorter than 2 s", "record longer")

    def match(p: Array, q: Array) -> Array:
        """Normalised correlation of two sets of speeds over all lags of q against p."""
        dot = sum(correlate(q[:, j], p[:, j]) for j in range(p.shape[1]))
        ones = np.ones(len(p)), np.ones(len(q))
        energy_p = correlate(ones[1], np.sum(p**2, axis=1))
        energy_q = correlate(np.sum(q**2, axis=1), ones[0])
        overlap = np.rint(correlate(ones[1], ones[0]))
        share = energy_p / np.sum(p**2)
        out = dot / np.sqrt(np.maximum(energy_p * energy_q, 1e-300))
        out[(overlap < least) | (share < 0.2)] = 0.0
        return out

    both = match(a, b)
    lags = np.arange(len(both)) - (len(a) - 1)
    best = int(np.argmax(both))
    own = np.array([match(a[:, [j]], b[:, [j]]).max() for j in range(a.shape[1])])
    if both[best] < 0.8:
        _name_swaps(a, b, match)
    moving = np.ptp(seen, axis=0) > 2e-3
    for j in np.flatnonzero(moving & (own < 0.6)):
        if np.median(own[moving]) > 0.8:
            raise Refused(
                "sync",
                f"cable {j + 1} does not follow its motor (correlation {own[j]:.2f}, the others' {np.median(own):.2f})",
                f"check theta{j + 1} in the log (is it f{j + 1}?), its theta_sign and its route in neck.yaml",
            )
    if both[best] < 0.8:
        raise Refused(
            "sync",
            f"log and video do not show the same motion (best correlation of cable speeds {both[best]:.2f})",
            f"are they of the same recording, and do they overlap by at least {MIN_OVERLAP:.0f} s?",
        )
    away = np.abs(lags - lags[best]) > 0.25 * GRID
    rising = np.r_[False, (both[1:-1] > both[:-2]) & (both[1:-1] >= both[2:]), False]
    second = float(np.max(both, where=away & rising, initial=0.0) / both[best])
    left, mid, right = both[best - 1 : best + 2] if 0 < best < len(both) - 1 else (0, 1, 0)
    part = 0.5 * (left - right) / (left - 2 * mid + right)
    shift = log_grid[0] - camera_grid[0] + (lags[best] + part) / GRID
    return float(shift), float(both[best]), second


def _name_swaps(a: Array, b: Array, match) -> None:  # type: ignore[no-untyped-def]
    """Refused with the words for it where one change of signs or columns makes the motions agree."""
    m = a.shape[1]
    for j in range(m):
        turned = b.copy()
        turned[:, j] *= -1
        if match(a, turned).max() > 0.9:
            raise Refused(
                "sync", f"theta{j + 1} runs against the camera", f"set motors[{j}].theta_sign to its opposite"
            )
    if match(a, -b).max() > 0.9:
        raise Refused(
            "sync", "all theta run against the camera", "turn theta_sign of every motor, or the image is mirrored"
        )
    for i in range(m):
        for j in range(i):
            order = list(range(m))
            order[i], order[j] = j, i
            if match(a, b[:, order]).max() > 0.9:
                raise Refused(
                    "sync",
                    f"theta{j + 1} and theta{i + 1} are swapped",
                    "correct the log's columns or the cables' order",
                )


def _fine(arm: Arm, time: Array, winding: Array, log: Series, coarse: float, likeness: float, second: float) -> Clock:
    rate = 1 / float(np.mean(np.diff(log.time)))
    theta = log.matrix("theta")
    smooth = _low_pass(theta, rate)
    theta_d = np.gradient(_low_pass(theta, rate, 40.0), 1 / rate, axis=0)
    theta_dd = np.gradient(smooth, 1 / rate, axis=0)
    theta_dd = np.gradient(theta_dd, 1 / rate, axis=0)
    n = _low_pass(log.matrix("f"), rate) - arm.motor_inertia / arm.drum * theta_dd
    parts = {
        "travel": arm.drum * smooth,
        "constant": np.ones_like(n),
        "tension": n / 50.0,
        "stiffening": (n / 50.0) ** 2,
        "friction": _low_pass(dry(theta_d), rate),
    }
    curves = {name: CubicSpline(log.time, values) for name, values in parts.items()}
    # vision at the frames' own rate, bridged by a spline over frames that are missing
    grid = np.arange(time[0] + EDGE, time[-1] - EDGE, 1 / 30.0)
    fine = np.arange(time[0], time[-1], 1 / GRID)
    seen = CubicSpline(fine, _low_pass(CubicSpline(time, winding)(fine), GRID))(grid)
    after = np.clip(np.searchsorted(time, grid), 1, len(time) - 1)
    bridged = time[after] - time[after - 1] > 0.2
    grid, seen = grid[~bridged], seen[~bridged]
    inside = (grid + coarse > log.time[0] + EDGE) & (grid + coarse < log.time[-1] - EDGE)
    grid, seen = grid[inside], seen[inside]
    if len(grid) < MIN_OVERLAP * 30:
        raise Refused(
            "sync", f"log and video overlap by {len(grid) / 30:.1f} s", f"record at least {MIN_OVERLAP:.0f} s of both"
        )
    middle = float(grid[0] + grid[-1]) / 2
    cables = seen.shape[1]

    def fit(words: tuple[str, ...]) -> tuple[Array, Array, Array]:
        """(offset, skew, nuisances), their block-robust covariance, residuals (T, M) in m."""

        def model(v: Array, order: int) -> Array:
            """travel - seen - nuisance in units of _UNIT, or its slope in time (order 1), (T, M)."""
            at = np.clip(grid + v[0] + v[1] * _SKEW * (grid - middle), log.time[0], log.time[-1])
            nuisance = sum(v[2 + k * cables : 2 + (k + 1) * cables] * curves[w](at, order) for k, w in enumerate(words))
            return (curves["travel"](at, order) - (seen if order == 0 else 0.0) - nuisance) / _UNIT

        def jacobian(v: Array) -> Array:
            at = np.clip(grid + v[0] + v[1] * _SKEW * (grid - middle), log.time[0], log.time[-1])
            slope = model(v, 1)
            J = np.zeros((*slope.shape, len(v)))
            J[..., 0], J[..., 1] = slope, slope * (_SKEW * (grid - middle))[:, None]
            for k, word in enumerate(words):
                for j in range(cables):
                    J[:, j, 2 + k * cables + j] = -curves[word](at)[:, j] / _UNIT
            return J.reshape(-1, len(v))

        start = np.zeros(2 + len(words) * cables)
        start[0] = coarse
        estimate = nonlinear(lambda v: model(v, 0).ravel(), start, jacobian=jacobian, scale="jac")
        covariance = _block_covariance(jacobian(estimate.value), estimate.residuals, grid, cables)
        return estimate.value, covariance, _UNIT * estimate.residuals.reshape(-1, cables)

    fits = [fit(words) for words in LADDER]
    value, covariance, left = fits[-1]
    spread = np.std([v[:2] for v, _, _ in fits], axis=0)
    sigma_both = np.sqrt(np.diag(covariance)[:2] + spread**2)
    return Clock(
        offset=float(value[0]),
        offset_sigma=float(sigma_both[0]),
        skew=float(value[1] * _SKEW),
        skew_sigma=float(sigma_both[1] * _SKEW),
        middle=middle,
        likeness=likeness,
        second=second,
        residual=np.sqrt(np.mean(left**2, axis=0)),
    )


def _block_covariance(J: Array, r: Array, grid: Array, cables: int) -> Array:
    """Sandwich covariance with residuals free to be correlated within blocks of BLOCK seconds and between cables."""
    bread = np.linalg.pinv(J.T @ J)
    block = np.repeat(((grid - grid[0]) // BLOCK).astype(int), cables)
    scores = np.zeros((block.max() + 1, J.shape[1]))
    np.add.at(scores, block, J * r[:, None])
    blocks = len(scores)
    return bread @ (scores.T @ scores) @ bread * blocks / max(blocks - 1, 1)


def _low_pass(values: Array, rate: float, cutoff: float = CUTOFF) -> Array:
    sos = butter(4, min(cutoff / (rate / 2), 0.95), output="sos")
    return sosfiltfilt(sos, values, axis=0, padlen=min(len(values) - 1, int(rate)))
