"""What both equations need of a recording at every row of its log.

Elongations come from the frames themselves: a smoothed angle lacks some of its fast motion, which is large beside an
elongation, and one that cables have pulled towards what the force says of them would agree with the force whatever the
stiffness. Noise does no harm to instruments. The arm's own terms take the state: they need alpha'', and no equation of the
arm went into it.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset import DataSet
from identification.decimation import DecimatingFilter, decimating_filter
from mechanism.arm import Arm
from mechanism.cable_lengths import Z, lengths, wrap_angles
from mechanism.dynamics import terms
from mechanism.elasticity import elongation, elongation_rate
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

TRAVEL_CLOCK_SIGMA_S = 3e-3
"""s, that clocks differ by from recording to recording where only the cables' travel tells them"""
MIN_DURATION_S = 2.0
"""s that must remain when unknown rows and the filter's ends are left out"""


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
    seen: Array
    """by splines through every frame, (T, N), rad, and its rate"""
    seen_d: Array
    theta: Array
    """(T, M), rad, with its derivatives"""
    theta_d: Array
    theta_dd: Array
    f: Array
    """mean force around the row, (T, M), N"""
    inertial: Array
    """Ia (R/rd) theta'', (T, M), N"""
    Z: Array
    """(T, N, M), m"""
    load: Array
    """M alpha'' + c + g, (T, N), N m"""
    wrap: Array
    """(T, M), rad"""
    length: Array
    """(T, M), m"""
    x: Array
    """elongation by vision with the description's x0, (T, M), m"""
    x_d: Array
    """(T, M), m/s"""
    low_pass: DecimatingFilter
    clock_sigma: tuple[float, float]
    """of the offset, s, and of the skew about the recording's middle"""
    clock_doubt: float
    """s, of the offset were the laws wrong that told it: a light needs none, travel alone tells a few milliseconds"""
    angle_sigma: Array
    """what all frames share, (N,), rad"""

    @cached_property
    def levers(self) -> Array:
        """Z with time last, (N, M, T), m."""
        return np.ascontiguousarray(np.moveaxis(self.Z, 0, -1))

    @property
    def step(self) -> float:
        """s between rows."""
        return float(self.time[1] - self.time[0])


def signals_of(data: DataSet) -> Signals:
    """From a data set; raises Refused where what is known all at once is shorter than two seconds."""
    arm, state = data.arm, data.state
    time = state.time
    alpha, alpha_d, alpha_dd = (state.matrix("alpha", suffix) for suffix in ("", "_d", "_dd"))
    theta, theta_d, theta_dd = (state.matrix("theta", suffix) for suffix in ("", "_d", "_dd"))
    written = state.matrix("f")
    # a row's force holds from the row on
    f = np.concatenate([written[:1], (written[:-1] + written[1:]) / 2])
    # a mean over two periods is a little smoother than what it stands beside: undone to the second order
    f[1:-1] -= (f[2:] - 2 * f[1:-1] + f[:-2]) / 6
    step = float(np.mean(np.diff(time)))
    missed = np.asarray(np.any(state.matrix("bridged") > 0, axis=1))
    for begin, end in data.clock.get("log_gaps", ()):
        missed |= (time > begin - step) & (time < end + step)
    filtered = decimating_filter(step, ~missed)
    if len(filtered.kept) * filtered.factor * step < MIN_DURATION_S:
        raise Refused(
            "identify", f"insufficient: {time[-1] - time[0]:.1f} s, with gaps, are too short", "record longer"
        )
    k = terms(arm, alpha, alpha_d)
    seen, seen_d = (state.matrix("vision", suffix) for suffix in ("", "_d"))
    if seen.shape[1] != arm.N:
        seen, seen_d = alpha, alpha_d
    clock = data.clock
    offset_sigma = float(clock.get("offset_sigma_s") or 0.0)
    common = data.angles.matrix("common")
    return Signals(
        arm=arm,
        time=time,
        alpha=alpha,
        alpha_d=alpha_d,
        alpha_dd=alpha_dd,
        seen=seen,
        seen_d=seen_d,
        theta=theta,
        theta_d=theta_d,
        theta_dd=theta_dd,
        f=f,
        inertial=arm.motor_inertia / arm.drum * theta_dd,
        Z=Z(arm, alpha),
        load=np.einsum("tij,tj->ti", k.M, alpha_dd) + k.c + k.g,
        wrap=wrap_angles(arm, alpha),
        length=lengths(arm, alpha),
        x=elongation(arm, seen, theta),
        x_d=elongation_rate(arm, Z(arm, seen), seen_d, theta_d),
        low_pass=filtered,
        clock_sigma=(offset_sigma, 1e-6 * float(clock.get("skew_sigma_ppm") or 0.0)),
        clock_doubt=offset_sigma if clock.get("source") == "light" else max(offset_sigma, TRAVEL_CLOCK_SIGMA_S),
        angle_sigma=np.sqrt(np.nanmean(common**2, axis=0)) if common.shape[1] else np.zeros(arm.N),
    )
