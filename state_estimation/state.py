"""The state of the arm at the log's rate: alpha, alpha', alpha'' of all joints with their covariance.

Angles of all joints are one spline (see spline.py). Vision measures them in its frames; cables measure them at the log's rate
where the motor force explains their elongations (see force_law.py). All of it is one banded least squares. Errors that
are common to all frames (clock, camera pose, marker placement) are not estimated: what they would do to it
enters its covariance.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.frames import FrameAngles
from identification.dataset.series import Series
from mechanism.arm import Arm
from mechanism.cable_lengths import Z
from mechanism.elasticity import elongation
from state_estimation.banded import inverse_windows
from state_estimation.cable_equations import CableEquations, Cables, cable_rows
from state_estimation.elongation_error import fit_wander, white
from state_estimation.elongation_law import CUTOFF, law_of
from state_estimation.fusion import FusedSplines, misfit, solve
from state_estimation.motion_prior import DOUBT, PARTS, Mixture, fit_mixture
from state_estimation.motors import Motors
from state_estimation.smoother import WIDTH, check_span
from state_estimation.spline import SUPPORT, knots_over
from state_estimation.variance_components import told_by_both

Array = NDArray[np.float64]

KNOT_S = 1 / 30
"""s between knots: carries motion to about 8 Hz"""
CABLE_HZ = 2 * CUTOFF
"""of the cables' rows: faster ones would show no more of what forces explain than its cutoff"""
COVARIANCE_HZ = 50.0
BRIDGE_S = 0.2
"""rows of a joint that vision missed for longer are marked"""
LESS, TRIES = 1.6, 3
"""factor on the errors of cables that pull, and how often before they are not believed at all"""
_NO_WEIGHT = 1.0
"""m: the error of a cable that is left out"""
USELESS = 3.0
"""a cable whose error is this many times what vision leaves it uncertain is left out"""
WORSE = 0.1
"""cables that pull the angles away from vision by this much more than noise, in its variance, are not believed"""


@dataclass(frozen=True)
class StateEstimate:
    """Angles with two derivatives, each (T, N), their covariance at fewer times, and what they rest on."""

    time: Array
    alpha: Array
    alpha_d: Array
    alpha_dd: Array
    covariance_time: Array
    """(K,), s"""
    covariance: Array
    """(K, 3 N, 3 N): of alpha_1..N, then their first, then their second derivatives"""
    bridged: NDArray[np.bool_]
    """(T, N): vision missed the joint for longer than BRIDGE_S there"""
    notes: dict[str, Any] = field(default_factory=dict)
    """method ("fused" or "vision"), cables used and left out with the reason"""

    @property
    def sigma(self) -> tuple[Array, Array, Array]:
        """Standard deviations of alpha, alpha', alpha'', each (T, N)."""
        every = np.sqrt(np.diagonal(self.covariance, axis1=1, axis2=2))
        flat = np.stack([np.interp(self.time, self.covariance_time, column) for column in every.T], axis=-1)
        one, two, three = np.split(flat, 3, axis=1)
        return one, two, three

    def covariance_series(self, rate: float) -> Series:
        """The covariance's upper triangle at about `rate` Hz, in columns `cov_alpha1_alpha2_d`."""
        step = float(np.median(np.diff(self.covariance_time)))
        rows = slice(None, None, max(1, round(1 / (rate * step))))
        n = self.alpha.shape[1]
        names = [f"alpha{i + 1}{suffix}" for suffix in ("", "_d", "_dd") for i in range(n)]
        pairs = [(a, b) for a in range(3 * n) for b in range(a, 3 * n)]
        columns = {f"cov_{names[a]}_{names[b]}": self.covariance[rows, a, b] for a, b in pairs}
        return Series(self.covariance_time[rows], columns)


