"""A camera that shakes: the whole picture moves, and a marker on the base tells by how much in each frame.

A base marker that moves in the picture may also be drawn so by the codec, or lie under a shadow. Where the camera moves, all other
markers follow: by which share of the base's motion is one more number that all frames have in common, one where the camera shakes
and none where the base marker alone seems to move. Joints can follow a shift of all markers in part only, so the arm tells it.
Turns about the optical axis are left alone: of a small turn of the camera about any axis the shift is the largest part by far.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibration.camera import Camera
from vision.linkage.block_covariance import clustered_covariance, frame_blocks
from vision.linkage.gauss_newton import extend_prior, solve_scaled
from vision.linkage.linkage_equations import linkage_equations
from vision.linkage.observed_corners import Floats, whiten_corners
from vision.linkage.scene import Scene, poses_by_frame, project_to_image
from vision.linkage.shared_fit import SharedFit

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

MAX_FRAMES = 600
"""frames, spread over the recording, that are asked"""
MAX_LAG = 100
"""frames from one that shows the base, beyond which nothing is known of the shift"""
MIN_RMS_PX = 0.03
"""px: rms motion of the base marker, in its worse direction, below which it is left alone (docs/thresholds.md)"""
LEFT_OUT_SHARE = 0.02
"""of the frames, those of the largest motion, by which it is not judged: one frame may show a picture half moved
(docs/thresholds.md)"""
FOLLOWED_SHARE = (0.5, 2.5)
"""of the base's motion, that the other markers follow where the camera shakes: a codec holds back what stands still
(docs/thresholds.md)"""
SURE_SIGMAS = 4.0
"""standard deviations from which on the other markers do follow (docs/thresholds.md)"""


@dataclass(frozen=True)
class CameraShake:
    """Motion of the whole picture from frame to frame."""

    shift: Array
    """(F, 2), px, about its mean; between the frames that show the base, where one does not"""
    unseen_variance: Array
    """(F,), px^2 in each direction, of the shift of frames that do not show the base; zero in the others"""
    followed: float
    """share of the base's motion that the other markers follow"""
    sigma: float
    """standard deviation of `followed`"""

    @property
    def rms_px(self) -> Array:
        """rms of the shift, (2,): along the picture's rows and columns."""
        return np.sqrt(np.mean(self.shift**2, axis=0))

    @property
    def is_sure(self) -> bool:
        """Whether the other markers move with the base's."""
        low, high = FOLLOWED_SHARE
        return low < self.followed < high and self.followed > SURE_SIGMAS * self.sigma

    @property
    def sentence(self) -> str:
        """What happened, in words."""
        x, y = self.rms_px
        most = float(np.linalg.norm(self.shift, axis=1).max())
        return (
            f"the camera shakes, or was knocked: the picture moves by {x:.2f} px rms along its rows and {y:.2f} px along "
            f"its columns, {most:.2f} px at most; corrected by the marker on the base; fix the camera to the base"
        )

    def as_json(self) -> dict[str, Any]:
        """The record for --json."""
        x, y = self.rms_px.tolist()
        return {"rms_px": [x, y], "followed": self.followed, "sigma": self.sigma, "sentence": self.sentence}


def camera_shake(
    fit: SharedFit, camera: Camera, corners: Array, alpha: Array, covariance: Floats | None
) -> CameraShake | None:
    """What a fit to corners (F, markers, 4, 2), px, with its angles (F, N), rad, shows of a shake beside its drift; None where the
    base marker hardly moves.

    covariance: of the corners, as `fit_linkage` takes it.
    """
    base = on_base(fit.scene)
    drifted = _shift_of_base(fit.image[:, base] - _drift_of_base(fit, base))
    seen = np.flatnonzero(np.isfinite(drifted))
    known = seen[np.isfinite(alpha[seen]).all(axis=1)]
    focal = float(np.sqrt(camera.K[0, 0] * camera.K[1, 1]))
    if len(known) < 2 or focal * _usual_motion(drifted[known]) < MIN_RMS_PX:
        return None
    frames = known[np.unique(np.linspace(0, len(known) - 1, MAX_FRAMES).astype(int))]
    followed, sigma = _followed_share(fit, camera, frames, drifted[frames], alpha[frames], covariance)
    moved = _shift_of_base(corners[:, base].astype(complex) @ np.array([1, 1j]))
    shift = np.stack([np.interp(np.arange(len(moved)), seen, part[seen]) for part in (moved.real, moved.imag)], axis=1)
    return CameraShake(shift, _unseen_variance(moved, seen), followed, sigma)


