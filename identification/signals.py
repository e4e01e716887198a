"""The signals that the equations of motors and arm need of a recording, at every row of its log.

Elongations come from the frames themselves. A smoothed angle lacks some of its fast motion, which is large beside an elongation;
and a state that was fused with the forces would agree with them whatever the stiffness. The frames' noise does no harm to
instrumental variables. The arm's own terms take the smoothed state: they need alpha'', and no equation of the arm went into it.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset import DataSet
from identification.dataset.half_row_speeds import HalfRowSpeeds, unrefined_speeds
from identification.decimation import DecimatingFilter, decimating_filter
from identification.elongation_errors import ElongationErrors
from mechanism.arm import Arm
from mechanism.cable_lengths import geometry_of_poses, lengths
from mechanism.dynamics import terms
from mechanism.elasticity import elongation_rate
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

TRAVEL_CLOCK_SIGMA_S = 3e-3
"""s: by how much clocks differ from recording to recording where only the cables' travel aligns them (docs/thresholds.md)"""
MIN_DURATION_S = 2.0
"""s: shortest recording that is identified, once unknown rows and the filter's ends are left out (docs/thresholds.md)"""


@dataclass(frozen=True)
class Signals:
    """Rows T of one recording; joints N, cables M."""

    arm: Arm
    time: Array
    """(T,), s, even steps"""
    alpha: Array
    """(T, N), rad, with its derivatives"""
    alpha_d: Array
    alpha_dd: Array
    vision_alpha: Array
    """angles by splines through every frame, not smoothed, (T, N), rad"""
    vision_alpha_d: Array
    """their rate, (T, N), rad/s"""
    theta: Array
    """(T, M), rad, with its derivatives"""
    theta_d: Array
    theta_dd: Array
    speeds: HalfRowSpeeds
    """of the motors: friction turns over within less than a row"""
    f: Array
    """mean force from half a row before the row to half a row after it, (T, M), N"""
    inertial: Array
    """Ia (R/rd) theta'', (T, M), N"""
    Z: Array
    """(T, N, M), m"""
    load: Array
    """M alpha'' + c + g, (T, N), N m"""
    wraps: Array
    """on the pulleys of each mechanism that slide as its span does, then on the others, (T, 2 N, M), rad"""
    length: Array
    """(T, M), m"""
    x: Array
    """elongation by vision with the description's x0, (T, M), m"""
    x_d: Array
    """(T, M), m/s"""
    low_pass: DecimatingFilter
    clock_sigma: tuple[float, float]
    """standard deviations of the clock's offset, s, and of its skew about the recording's middle"""
    relaxed_clock_sigma: float
    """s: sigma of the offset if the laws that aligned the clocks were wrong; the same as clock_sigma where a light aligned them"""
    angle_sigma: Array
    """standard deviation of the error that all frames share, (N,), rad"""
    elongation_errors: ElongationErrors | None = None
    """of the cables that angles follow from, if they do"""
    remembered: tuple[Array, Array] | None = None
    """elongations and their rates as `x` and `x_d` that cables remember, where these are not the same"""

    @cached_property
    def wrap(self) -> Array:
        """On all of a cable's pulleys, (T, M), rad."""
        return self.wraps.sum(axis=1)

    @cached_property
    def levers(self) -> Array:
        """Z with time last, (N, M, T), m."""
        return np.ascontiguousarray(np.moveaxis(self.Z, 0, -1))

    @property
    def since_began(self) -> Array:
        """Time since the first row, (T,), s."""
        return self.time - self.time[0]

    @property
    def kept_time(self) -> Array:
        """`since_began` of the rows that the equations keep, (S,), s."""
        return self.since_began[self.low_pass.kept]

    @property
    def step(self) -> float:
        """Time between rows, s."""
        return float(self.time[1] - self.time[0])


def signals_of(data: DataSet, load_by_frames: bool = False) -> Signals:
    """The signals of a data set. Raises Refused where less than two seconds of it are known in all signals.

    load_by_frames: whether the arm's own terms take angles that nothing smoothed, where the state holds their acceleration
    (`visionI_dd`). A smoother takes from alpha'' what it leaves in the forces; what noise does instead is known.
    """
    arm, state = data.arm, data.state
    time = state.time
    alpha, alpha_d, alpha_dd = (state.matrix("alpha", suffix) for suffix in ("", "_d", "_dd"))
    theta, theta_d, theta_dd = (state.matrix("theta", suffix) for suffix in ("", "_d", "_dd"))
    theta.flags.writeable = False  # functions of it are kept
    logged_f = state.matrix("f")
    # a logged force holds from its row on
    f = np.concatenate([logged_f[:1], (logged_f[:-1] + logged_f[1:]) / 2])
    speeds = data.speeds or unrefined_speeds(theta_d, data.count_angles)
    step = float(np.mean(np.diff(time)))
    missed = np.asarray(np.any(state.matrix("bridged") > 0, axis=1))
    for begin, end in data.clock.get("log_gaps", ()):
        missed |= (time > begin - step) & (time < end + step)
    filtered = decimating_filter(step, ~missed)
    if len(filtered.kept) * filtered.factor * step < MIN_DURATION_S:
        raise Refused(
            "identify", f"insufficient: {time[-1] - time[0]:.1f} s, with gaps, are too short", "record longer"
        )
    vision_alpha, vision_alpha_d = (state.matrix("vision", suffix) for suffix in ("", "_d"))
    if vision_alpha.shape[1] != arm.N:
        vision_alpha, vision_alpha_d = alpha, alpha_d
    vision_alpha_dd = state.matrix("vision", "_dd")
    if load_by_frames and vision_alpha_dd.shape[1] == arm.N:
        k, acceleration = terms(arm, vision_alpha, vision_alpha_d), vision_alpha_dd
    else:
        k, acceleration = terms(arm, alpha, alpha_d), alpha_dd
    cables, seen = geometry_of_poses(arm, alpha), geometry_of_poses(arm, vision_alpha)
    clock = data.clock
    offset_sigma = float(clock.get("offset_sigma_s") or 0.0)
    common = data.angles.matrix("common")
    return Signals(
        arm=arm,
        time=time,
        alpha=alpha,
        alpha_d=alpha_d,
        alpha_dd=alpha_dd,
        vision_alpha=vision_alpha,
        vision_alpha_d=vision_alpha_d,
        theta=theta,
        theta_d=theta_d,
        theta_dd=theta_dd,
        speeds=speeds,
        f=f,
        inertial=arm.motor_inertia / arm.drum * theta_dd,
        Z=cables.Z,
        load=np.einsum("tij,tj->ti", k.M, acceleration) + k.c + k.g,
        wraps=cables.wraps,
        length=cables.length,
        x=seen.length - lengths(arm, np.zeros(arm.N)) + arm.drum * theta + arm.x0,
        x_d=elongation_rate(arm, seen.Z, vision_alpha_d, theta_d),
        low_pass=filtered,
        clock_sigma=(offset_sigma, 1e-6 * float(clock.get("skew_sigma_ppm") or 0.0)),
        relaxed_clock_sigma=offset_sigma if clock.get("source") == "light" else max(offset_sigma, TRAVEL_CLOCK_SIGMA_S),
        elongation_errors=ElongationErrors.of(data, cables.Z),
        angle_sigma=np.sqrt(np.nanmean(common**2, axis=0)) if common.shape[1] else np.zeros(arm.N),
    )