def estimate_state(
    arm: Arm,
    seen: FrameAngles,
    motors: Motors,
    at: Array,
    clock_sigma: tuple[float, float] = (0.0, 0.0),
    fuse: bool = True,
) -> StateEstimate:
    """The state at `at` (T,), s, even times of the log within the frames.

    clock_sigma: of the offset (s) and of the skew (ratio, about the middle of the frames). Without `fuse`, and where the cables
    cannot be believed, from vision alone, as the notes say.

    Raises Refused where `at` reaches beyond the frames or they are too few.
    """
    for column in seen.alpha.T:
        check_span(seen.time[~np.isnan(column)], at)
    fit = _seen_alone(seen)
    notes: dict[str, Any] = {"method": "vision"}
    if fuse:
        fused, more = _fused(arm, seen, motors, fit)
        notes |= more
        if fused is not None:
            fit, notes["method"] = fused, "fused"
    every = max(1, round(1 / (COVARIANCE_HZ * float(np.mean(np.diff(at))))))
    rows = np.unique(np.append(np.arange(0, len(at), every), len(at) - 1))
    alpha, alpha_d, alpha_dd = (fit.alpha(at, d) for d in range(3))
    covariance = _covariance(fit, seen, at[rows], clock_sigma)
    return StateEstimate(at, alpha, alpha_d, alpha_dd, at[rows], covariance, _bridged(seen, at), notes)


@dataclass(frozen=True)
class VisionState:
    """Angles with two derivatives by vision alone, (T, N) each, where a joint was bridged, and what motion was expected."""

    alpha: Array
    alpha_d: Array
    alpha_dd: Array
    bridged: NDArray[np.bool_]
    priors: list[Mixture]


def by_vision(seen: FrameAngles, at: Array, priors: list[Mixture] | None = None) -> VisionState:
    """The state at `at` by vision alone, without covariance; with priors of a recording alike that are known already."""
    fit = _seen_alone(seen, priors)
    return VisionState(fit.alpha(at), fit.alpha(at, 1), fit.alpha(at, 2), _bridged(seen, at), fit.priors)


def _seen_alone(seen: FrameAngles, priors: list[Mixture] | None = None) -> FusedSplines:
    """Splines of vision, with the motion that is expected of each joint told by its own angles where it is not given."""
    mean = np.nanmean(seen.alpha, axis=0)
    known = priors or [
        fit_mixture(seen.time[known], a[known] - mean[i], s[known] ** 2, KNOT_S, DOUBT)
        for i, (a, s) in enumerate(zip(seen.alpha.T, seen.sigma.T, strict=True))
        for known in [~np.isnan(a)]
    ]
    return solve(knots_over(seen.time[0], seen.time[-1], KNOT_S), mean, seen, known)


def _fused(
    arm: Arm, seen: FrameAngles, motors: Motors, vision: FusedSplines
) -> tuple[FusedSplines | None, dict[str, Any]]:
    """Vision and cables together, or None, and why."""
    whole = np.isfinite(seen.alpha).all(axis=1) & (seen.time >= motors.time[0]) & (seen.time <= motors.time[-1])
    frames, alpha, sigma = seen.time[whole], seen.alpha[whole], seen.sigma[whole]
    variance = np.einsum("tij,ti->tj", Z(arm, alpha) ** 2, sigma**2)
    theta = np.stack([np.interp(frames, motors.time, column) for column in motors.theta.T], axis=-1)
    x = elongation(arm, alpha, theta)
    law = law_of(arm, motors.time, motors.theta_d, motors.f, frames, x)
    X = law.at(frames)
    step = float(np.mean(np.diff(motors.time)))
    every = max(1, int(1 / (CABLE_HZ * step)))
    wander = [fit_wander(frames, x[:, j], variance[:, j], X[:, j], every * step) for j in range(arm.M)]
    blur = np.sqrt(np.median(variance, axis=0))
    errors = np.sqrt([w.variance for w in wander])
    poor = errors > USELESS * blur
    notes: dict[str, Any] = {
        "cables_left_out": [
            {"cable": int(j) + 1, "why": f"the force leaves {1e6 * errors[j]:.0f} um of its elongation unexplained"}
            for j in np.flatnonzero(poor)
        ]
    }
    if poor.all():
        return None, notes
    wander = [white(_NO_WEIGHT, w.step) if bad else w for w, bad in zip(wander, poor, strict=True)]
    inside = np.flatnonzero((motors.time >= seen.time[0]) & (motors.time <= seen.time[-1]))
    rows = inside[::every]
    cables = Cables(arm, motors.time[rows], arm.drum * motors.theta[rows] + arm.x0, law.at(motors.time[rows]))
    wander, priors = told_by_both(vision, seen, cables, wander, ~poor, vision.priors)

    def rows_near(found: FusedSplines) -> Iterator[CableEquations]:
        return cable_rows(cables, vision.knots, found.alpha(cables.time), vision.mean, wander)

    fit = solve(vision.knots, vision.mean, seen, priors, rows_near(vision))
    fit = solve(vision.knots, vision.mean, seen, priors, rows_near(fit))
    own = misfit(vision, seen)
    excess = misfit(fit, seen) / own - 1
    for _ in range(TRIES):
        if excess < WORSE:
            break
        # what pulls is an error of the law that its own samples did not show: cables count for less
        wander = [w if bad else w.times(LESS) for w, bad in zip(wander, poor, strict=True)]
        fit = solve(vision.knots, vision.mean, seen, priors, rows_near(fit))
        excess = misfit(fit, seen) / own - 1
    notes["cable_error_m"] = [None if bad else float(np.sqrt(w.variance)) for w, bad in zip(wander, poor, strict=True)]
    if excess > WORSE:
        notes["why"] = f"cables pull the angles from what vision saw (its variance grows by {100 * excess:.0f} %)"
        return None, notes
    return fit, notes