def on_base(scene: Scene) -> NDArray[np.bool_]:
    """Which markers are on the base bar, (markers,)."""
    return np.array([marker.bar == 0 for marker in scene.markers.on_bars])


def _drift_of_base(fit: SharedFit, base: NDArray[np.bool_]) -> Complex:
    """Corners of the base markers as the fit has them, (F, base markers, 4), normalised; they move by the camera's drift only."""
    straight = np.zeros((1, fit.scene.arm.N))  # they do not move with the arm
    along, height = fit.scene.points(fit.shared.placement, fit.shared.lengths, straight)
    return project_to_image(along[:, base], height[base], poses_by_frame(fit.shared, fit.course))


def _shift_of_base(image: Complex) -> Complex:
    """Shift of base markers (F, markers, 4) about its mean, (F,), NaN where none was found."""
    middle = image.mean(axis=2)
    found = ~np.isnan(middle)
    away = np.where(found, middle - np.where(found, middle, 0).sum(axis=0) / np.maximum(found.sum(axis=0), 1), 0)
    count = found.sum(axis=1)
    return np.where(count > 0, away.sum(axis=1) / np.maximum(count, 1), np.nan)


def _usual_motion(shift: Complex) -> float:
    """rms of a shift (F,) in its worse direction, without the few frames in which it is largest."""
    size = np.abs(shift)
    usual = shift[size <= np.quantile(size, 1 - LEFT_OUT_SHARE)]
    return float(max(np.std(usual.real), np.std(usual.imag)))


def _followed_share(
    fit: SharedFit, camera: Camera, frames: NDArray[np.intp], shift: Complex, alpha: Array, covariance: Floats | None
) -> tuple[float, float]:
    """Share of the base's shift (F,), normalised, that the other markers follow in some frames, and its standard deviation.

    The standard deviation follows from the scatter over the recording."""
    of_others = shift[:, None] * ~on_base(fit.scene)
    size = 1 / float(np.sqrt(np.mean(np.abs(shift) ** 2)))  # in units in which it does about as much as the others
    observed = whiten_corners(camera, fit.image[frames], None if covariance is None else covariance[frames])
    scale = float(np.sqrt(fit.variance))
    beside = np.broadcast_to(size * of_others[..., None, None], (*observed.image.shape, 1))
    equations = linkage_equations(fit.scene, observed, fit.shared, alpha, fit.course[frames], 0, scale, beside)
    prior = extend_prior(fit.prior, np.zeros(1))
    free, known_before = prior.free, prior.information[prior.free]
    information, score = equations.reduced[:, free][:, :, free], equations.g_reduced[:, free]
    away = (prior.mean - np.append(fit.shared.vector, 0.0))[free]
    total = information.sum(axis=0) + np.diag(known_before * fit.variance)
    change = solve_scaled(total, score.sum(axis=0) + known_before * fit.variance * away)
    block = frame_blocks(len(fit.image))[frames]
    by_block = np.zeros((block.max() + 1, *total.shape)), np.zeros((block.max() + 1, len(total)))
    np.add.at(by_block[0], block, information)
    np.add.at(by_block[1], block, score - information @ change)
    spread = clustered_covariance(*by_block, known_before, fit.variance)
    return size * float(change[-1]), size * float(np.sqrt(spread[-1, -1]))


def _unseen_variance(moved: Complex, seen: NDArray[np.intp]) -> Array:
    """Variance of the shift in each direction, (F,), px^2, where it is taken from frames nearby: half the mean square of how far it
    goes in as many frames, in both directions together.

    moved: (F,), px; seen: the frames that show the base."""
    frame = np.arange(len(moved))
    after = np.clip(np.searchsorted(seen, frame), 0, len(seen) - 1)
    lag = np.minimum(np.abs(frame - seen[after]), np.abs(frame - seen[np.maximum(after - 1, 0)]))
    variance = np.zeros(len(moved))
    everywhere = float(np.nanmean(np.abs(moved) ** 2))  # half of twice the variance of both directions
    variance[lag > MAX_LAG] = everywhere
    for k in np.unique(lag[(lag > 0) & (lag <= MAX_LAG)]):
        step = np.abs(moved[k:] - moved[:-k]) ** 2
        variance[lag == k] = np.nanmean(step) / 2 if np.isfinite(step).any() else everywhere
    return variance
