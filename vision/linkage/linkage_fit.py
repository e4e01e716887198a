"""From marker corners to joint angles: the arm as one object in its plane before a calibrated camera.

Unknown are alpha_1..N of every frame and the parameters that all frames share: the camera's pose against the base bar, its
drift, and on request where each marker sits on its bar. All markers of all bars enter together through the linkage's geometry,
so a bar whose marker is hidden keeps its angle where its neighbours determine it.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibration.camera import Camera
from mechanism.description import Neck
from vision.linkage.camera_motion import DriftTerm
from vision.linkage.camera_shake import CameraShake, camera_shake
from vision.linkage.component_estimate import estimate_components
from vision.linkage.error_components import ErrorComponents, shared_shift_slopes
from vision.linkage.gauss_newton import fit_angles
from vision.linkage.linkage_equations import degrees_of_freedom, inverse_normals, whiten
from vision.linkage.marker_placement import MarkerPlacement, PlacedNumber, describe_depth, describe_placement
from vision.linkage.observed_corners import CHUNK_FRAMES, Floats, whiten_corners
from vision.linkage.offset_sensitivity import offset_sensitivity
from vision.linkage.row_time import RowTime, row_time
from vision.linkage.scene import poses_by_frame
from vision.linkage.shared_fit import MAX_FRAMES, LinkageOptions, SharedFit, fit_shared
from vision.moderated_variance import moderated_variances

Array = NDArray[np.float64]

MAX_SIGMA_RAD = np.radians(3.0)
"""rad: an angle with a larger standard deviation from its own frame's corners counts as not determined (docs/thresholds.md)"""
UNDETERMINED_VARIANCE = 1e12
"""rad^2, of a direction that no corner determines"""


@dataclass(frozen=True)
class LinkageFit:
    """Angles of all frames with the parameters behind them."""

    alpha: Array
    """(F, N), rad; NaN where the frame's markers do not determine it"""
    covariance: Array
    """(F, N, N), rad^2: of the corners' noise as the residuals show it, and of pose, drift and placement"""
    rvec: Array
    """rotation vector of T_camera_base at the first frame, (3,)"""
    tvec: Array
    """translation of T_camera_base at the first frame, (3,), m"""
    pose_sigma: Array
    """standard deviations of rvec (rad) and tvec (m), (6,)"""
    corner_sigma_px: float
    """standard deviation of a corner's coordinate as the residuals show it"""
    residual_px: Array
    """RMS corner residual of each frame, (F,), px"""
    noise: Array | None = None
    """(F, N, N), rad^2: the part of `covariance` that differs from frame to frame; the rest is common to all frames"""
    poses: Array | None = None
    """(F, 6): rvec (rad) and tvec (m) at each frame; they differ where the camera drifted"""
    scale: float = 1.0
    """factor on the standard deviations stated for the corners (in px where none were stated)"""
    placement: MarkerPlacement | None = None
    """where the markers sit, if it was estimated; alpha then uses it"""
    depth: tuple[PlacedNumber, ...] = ()
    """how far each marker lies before the arm's plane"""
    drift: tuple[DriftTerm, ...] = field(default_factory=tuple)
    row_time: RowTime | None = None
    """what the motion says of a rolling shutter's rows beyond what the corners were corrected by; None without times"""
    shake: CameraShake | None = None
    """what the base markers show of a camera that shakes; None where they hardly move"""
    shake_left_px: float = 0.0
    """standard deviation, in each direction, of what a corrected shake leaves, as the residuals show it"""
    noise_by_frames: tuple[float, ...] = ()
    """factor on each joint's noise that the scatter from frame to frame asked for, beyond `scale`"""

    @property
    def notes(self) -> dict[str, Any]:
        """Placement and drift as plain values for JSON."""
        notes: dict[str, Any] = {
            "noise_scale": self.scale,
            "noise_by_frames": list(self.noise_by_frames),
            "drift": [
                {
                    "kind": d.kind,
                    "frame": d.frame,
                    "time_s": d.time,
                    "size_px": d.size_px,
                    "sigma_px": d.sigma_px,
                    "scale": d.scale,
                    "change": {"rvec": d.change[:3].tolist(), "tvec_m": d.change[3:].tolist()},
                    "sentence": d.sentence,
                }
                for d in self.drift
            ],
            "shake": self.shake.as_json() if self.shake and self.shake.is_sure else None,
            "depth": [n.as_json() for n in self.depth],
        }
        if self.placement is not None:
            notes["placement"] = [n.as_json() for n in self.placement.numbers]
        return notes


