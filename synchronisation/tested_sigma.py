"""Whether angles scatter from frame to frame as their sigma says, and what is made of it where they do not."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from synchronisation.angles import Angles
from synchronisation.frame_noise import OUTLYING_SIGMAS, frame_noise
from synchronisation.log_units import Unit, unit_of
from synchronisation.sigma_by_frames import noise_record
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import listed

Array = NDArray[np.float64]

MIN_EXCESS = 1.1
"""true over stated noise from which on a sigma is raised, if chance does not explain it (docs/thresholds.md)"""
CHANCE_SIGMAS = 3.0
"""standard deviations of that ratio which chance explains (docs/thresholds.md)"""
RESONANCE_REMAINDER_RAD = np.radians(0.004)
"""rad: what an arm's own swinging on its cables may add to the noise of 30 frames a second (docs/thresholds.md)"""
SIGMA_WARNING = 3.0
"""stated over true noise from which on a warning says so (docs/thresholds.md)"""
SIGMA_TOLERANCE = 0.4
"""log of the ratio between true and stated noise over that of degrees, within which a sigma is in degrees (docs/thresholds.md)"""

_SIGMA_UNITS = (Unit("rad", 1.0), Unit("degrees", float(np.pi / 180)))


def with_tested_sigma(angles: Angles) -> tuple[Angles, tuple[str, ...]]:
    """Angles whose sigma is what the frames scatter by, where the given one is less, and warnings.

    A frame that stands out has a sigma as large as what it stands out by. A sigma that is too large stays. `noise` holds the
    result. Raises Refused where sigma is in degrees.
    """
    if angles.noise is not None:
        return angles, (*_held(angles.held), *_of_record(angles.noise))
    white = angles.white_sigma
    noise = frame_noise(angles.time, angles.alpha, white)
    stated = np.array([np.median(s[np.isfinite(s)]) if np.isfinite(s).any() else np.nan for s in white.T])
    own = np.sqrt(np.maximum(noise.ratio**2 - (RESONANCE_REMAINDER_RAD / stated) ** 2, 0))
    short = (own > MIN_EXCESS) & (own - 1 > CHANCE_SIGMAS * noise.ratio_sigma)
    factor = np.where(short, noise.ratio, 1.0)
    true_white = np.maximum(factor * white, noise.outlying)
    sigma = np.sqrt(angles.sigma**2 + true_white**2 - white**2)
    record = noise_record("file", noise, factor * stated)
    tested = replace(angles, sigma=sigma, noise=record)
    warnings = (*_held(angles.held), *_too_small(factor), *_too_large(noise.ratio, noise.bound), *_outlying(record))
    return tested, warnings


def _held(count: int) -> tuple[str, ...]:
    """A warning of frames that hold the angles of the frame before."""
    if not count:
        return ()
    what = "1 frame holds" if count == 1 else f"{count} frames hold"
    return (f"{what} the angles of the frame before while the arm moves, and count as not seen: write each angle once",)


def _of_record(record: Mapping[str, Any]) -> tuple[str, ...]:
    """Warnings where sigma was read from the frames."""
    untold = [i for i, scatter in enumerate(record["scatter"]) if scatter is None]
    if record["from"] != "frames" or not untold:
        return _outlying(record)
    sigma = [np.degrees(record["sigma_rad"][i]) for i in untold]
    what = (
        f"{_joints(untold)} without sigma, and the frames are too few or too far apart to tell it: "
        f"{listed(f'{s:.2g}' for s in sigma)} deg {'is' if len(untold) == 1 else 'are'} taken"
    )
    return (what, *_outlying(record))


def _too_small(factor: Array) -> tuple[str, ...]:
    joints = np.flatnonzero(factor > 1)
    if not len(joints):
        return ()
    times = listed(f"{factor[i]:.2g}" for i in joints)
    return (
        f"{_joints(joints)} with a sigma that is too small: frames scatter {times} times as far, and sigma is raised so",
    )


def _too_large(ratio: Array, bound: Array) -> tuple[str, ...]:
    ratio = np.where(np.isnan(ratio), bound, ratio)
    if not np.any(ratio < 1 / SIGMA_WARNING):
        return ()
    joints = np.flatnonzero(ratio < 1 / SIGMA_WARNING)
    times = listed(f"{1 / ratio[i]:.2g}" for i in joints)
    words = (
        f"sigma of {listed(f'alpha{i + 1}' for i in joints)} is {times} times what they scatter by from frame to frame"
    )
    if len(joints) == len(ratio) and all(unit_of(r, _SIGMA_UNITS, SIGMA_TOLERANCE) is _SIGMA_UNITS[1] for r in ratio):
        raise Refused("angles", f"{words}: sigma is in degrees", "multiply sigma1..N by 0.0174533")
    return (f"{words}; is it in rad, of one frame?",)


def _outlying(record: Mapping[str, Any]) -> tuple[str, ...]:
    count = {f"alpha{i + 1}": n for i, n in enumerate(record["outlying_frames"]) if n}
    if not count:
        return ()
    frames = listed(f"{n} of {name}" for name, n in count.items())
    return (f"frames that stand out by more than {OUTLYING_SIGMAS:g} sigma count for less: {frames}",)


def _joints(joints: Any) -> str:
    names = listed(f"alpha{i + 1}" for i in joints)
    return f"{names} {'comes' if len(joints) == 1 else 'come'}"
