"""The data set: what the arm did, on the log's clock, with everything that is needed to identify it.

`synchronisation` makes it from angles and a log, or anyone from arrays; identification and diagnosis read nothing else.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.encoder_steps import count_angles
from identification.dataset.half_row_speeds import HalfRowSpeeds
from identification.dataset.series import Series, numbered_columns
from mechanism.arm import Arm, arm_of
from mechanism.description import Neck
from mechanism.elasticity import elongation
from mechanism.geometry import check_angles

Array = NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class DataSet:
    """Series of one recording; columns are those of the contract, SI units and radians.

    state: log clock at the log's rate: alphaI, alphaI_d, alphaI_dd, thetaJ, thetaJ_d, thetaJ_dd, fJ, xJ, sigma_alphaI,
    sigma_alphaI_d, sigma_alphaI_dd, the same of thetaJ (from its rounding), bridgedI (1 where vision missed the joint for longer
    than 0.2 s), visionI and visionI_d (by splines through every frame, not smoothed; without them alpha is taken).
    fasquelle: the same without sigmas, at 31.25 Hz by Fasquelle's chain, with xJ_d.
    angles: as measured in the frames, less neck.yaml's alpha_zero, on the camera's own clock. log: as the controller wrote it, in
    our signs.
    """

    neck: Neck
    neck_yaml: str
    state: Series
    fasquelle: Series
    angles: Series
    log: Series
    clock: Mapping[str, Any] = field(default_factory=dict)
    check: Mapping[str, Any] = field(default_factory=dict)
    provenance: Mapping[str, Any] = field(default_factory=dict)
    covariance: Series | None = None
    """full covariance of alpha, alpha', alpha'' of all joints at a few Hz, columns `cov_alpha1_alpha2_d` (upper triangle)"""
    speeds: HalfRowSpeeds | None = None
    """of the motors, where friction is known by which they can be told within the state's rows; not in any file"""

    def __repr__(self) -> str:
        time, frames = self.state.time, len(self.angles)
        seconds = time[-1] - time[0] if len(time) else 0.0
        return f"<DataSet of {self.neck.N} joints and {self.neck.M} cables: {seconds:.1f} s, {len(time)} rows, {frames} frames>"

    @property
    def is_filmed(self) -> bool:
        """Whether its angles were extracted from a video, by the markers that neck.yaml describes, as far as is known."""
        return "markers" in self.provenance.get("angles", {})

    @property
    def arm(self) -> Arm:
        """The arm's numbers as neck.yaml states them."""
        return arm_of(self.neck)

    @cached_property
    def count_angles(self) -> Array:
        """Angle of one step of each motor's encoder, (M,), rad: as the log shows, or as described where it shows none."""
        return count_angles(self.neck, self.log)


def state_series(
    arm: Arm,
    time: Array,
    alpha: tuple[Array, Array, Array],
    theta: tuple[Array, Array, Array],
    f: Array,
    sigma: tuple[Array, Array, Array] | None = None,
    x_d: Array | None = None,
) -> Series:
    """Columns of a data set from arrays: time (T,); alpha with its two derivatives, each (T, N); theta likewise (T, M); f (T, M).

    The elongation x (41) is computed here. Raises Refused where an angle does not fit the arm.
    """
    check_angles(arm, alpha[0], "data set")
    columns: dict[str, Array] = {}
    for stem, parts in (("alpha", alpha), ("theta", theta)):
        for suffix, values in zip(("", "_d", "_dd"), parts, strict=True):
            columns |= numbered_columns(stem, values, suffix)
    columns |= numbered_columns("f", f) | numbered_columns("x", elongation(arm, alpha[0], theta[0]))
    if x_d is not None:
        columns |= numbered_columns("x", x_d, "_d")
    if sigma is not None:
        for suffix, values in zip(("", "_d", "_dd"), sigma, strict=True):
            columns |= numbered_columns("sigma_alpha", values, suffix)
    return Series(time, columns)
