"""When views cannot tell a camera, or no camera of this kind took them."""

from collections.abc import Sequence

import numpy as np

from calibration.board_poses import BoardPoses
from calibration.bundle_adjustment import BundleFit
from calibration.observations import LeftOut
from calibration.stacked_views import StackedViews
from xneck_foundation.errors import Refused

MIN_VIEWS = 6
_MIN_TILT = np.radians(10.0)  # largest angle between two boards
_MAX_FOCAL_SIGMA = 0.02  # of the focal length
_ABOVE_NOISE = 4.0
"""error over the noise of corner finding: real sets have 1.3 to 1.7, boards bent anew by 0.5 mm for each picture 2"""
_RADIAL_TERMS = 9
_RADIAL_F = 5.0
"""variance ratio from which on errors depend on the distance from the middle: real sets have up to 2.2, an equidistant lens
of 120 degrees 8 to 16, of 135 degrees 150 and more"""

_RADIAL_NOISE = 0.5
"""such errors over the noise of a corner: 130 degrees leave 0.5, 135 degrees 0.66"""


def largest_tilt(poses: BoardPoses) -> float:
    """The largest angle between the planes of two boards, rad."""
    normals = poses.R[:, :, 2]
    # arcsin of the cross product: arccos has no digits for small angles
    cross = np.linalg.norm(np.cross(normals[:, None], normals[None]), axis=2)
    return float(np.max(np.arctan2(cross, normals @ normals.T)))


def refuse_few(count: int, left_out: Sequence[LeftOut]) -> None:
    """Raises Refused for fewer than MIN_VIEWS distinct views."""
    if count >= MIN_VIEWS:
        return
    shown = "; ".join(f"{entry.name}: {entry.why}" for entry in left_out[:3])
    more = f" and {len(left_out) - 3} more" if len(left_out) > 3 else ""
    raise Refused(
        "pictures",
        f"{count} distinct views of the board" + (f" (left out: {shown}{more})" if shown else ""),
        f"take {MIN_VIEWS} or more, better 15, tilted by 20 to 40 degrees in all directions, all over the picture",
    )


def refuse_unexplained(
    fitted: BundleFit, noise: float | None, image_size: tuple[int, int], disagreeing: Sequence[LeftOut] = ()
) -> None:
    """Raises Refused where the corners are further from any camera than corner finding can be.

    `noise`: of corner finding, one coordinate, px; where unknown, only what no corner finding leaves is refused.
    """
    most = max(1.0, 4e-4 * float(np.hypot(*image_size)))  # px; corner finding leaves 0.05 to 0.5 px
    limit = most if noise is None else float(np.clip(_ABOVE_NOISE * np.sqrt(2) * noise, 0.25 * most, most))
    error = float(np.sqrt(np.mean(fitted.robust_rms_views**2)))
    if error <= limit:
        return
    also = f" even without {', '.join(entry.name for entry in disagreeing)}" if disagreeing else ""
    than = "" if noise is None else f", where the noise of the corners is {np.sqrt(2) * noise:.2f} px"
    raise Refused(
        "pictures",
        f"no camera with this lens model explains the corners: {error:.2f} px rms{also}{than}",
        "check the board's columns, rows and sizes, that it is flat, that nothing zoomed or focused between "
        "pictures, and that the lens is no fisheye",
    )


def refuse_undetermined(fitted: BundleFit) -> None:
    """Raises Refused where boards are tilted alike or the focal length is poorly known."""
    tilt = largest_tilt(fitted.poses)
    if tilt < _MIN_TILT:
        raise Refused(
            "pictures",
            f"all boards are tilted alike (within {np.degrees(tilt):.1f} degrees), which cannot tell the focal length",
            "tilt the board by 20 to 40 degrees in different directions",
        )
    focal = fitted.parameters[:2]
    sigma = np.sqrt(np.diag(fitted.covariance))[:2]
    if np.any(focal <= 0) or np.any(sigma > _MAX_FOCAL_SIGMA * focal):
        raise Refused(
            "pictures",
            f"the focal length is known to {100 * float(np.max(sigma / np.abs(focal))):.1f} % only",
            "add views tilted by 20 to 40 degrees in different directions, near enough to fill the picture",
        )


def refuse_unconverged(fitted: BundleFit) -> None:
    """Raises Refused where the least squares went on and on: some of what is estimated is not determined."""
    if not fitted.converged:
        raise Refused(
            "pictures",
            "the camera keeps changing while it is estimated",
            "add views tilted by 20 to 40 degrees in different directions, near enough to fill the picture",
        )


def refuse_fisheye(full: BundleFit, sightings: StackedViews, residuals: np.ndarray, noise: float) -> str | None:
    """A note where what the fullest lens model leaves still depends on the distance from the middle.

    Raises Refused where it does so by more than half the noise of one corner: a fisheye in a pinhole's clothes.
    residuals: shape (n, c, 2), px; `noise` of one coordinate, px.
    """
    amplitude, ratio, common = _radial(full, sightings, residuals)
    # a view at the very edge can spoil the prediction; lenses that moved between views give ratios up to 7
    if ratio <= _RADIAL_F or not (common or ratio > 4 * _RADIAL_F):
        return None
    if amplitude > _RADIAL_NOISE * noise:
        raise Refused(
            "pictures",
            f"the corners' errors depend on their distance from the middle ({amplitude:.2f} px rms, {ratio:.0f} times chance)"
            ": the lens is a fisheye, or as wide as one",
            "use a lens (or a mode of the camera) that keeps straight lines straight, or crop to the middle",
        )
    return (
        f"the corners' errors depend on their distance from the middle ({amplitude:.2f} px rms): the lens is wider than its "
        "model, do not use it beyond the corners seen"
    )


def _radial(full: BundleFit, sightings: StackedViews, residuals: np.ndarray) -> tuple[float, float, bool]:
    """What a smooth function of the distance explains of the errors along it: px rms, variance over chance's, and whether
    views predict it for one another (the lens did it) or each has its own (something moved between them)."""
    seen = sightings.seen
    away = sightings.pixels[seen] - full.parameters[2:4]
    radius = np.linalg.norm(away, axis=1)
    outward = np.clip(np.sum(residuals[seen] * away, axis=1) / np.maximum(radius, 1.0), -full.knee, full.knee)
    terms = np.polynomial.chebyshev.chebvander(2 * radius / max(float(radius.max()), 1.0) - 1, _RADIAL_TERMS - 1)
    fitted = terms @ np.linalg.lstsq(terms, outward, rcond=None)[0]
    left = np.sum((outward - fitted) ** 2) / max(len(outward) - _RADIAL_TERMS, 1)
    view_of = np.nonzero(seen)[0]
    gains = np.empty(len(seen))
    for view in range(len(seen)):
        own = view_of == view
        others = np.linalg.lstsq(terms[~own], outward[~own], rcond=None)[0]
        gains[view] = np.mean(outward[own] ** 2 - (outward[own] - terms[own] @ others) ** 2)
    common = bool(np.mean(gains) > 2 * np.std(gains, ddof=1) / np.sqrt(len(gains)))
    return float(np.sqrt(np.mean(fitted**2))), float(np.sum(fitted**2) / _RADIAL_TERMS / max(left, 1e-18)), common
