"""Markers that sit otherwise than neck.yaml says: how the video tells it, and with which prior angles are fitted then.

The linkage as one object believes distances between markers to micrometres, so that a half millimetre by which one was stuck on
beside its place, or a bar that is longer by a five-hundredth, turns into tenths of degrees and degrees, by way of depth and the
camera's pose. Where corners fit better to markers that may sit elsewhere, angles are fitted so, and their sigma holds by how far.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from calibration.camera import Camera
from mechanism.description import Neck
from vision.linkage.linkage_fit import LinkageFit
from vision.linkage.marker_placement import PlacedNumber, describe_placement
from vision.linkage.observed_corners import Floats
from vision.linkage.shared_fit import LinkageOptions, PlacementPrior, fit_shared

Array = NDArray[np.float64]

MAX_PLACEMENT_ERROR_RATIO = 1.04
"""corner error with the placement of neck.yaml over that with a free placement, from which on the placement is called wrong
(docs/thresholds.md)"""
MIN_EXTRA_PX = 0.02
"""px: what wrong places add to the corners' error at least: offsets of edges among the pixels do as much (docs/thresholds.md)"""
AT_SIGMA_M = 0.0005
"""m, along and across its bar: how well a marker is stuck on by hand (docs/thresholds.md)"""
ANGLE_SIGMA_RAD = float(np.radians(0.3))
"""rad: the same of its angle (docs/thresholds.md)"""
PRIOR_WEIGHT = 9.0
"""times as much as frames that counts in a fit (docs/thresholds.md)"""
BY_HAND = PlacementPrior(AT_SIGMA_M, ANGLE_SIGMA_RAD, weight=PRIOR_WEIGHT)
_SHRUNK = 1.2
"""times as far beside their places as they are found, markers may be: a prior draws them back"""
_MIN_SHARE = 0.25
"""of how well they are stuck on by hand: no recording tells that they were stuck on better"""
_SURE_SIGMAS = 3.0
"""from how many on a number is named as one that is wrong"""


def misplacement(
    neck: Neck,
    camera: Camera,
    corners: Array,
    covariance: Floats | None,
    where: str,
    described: LinkageFit,
    options: LinkageOptions,
) -> tuple[PlacementPrior, str] | None:
    """A prior by which angles are fitted, and a sentence, where markers hardly sit as neck.yaml says; None where they may.

    corners (F, markers, 4, 2), px, covariance as `fit_linkage` takes them; described: its fit with neck.yaml's placement, by
    `options`. How wide the prior is follows from how far beside their places markers turn out to sit.
    """
    with_drift = replace(options, placement=BY_HAND, drift=bool(described.drift))
    free = fit_shared(neck, camera, corners, where, covariance, options=with_drift)
    ratio = described.scale / float(np.sqrt(free.variance))
    extra_px = described.corner_sigma_px * np.sqrt(max(1 - ratio**-2, 0.0))
    if ratio < MAX_PLACEMENT_ERROR_RATIO or extra_px < np.hypot(MIN_EXTRA_PX, described.shake_left_px):
        return None
    numbers = describe_placement(neck, free, BY_HAND).numbers
    beside = float(np.sqrt(np.mean([((n.value - n.nominal) / n.prior_sigma) ** 2 for n in numbers])))
    share = max(_MIN_SHARE, _SHRUNK * beside)
    prior = PlacementPrior(share * BY_HAND.at_sigma, share * BY_HAND.angle_sigma, weight=share**2 * BY_HAND.weight)
    known = f"{1e3 * prior.at_sigma:.1f} mm and {np.degrees(prior.angle_sigma):.1f} deg"
    said = (
        "the markers do not sit as neck.yaml says, or bars have other lengths: corners fit to "
        f"{described.corner_sigma_px:.2f} px as described, to {described.corner_sigma_px / ratio:.2f} px where markers may sit "
        f"otherwise{_most(numbers, share)}; sigma of the angles holds that places are known to {known}; is something over markers, "
        "or the picture blurred? else let their placement be estimated, or correct neck.yaml"
    )
    return prior, said


def _most(numbers: tuple[PlacedNumber, ...], share: float) -> str:
    """The number that is furthest from neck.yaml, where the video tells that it is."""
    sure = [n for n in numbers if abs(n.value - n.nominal) > _SURE_SIGMAS * max(share, 1.0) * n.sigma]
    if not sure:
        return ""
    worst = max(sure, key=lambda n: abs(n.value - n.nominal) / n.prior_sigma)
    beside = worst.value - worst.nominal
    shown = f"{1e3 * beside:+.1f} mm" if worst.unit == "m" else f"{np.degrees(beside):+.1f} deg"
    return f" (most: {worst.name} of {worst.where}, {shown})"
