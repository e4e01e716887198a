"""Refusals of a calibration: views that do not determine the camera, or that no camera of this kind took."""

from collections.abc import Sequence

import numpy as np

from calibration.board_poses import BoardPoses
from calibration.bundle_adjustment import BundleFit
from calibration.observations import LeftOut, Observations
from calibration.stacked_views import StackedViews
from xneck_foundation.errors import Refused

MIN_VIEWS = 6
"""distinct views that a calibration needs (docs/thresholds.md)"""
_MIN_TILT_RAD = np.radians(10.0)
"""least value of the largest angle between two boards, rad (docs/thresholds.md)"""
_MAX_FOCAL_SIGMA = 0.02
"""largest standard deviation of the focal length, as a share of it (docs/thresholds.md)"""
_MAX_ERROR_OVER_NOISE = 4.0
"""largest error of a fit over the noise of corner detection (docs/thresholds.md)"""
_MAX_ERROR_SHARE = 4e-4
"""largest error of a fit as a share of the picture's diagonal (1 px at least); no corner detection leaves more
(docs/thresholds.md)"""
_RADIAL_TERMS = 9
"""terms of the polynomial in the distance from the middle"""
_MAX_RADIAL_F = 5.0
"""variance ratio above which errors depend on the distance from the middle (docs/thresholds.md)"""
_MAX_RADIAL_OVER_NOISE = 0.5
"""rms of errors that depend on the distance from the middle, over the noise of a corner, above which the lens is a fisheye
(docs/thresholds.md)"""


def refuse_impossible_corners(observations: Observations) -> None:
    """Refused for corners that are not finite, or that lie further outside of the picture than it is large."""
    size = np.asarray(observations.image_size)
    for view in observations.views:
        if not (np.all(np.isfinite(view.image_points)) and np.all(np.isfinite(view.object_points))):
            raise Refused(view.name, "corner coordinates that are not finite", "leave the picture out")
        if np.any(np.abs(view.image_points - size / 2) > 1.5 * size):
            what = f"has corners far outside of the picture of {size[0]} x {size[1]} px"
            raise Refused(view.name, what, "leave the picture out")


def largest_tilt(poses: BoardPoses) -> float:
    """The largest angle between the planes of two boards, rad."""
    normals = poses.R[:, :, 2]
    # with the cross product, since arccos loses the digits of small angles
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
    """Raises Refused where the corners are further from their prediction than the noise of corner detection explains.

    `noise`: of corner detection, one coordinate, px; where unknown, only errors are refused that no corner detection leaves.
    """
    upper = max(1.0, _MAX_ERROR_SHARE * float(np.hypot(*image_size)))  # px; corner detection leaves 0.05 to 0.5 px
    limit = upper if noise is None else float(np.clip(_MAX_ERROR_OVER_NOISE * np.sqrt(2) * noise, 0.25 * upper, upper))
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
    """Raises Refused where boards are tilted alike or the focal length is poorly determined."""
    tilt = largest_tilt(fitted.poses)
    if tilt < _MIN_TILT_RAD:
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
    """Raises Refused where the least squares did not converge, as some of the parameters are not determined."""
    if not fitted.converged:
        raise Refused(
            "pictures",
            "the camera keeps changing while it is estimated",
            "add views tilted by 20 to 40 degrees in different directions, near enough to fill the picture",
        )


def refuse_fisheye(full: BundleFit, views: StackedViews, residuals: np.ndarray, noise: float) -> str | None:
    """A note where residuals of the fullest lens model depend on the distance from the middle; None where they do not.

    Raises Refused where they do so by more than half the noise of one corner: then the lens is a fisheye.
    residuals: of the fit `full` to `views`, shape (n, c, 2), px; noise: of one coordinate, px.
    """
    amplitude, ratio, common = _radial(full, views, residuals)
    # a view at the very edge can spoil the prediction; lenses that moved between views give ratios up to 7
    if ratio <= _MAX_RADIAL_F or not (common or ratio > 4 * _MAX_RADIAL_F):
        return None
    if amplitude > _MAX_RADIAL_OVER_NOISE * noise:
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


def _radial(full: BundleFit, views: StackedViews, residuals: np.ndarray) -> tuple[float, float, bool]:
    """Radial errors that a smooth function of the distance from the middle explains: px rms, variance ratio, whether common.

    The variance ratio is against chance. Errors are common where views predict them for one another, which a lens causes; else
    each view has its own, since something moved between them.
    """
    visible = views.visible
    from_middle = views.pixels[visible] - full.parameters[2:4]
    radius = np.linalg.norm(from_middle, axis=1)
    outward = np.clip(np.sum(residuals[visible] * from_middle, axis=1) / np.maximum(radius, 1.0), -full.knee, full.knee)
    terms = np.polynomial.chebyshev.chebvander(2 * radius / max(float(radius.max()), 1.0) - 1, _RADIAL_TERMS - 1)
    fitted = terms @ np.linalg.lstsq(terms, outward, rcond=None)[0]
    residual_variance = np.sum((outward - fitted) ** 2) / max(len(outward) - _RADIAL_TERMS, 1)
    view_of = np.nonzero(visible)[0]
    gains = np.empty(len(visible))
    for view in range(len(visible)):
        in_view = view_of == view
        coefficients = np.linalg.lstsq(terms[~in_view], outward[~in_view], rcond=None)[0]
        gains[view] = np.mean(outward[in_view] ** 2 - (outward[in_view] - terms[in_view] @ coefficients) ** 2)
    common = bool(np.mean(gains) > 2 * np.std(gains, ddof=1) / np.sqrt(len(gains)))
    return (
        float(np.sqrt(np.mean(fitted**2))),
        float(np.sum(fitted**2) / _RADIAL_TERMS / max(residual_variance, 1e-18)),
        common,
    )
