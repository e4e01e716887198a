"""From marker corners to joint angles: the arm as one object in its plane, seen by a calibrated camera.

Unknown are alpha_1..N of every frame and what all frames share: the camera's pose against the base bar, its drift, and on
request where each marker sits on its bar. All markers of all bars enter together through the linkage's geometry, so a bar
whose marker is hidden keeps its angle where its neighbours determine it.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from calibration.camera import Camera
from mechanism.description import Neck
from vision.linkage.camera_motion import DriftTerm
from vision.linkage.gauss_newton import frame_angles, freedom, inverse, offsets
from vision.linkage.observed_corners import PORTION, observed
from vision.linkage.placement import Placement, placement_of
from vision.linkage.scene import frame_poses
from vision.linkage.shared_fit import PlacementPrior, SharedFit, fit_shared

Array = NDArray[np.float64]

MAX_SIGMA = np.radians(3.0)
"""an angle that its frame's corners leave less certain than this counts as not seen"""
CONFESS = 0.99
"""a frame whose residuals exceed this quantile of what noise gives is believed less, in proportion"""
UNKNOWN = 1e12
"""variance of what nothing determines"""


@dataclass(frozen=True)
class LinkageFit:
    """Angles of all frames and what they rest on."""

    alpha: Array
    """(F, N), rad; NaN where the frame's markers do not determine it"""
    covariance: Array
    """(F, N, N), rad^2; of the corners' noise as the residuals show it, and of pose, drift and placement"""
    rvec: Array
    """rotation vector of T_camera_base at the first frame, (3,)"""
    tvec: Array
    """translation of T_camera_base at the first frame, (3,), m"""
    pose_sigma: Array
    """standard deviations of rvec (rad) and tvec (m), (6,)"""
    corner_sigma_px: float
    residual_px: Array
    """RMS corner residual of each frame, (F,), px"""
    noise: Array | None = None
    """(F, N, N), rad^2: the part of `covariance` that differs from frame to frame; the rest is common to all frames"""
    poses: Array | None = None
    """(F, 6): rvec and tvec at each frame, which differ where the camera drifted"""
    scale: float = 1.0
    """by what the standard deviations stated for the corners were multiplied (in px where none were stated)"""
    placement: Placement | None = None
    """where the markers sit, if asked for; alpha rests on it"""
    drift: tuple[DriftTerm, ...] = field(default_factory=tuple)

    @property
    def notes(self) -> dict[str, Any]:
        """Placement and drift as plain values for JSON."""
        notes: dict[str, Any] = {
            "noise_scale": self.scale,
            "drift": [
                {
                    "kind": d.kind,
                    "frame": d.frame,
                    "time_s": d.time,
                    "size_px": d.size_px,
                    "sigma_px": d.sigma_px,
                    "change": {"rvec": d.change[:3].tolist(), "tvec_m": d.change[3:].tolist()},
                    "sentence": d.sentence,
                }
                for d in self.drift
            ],
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
    covariance: Array | None = None,
    time: Array | None = None,
    placement: PlacementPrior | None = None,
    drift: bool = True,
    systematic_px: float = 0.0,
) -> LinkageFit:
    """Angles from corners of shape (F, markers, 4, 2), px as detected, NaN where a marker was not found.

    covariance: of each marker's corners x1, y1, x2, ..., (F, markers, 8, 8), px^2, NaN or None where not known; only its
    proportions count, its scale is estimated from the residuals. time: (F,), s, to name the moment of a drift.
    placement: estimate where each marker sits, within this prior; without it neck.yaml is believed. systematic_px: standard
    deviation of corner offsets that stay the same over the recording.
    Raises Refused where no marker is on the base bar, or too few frames show what the pose needs.
    """
    fit = fit_shared(neck, camera, corners, where, covariance, time, placement, drift, systematic_px)
    focal = float(np.sqrt(camera.K[0, 0] * camera.K[1, 1]))
    parts = []
    for start in range(0, len(corners), PORTION):
        frames = np.arange(start, min(start + PORTION, len(corners)))
        stated = None if covariance is None else covariance[frames]
        parts.append(_angles(fit, camera, frames, stated, focal, systematic_px / focal))
    alpha, noise, common, residual = (np.concatenate(column) for column in zip(*parts, strict=True))
    certain = np.sqrt(np.diagonal(noise, axis1=1, axis2=2)) < MAX_SIGMA
    poses = frame_poses(fit.shared, fit.course)
    typical = 1.0 if covariance is None else _typical_px(covariance)
    return LinkageFit(
        alpha=np.where(certain, alpha, np.nan),
        covariance=noise + common,
        rvec=poses[0, :3],
        tvec=poses[0, 3:],
        pose_sigma=np.sqrt(np.diag(fit.whole_covariance)[:6]),
        corner_sigma_px=float(np.sqrt(fit.variance)) * typical,
        residual_px=residual,
        noise=noise,
        poses=poses,
        scale=float(np.sqrt(fit.variance)),
        placement=None if placement is None else placement_of(neck, fit, placement),
        drift=fit.drift,
    )


def _angles(
    fit: SharedFit, camera: Camera, frames: NDArray[np.intp], stated: Array | None, focal: float, lasting: float
) -> tuple[Array, Array, Array, Array]:
    """alpha, its covariance by noise and by what is shared, and the RMS residual in px, of some frames."""
    seen = observed(camera, fit.image[frames], stated)
    first = fit.first_angles(frames)
    n = first.shape[1]
    alpha, at = frame_angles(fit.scene, seen, fit.shared, first, fit.course[frames], float(np.sqrt(fit.variance)))
    free = freedom(seen, n)
    excess = at.squares / fit.variance
    # a frame that fits worse than noise can explain says so itself
    wrong = excess > chi2.ppf(CONFESS, np.maximum(free, 1))
    noise = inverse(at.normal, UNKNOWN) * fit.variance
    noise = noise * np.where(wrong, excess / np.maximum(free, 1), 1.0)[:, None, None]
    by_shared = -at.solved @ at.mixed  # d alpha / d shared of the least squares, (F, N, p)
    common = by_shared @ fit.covariance @ np.swapaxes(by_shared, 1, 2)
    if fit.offset_gain is not None:
        # what lasting offsets do to an angle directly, and by way of what the frames share
        direct = lasting * offsets(fit.scene, seen, fit.shared, alpha, fit.course[frames]).on_angles
        total = direct + by_shared @ fit.offset_gain
        common = common + total @ np.swapaxes(total, 1, 2)
    squares = np.sum(np.abs(focal * at.residual) ** 2, axis=(1, 2))
    return alpha, noise, common, np.sqrt(squares / np.maximum(4 * seen.seen.sum(axis=1), 1))


def _typical_px(covariance: Array) -> float:
    """Standard deviation of a corner's coordinate as stated, px, in the median of all observations."""
    spread = np.diagonal(covariance, axis1=-2, axis2=-1).mean(axis=-1)
    known = spread[np.isfinite(spread)]
    return float(np.sqrt(np.median(known))) if known.size else 1.0