def fit_linkage(
    neck: Neck,
    camera: Camera,
    corners: Array,
    where: str,
    *,
    covariance: Floats | None = None,
    time: Array | None = None,
    options: LinkageOptions = LinkageOptions(),  # noqa: B008 (frozen)
    corrected: CameraShake | None = None,
) -> LinkageFit:
    """Angles from corners of shape (F, markers, 4, 2), px as detected, NaN where a marker was not found.

    covariance: of each marker's corners x1, y1, x2, ..., (F, markers, 8, 8), px^2, NaN or None where not known; only its
    proportions count, its scale is estimated from the residuals. time: (F,), s, to name the moment of a drift
    and to tell a rolling shutter. corrected: a shake of the camera by which the corners were moved back; sigma holds its error.

    Raises Refused where no marker is on the base bar, or too few frames show what the pose needs.
    """
    fit = fit_shared(neck, camera, corners, where, covariance, time, options)
    focal = float(np.sqrt(camera.K[0, 0] * camera.K[1, 1]))
    chosen = np.unique(np.linspace(0, len(corners) - 1, MAX_FRAMES).astype(int))
    observed = whiten_corners(camera, fit.image[chosen], None if covariance is None else covariance[chosen])
    components = estimate_components(fit, observed, chosen, corrected is not None)
    unseen = np.zeros(len(corners)) if corrected is None else corrected.unseen_variance / focal**2
    shared_shift = components.shared_shift + unseen
    parts = []
    for start in range(0, len(corners), CHUNK_FRAMES):
        frames = np.arange(start, min(start + CHUNK_FRAMES, len(corners)))
        stated = None if covariance is None else covariance[frames]
        parts.append(
            _angles(fit, camera, frames, stated, components, shared_shift[frames], focal, options.systematic_px / focal)
        )
    alpha, told, untold, common, residual, squares, freedom = (
        np.concatenate(column) for column in zip(*parts, strict=True)
    )
    noise = told * moderated_variances(squares, freedom)[:, None, None] + untold
    certain = np.sqrt(np.diagonal(noise, axis1=1, axis2=2)) < MAX_SIGMA_RAD
    poses = poses_by_frame(fit.shared, fit.course)
    typical = 1.0 if covariance is None else _typical_px(covariance)
    return LinkageFit(
        alpha=np.where(certain, alpha, np.nan),
        covariance=noise + common,
        rvec=poses[0, :3],
        tvec=poses[0, 3:],
        pose_sigma=np.sqrt(np.diag(fit.total_covariance)[:6]),
        corner_sigma_px=float(np.sqrt(fit.variance)) * typical,
        residual_px=residual,
        noise=noise,
        poses=poses,
        scale=float(np.sqrt(fit.variance)),
        placement=None if options.placement is None else describe_placement(neck, fit, options.placement),
        depth=describe_depth(neck, fit),
        drift=fit.drift,
        shake=corrected or camera_shake(fit, camera, corners, alpha, covariance),
        shake_left_px=focal * float(np.sqrt(components.shared_shift)),
        row_time=None if time is None else row_time(fit, camera, corners, time, alpha, covariance),
    )


def _angles(
    fit: SharedFit,
    camera: Camera,
    frames: NDArray[np.intp],
    stated: Floats | None,
    components: ErrorComponents,
    shared_shift: Array,
    focal: float,
    offset_sigma: float,
) -> tuple[Array, Array, Array, Array, Array, Array, Array]:
    """Of some frames: alpha; its covariance by noise of the stated size, by shifts of the picture and in directions that no corner
    tells, and by the shared parameters; the RMS residual in px; the sum of squares of whitened residuals with degrees of freedom.

    stated: covariance of the corners; components: of their errors; shared_shift: variance of shifts of the picture in each
    direction, (F,), normalised coordinates; focal: px; offset_sigma: of lasting corner offsets, normalised coordinates.
    """
    observed = whiten_corners(camera, fit.image[frames], stated)
    first = fit.first_angles(frames)
    n = first.shape[1]
    alpha, equations = fit_angles(
        fit.scene, observed, fit.shared, first, fit.course[frames], float(np.sqrt(fit.variance))
    )
    by_angles = np.swapaxes(whiten(observed, fit.scene.by_angles(fit.shared, alpha, fit.course[frames])), 1, 2)
    spread = by_angles.reshape(len(frames), n, -1, 8).swapaxes(1, 2) @ components.whitened_errors(observed)
    told = equations.inverse @ (spread @ np.swapaxes(spread, 2, 3)).sum(axis=1) @ equations.inverse
    # nothing of a direction without information is in the inverse
    untold = inverse_normals(equations.normal, UNDETERMINED_VARIANCE) - equations.inverse
    by_shift = equations.inverse @ (by_angles @ shared_shift_slopes(observed))
    untold = untold + shared_shift[:, None, None] * (by_shift @ np.swapaxes(by_shift, 1, 2))
    by_shared = -equations.inverse @ equations.mixed  # d alpha / d shared of the least squares, (F, N, p)
    common = by_shared @ fit.covariance @ np.swapaxes(by_shared, 1, 2)
    if fit.offset_gain is not None:
        # lasting offsets change an angle directly, and by way of the shared parameters
        direct = offset_sigma * offset_sensitivity(fit.scene, observed, fit.shared, alpha, fit.course[frames]).on_angles
        total = direct + by_shared @ fit.offset_gain
        common = common + total @ np.swapaxes(total, 1, 2)
    squares = np.sum(np.abs(focal * equations.residual) ** 2, axis=(1, 2))
    residual = np.sqrt(squares / np.maximum(4 * observed.visible.sum(axis=1), 1))
    return alpha, told, untold, common, residual, equations.squares, degrees_of_freedom(observed, n)


def _typical_px(covariance: Floats) -> float:
    """Median over all observations of the stated standard deviation of a corner's coordinate, px."""
    spread = np.diagonal(covariance, axis1=-2, axis2=-1).mean(axis=-1, dtype=float)
    known = spread[np.isfinite(spread)]
    return float(np.sqrt(np.median(known))) if known.size else 1.0