def _covariance(fit: FusedSplines, seen: FrameAngles, at: Array, clock_sigma: tuple[float, float]) -> Array:
    """(K, 3 N, 3 N) at `at` (K,): of noise and prior, and of what all frames share."""
    n, knots = len(fit.mean), fit.knots
    first, _ = knots.rows(at)
    weights = np.stack([knots.rows(at, d)[1] for d in range(3)], axis=1)
    near = first[:, None] + np.arange(SUPPORT)
    speed = fit.alpha(seen.time, 1)
    age = (seen.time - (seen.time[0] + seen.time[-1]) / 2)[:, None]
    shifts = [clock_sigma[0] * speed, clock_sigma[1] * age * speed]
    shifts += [seen.common * (np.arange(n) == i) for i in range(n)]
    design = knots.design(seen.time)
    pulls = [design.T @ np.nan_to_num(np.where(np.isnan(seen.alpha), 0.0, d) / seen.sigma**2) for d in shifts]
    common = fit.response(np.stack([np.repeat(pull.ravel(), PARTS) for pull in pulls], axis=-1))
    # what the border's unknowns and shared errors, each of covariance C, do to the coefficients
    further = [(fit.V, np.linalg.inv(fit.schur)), (common, np.eye(len(shifts)))]
    further = [(moves.reshape(knots.count, n, PARTS, -1).sum(axis=2), C) for moves, C in further]
    wide, covariance, last = PARTS * n, np.empty((len(at), 3 * n, 3 * n)), np.arange(2 * n, 3 * n)
    for rows, window in inverse_windows(fit.factor, (WIDTH + 1) * wide, first * wide, SUPPORT * wide, PARTS):
        maps = np.einsum("tdk,ij->tdikj", weights[rows], np.eye(n)).reshape(-1, 3 * n, SUPPORT * n)
        here = maps @ window @ np.swapaxes(maps, 1, 2)
        here[:, last, last] += [prior.beyond(knots.step) for prior in fit.priors]
        for moves, C in further:
            moved = np.einsum("tdk,tkiq->tdiq", weights[rows], moves[near[rows]]).reshape(len(here), 3 * n, -1)
            here += moved @ C @ np.swapaxes(moved, 1, 2)
        covariance[rows] = here
    return covariance


def _bridged(seen: FrameAngles, at: Array) -> NDArray[np.bool_]:
    """Rows between two frames that show a joint, further apart than BRIDGE_S, (T, N)."""
    out = []
    for alpha in seen.alpha.T:
        known = seen.time[~np.isnan(alpha)]
        after = np.clip(np.searchsorted(known, at), 1, len(known) - 1)
        out.append((known[after] - known[after - 1] > BRIDGE_S) & (at > known[after - 1]) & (at < known[after]))
    return np.stack(out, axis=-1)
