"""The state of the arm at the log's rate: alpha, alpha', alpha'' of all joints with their covariance.

The angles of all joints are one spline (see spline.py). Vision measures them in its frames; cables measure them at the log's rate
where the motor force explains their elongations (see cable_fusion.py). Errors that all frames share (clock, camera pose, marker
placement) are not estimated, but what they would do to the state enters its covariance (see state_covariance.py).
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.frames import FrameAngles
from identification.dataset.series import Series, interpolated
from mechanism.arm import Arm
from state_estimation.cable_fusion import fuse_cables
from state_estimation.fusion import SplineSolution, solve_splines, vision_equations
from state_estimation.motion_prior import ROUGHNESS_ALLOWANCE, TwoPartPrior, fit_two_part_prior
from state_estimation.motors import Motors
from state_estimation.smoother import check_span
from state_estimation.spline import knots_over
from state_estimation.state_covariance import state_covariance

Array = NDArray[np.float64]

KNOT_S = 1 / 60
"""s between knots: represents motion to about 16 Hz, an arm's own swinging on its cables included (docs/thresholds.md)"""
COVARIANCE_HZ = 50.0
"""Hz: rate at which the covariance is computed; it is interpolated between"""
BRIDGE_S = 0.2
"""s: rows of a joint that vision missed for longer are marked as bridged (docs/thresholds.md)"""


@dataclass(frozen=True)
class StateEstimate:
    """Angles with two derivatives, their covariance at fewer times, and what they were estimated from."""

    time: Array
    """(T,), s"""
    alpha: Array
    """(T, N), rad, with its derivatives"""
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
        sigma = np.sqrt(np.diagonal(self.covariance, axis1=1, axis2=2))
        at_time = interpolated(self.time, self.covariance_time, sigma)
        of_alpha, of_alpha_d, of_alpha_dd = np.split(at_time, 3, axis=1)
        return of_alpha, of_alpha_d, of_alpha_dd

    def covariance_series(self, rate: float) -> Series:
        """The covariance's upper triangle at about `rate` Hz, in columns `cov_alpha1_alpha2_d`."""
        step = float(np.median(np.diff(self.covariance_time)))
        rows = slice(None, None, max(1, round(1 / (rate * step))))
        n = self.alpha.shape[1]
        names = [f"alpha{i + 1}{suffix}" for suffix in ("", "_d", "_dd") for i in range(n)]
        pairs = [(a, b) for a in range(3 * n) for b in range(a, 3 * n)]
        columns = {f"cov_{names[a]}_{names[b]}": self.covariance[rows, a, b] for a, b in pairs}
        return Series(self.covariance_time[rows], columns)


@dataclass(frozen=True)
class VisionState:
    """Angles with two derivatives by vision alone, and the motion priors that they were estimated with."""

    alpha: Array
    """(T, N), rad, with its derivatives"""
    alpha_d: Array
    alpha_dd: Array
    bridged: NDArray[np.bool_]
    """(T, N): vision missed the joint for longer than BRIDGE_S there"""
    priors: list[TwoPartPrior]


def estimate_state(
    arm: Arm,
    frames: FrameAngles,
    motors: Motors,
    at: Array,
    clock_sigma: tuple[float, float] = (0.0, 0.0),
    fuse: bool = True,
) -> StateEstimate:
    """The state at `at` (T,), s, even times of the log within the frames.

    clock_sigma: of the offset (s) and of the skew (ratio, about the middle of the frames). Without `fuse`, and where the cables
    disagree with vision, the state is that of vision alone, as the notes say.

    Raises Refused where `at` reaches beyond the frames or they are too few.
    """
    for column in frames.alpha.T:
        check_span(frames.time[~np.isnan(column)], at)
    solution = _solve_vision(frames)
    notes: dict[str, Any] = {"method": "vision"}
    if fuse:
        fused, fusion_notes = fuse_cables(arm, frames, motors, solution)
        notes |= fusion_notes
        if fused is not None:
            solution, notes["method"] = fused, "fused"
    stride = max(1, round(1 / (COVARIANCE_HZ * float(np.mean(np.diff(at))))))
    rows = np.unique(np.append(np.arange(0, len(at), stride), len(at) - 1))
    return StateEstimate(
        time=at,
        alpha=solution.alpha(at),
        alpha_d=solution.alpha(at, 1),
        alpha_dd=solution.alpha(at, 2),
        covariance_time=at[rows],
        covariance=state_covariance(solution, frames, at[rows], clock_sigma),
        bridged=_bridged(frames, at),
        notes=notes,
    )


def estimate_by_vision(frames: FrameAngles, at: Array, priors: list[TwoPartPrior] | None = None) -> VisionState:
    """The state at `at` (T,), s, by vision alone, without covariance; priors are fitted to the frames where none are given."""
    solution = _solve_vision(frames, priors)
    return VisionState(
        alpha=solution.alpha(at),
        alpha_d=solution.alpha(at, 1),
        alpha_dd=solution.alpha(at, 2),
        bridged=_bridged(frames, at),
        priors=solution.priors,
    )


def _solve_vision(frames: FrameAngles, priors: list[TwoPartPrior] | None = None) -> SplineSolution:
    mean = np.nanmean(frames.alpha, axis=0)
    priors = priors or [
        fit_two_part_prior(frames.time[known], a[known] - mean[i], s[known] ** 2, KNOT_S, ROUGHNESS_ALLOWANCE)
        for i, (a, s) in enumerate(zip(frames.alpha.T, frames.sigma.T, strict=True))
        for known in [~np.isnan(a)]
    ]
    knots = knots_over(frames.time[0], frames.time[-1], KNOT_S)
    return solve_splines(vision_equations(knots, mean, frames), priors)


def _bridged(frames: FrameAngles, at: Array) -> NDArray[np.bool_]:
    """Times (T,) between two frames that show a joint and are further apart than BRIDGE_S, (T, N)."""
    columns = []
    for alpha in frames.alpha.T:
        known = frames.time[~np.isnan(alpha)]
        after = np.clip(np.searchsorted(known, at), 1, len(known) - 1)
        columns.append((known[after] - known[after - 1] > BRIDGE_S) & (at > known[after - 1]) & (at < known[after]))
    return np.stack(columns, axis=-1)
