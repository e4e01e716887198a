"""Does a calibration still hold? Comparison of a camera with new pictures of a board.

First the camera is fixed and only the board's poses are fitted. Then the camera is refitted to the new pictures, and the change
of its parameters is compared with both uncertainties, that of the calibration and that of the new pictures. Corner errors that
the new pictures have in common (print, board shape) widen the latter, by the scatter of the views' gradients.

The change is tested as a whole, and each kind of change that happens to cameras is tested alone: a change of the focal length
alone is detected when it is several times smaller than one among nine free parameters could be.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import cv2
import numpy as np

from calibration import lens
from calibration.board_poses import BoardPoses
from calibration.bundle_adjustment import DEFAULT_FREE_PARAMETERS, BundleFit, BundleStart, fit_bundle
from calibration.camera import Camera
from calibration.camera_comparison import CameraComparison, compare_cameras, direction_difference
from calibration.corner_detection import BoardView
from calibration.observations import LeftOut, Observations
from calibration.refusals import refuse_impossible_corners
from calibration.stacked_views import stack_views
from xneck_foundation.one_blas_thread import one_blas_thread

MIN_VIEWS = 3
"""usable pictures that a check needs (docs/thresholds.md)"""
_FALSE_ALARM_RATE = 0.001
"""probability of "does not hold" where nothing changed (docs/thresholds.md)"""
_MAX_FOCAL_CHANGE = 0.02
"""share of the focal length: where three standard deviations are more, the pictures cannot tell (docs/thresholds.md)"""
_MAX_RMS_SHARE = 2e-3
"""error of the refitted camera as a share of the picture's diagonal, above which the corners are those of another board
(docs/thresholds.md)"""
_MAX_RMS_RATIO = 3.0
"""a view's rms over the median of the others, above which it disagrees (docs/thresholds.md)"""
_MAX_RMS_GROWTH = 2.0
"""rms of the refitted camera over that of the calibration, above which it is noted (docs/thresholds.md)"""
Verdict = Literal["holds", "does not hold", "cannot tell"]


@dataclass(frozen=True)
class CameraCheck:
    """Whether a camera explains new pictures, and what changed where it does not."""

    verdict: Verdict
    why: str  # the reason for the verdict, in words
    rms_px: float | None  # only poses fitted; None where the pictures could not be compared with the camera
    rms_refitted_px: float | None  # camera and poses fitted
    rms_calibration_px: float | None  # of the calibration, where the camera's file states it
    significance: float | None  # probability of so large a change where nothing changed
    change: np.ndarray  # of the parameters, order of lens.PARAMETER_NAMES, shape (9,)
    change_sigma: np.ndarray  # of calibration and new pictures together, shape (9,)
    change_px: float | None  # of projection over the picture, the orientation refitted, rms
    change_rad: float | None  # change_px as an angle between directions
    used: tuple[str, ...]
    left_out: tuple[LeftOut, ...]
    notes: tuple[str, ...]

    def as_json(self) -> dict[str, Any]:
        """The record for --json."""
        return {
            "verdict": self.verdict,
            "why": self.why,
            "rms_px": self.rms_px,
            "rms_refitted_px": self.rms_refitted_px,
            "rms_calibration_px": self.rms_calibration_px,
            "probability_if_unchanged": self.significance,
            "change": dict(zip(lens.PARAMETER_NAMES, self.change.tolist(), strict=True)),
            "change_sigma": dict(zip(lens.PARAMETER_NAMES, self.change_sigma.tolist(), strict=True)),
            "change_px": self.change_px,
            "change_ray_rad": self.change_rad,
            "pictures": [{"file": name, "used": True, "why": ""} for name in self.used]
            + [{"file": entry.name, "used": False, "why": entry.why} for entry in self.left_out],
            "notes": list(self.notes),
        }


@one_blas_thread
def check_camera(camera: Camera, observations: Observations) -> CameraCheck:
    """Does `camera` explain what was observed? Raises Refused for corners that are not finite.

    The rate of false alarms is 0.1 % where both uncertainties are honest.
    """
    if observations.image_size != camera.size:
        return _other_size(camera, observations)
    posed = _posed(camera, observations)
    if len(posed.views) < MIN_VIEWS:
        count = len(posed.views)
        why = f"{count} usable picture{'' if count == 1 else 's'} of the board, {MIN_VIEWS} are needed, better 8"
        return _without_fit(camera, "cannot tell", f"too few pictures: {why}", posed.views, posed.left_out)
    free = _free(camera)
    try:
        posed, refitted = _refit(camera, posed, free, len(observations.views))
        if not refitted.rms < _MAX_RMS_SHARE * float(np.hypot(*camera.size)):
            why = f"no camera explains these corners ({refitted.rms:.1f} px): is it the board of board.yaml, and flat?"
            return _without_fit(camera, "cannot tell", why, posed.views, posed.left_out)
        fixed = fit_bundle(stack_views(posed.views), BundleStart(camera.parameters, posed.poses), ())
        # a single linear step from the camera as it was: where the pictures say little, an iterated fit diverges
        comparison = compare_cameras(camera, posed.views, fixed, free)
        significance = comparison.significance()
        changed = significance < _FALSE_ALARM_RATE
        if changed:  # then the pictures do determine the change, and a large one is not linear
            comparison = compare_cameras(camera, posed.views, refitted, free)
    except np.linalg.LinAlgError:
        why = "the pictures do not determine a camera: tilt the board by 20 to 40 degrees in different directions"
        return _without_fit(camera, "cannot tell", why, posed.views, posed.left_out)
    verdict = _verdict(camera, comparison, changed, fixed, refitted)
    change, change_sigma = np.zeros(9), np.zeros(9)
    columns = [lens.PARAMETER_NAMES.index(name) for name in free]
    change[columns] = comparison.change
    change_sigma[columns] = np.sqrt(np.diag(np.linalg.inv(comparison.weight)))
    return CameraCheck(
        verdict=verdict.word,
        why=verdict.why,
        rms_px=fixed.rms,
        rms_refitted_px=refitted.rms,
        rms_calibration_px=_calibration_rms(camera),
        significance=significance,
        change=change,
        change_sigma=change_sigma,
        change_px=verdict.change_px,
        change_rad=verdict.change_rad,
        used=tuple(view.name for view in posed.views),
        left_out=tuple(posed.left_out),
        notes=(*observations.notes, *_notes(camera, refitted)),
    )


@dataclass(frozen=True)
class _PosedViews:
    """Views with an initial pose each, and the pictures left out."""

    views: list[BoardView]
    poses: BoardPoses
    left_out: list[LeftOut]


@dataclass(frozen=True)
class _Verdict:
    """The verdict, and how far directions differ between the cameras."""

    word: Verdict
    why: str
    change_px: float
    change_rad: float


def _refit(camera: Camera, posed: _PosedViews, free: Sequence[str], pictures: int) -> tuple[_PosedViews, BundleFit]:
    """The views that agree with one another, at least two thirds of the `pictures`, and the camera refitted to them."""
    views, poses, left_out = posed.views, posed.poses, list(posed.left_out)
    refitted = fit_bundle(stack_views(views), BundleStart(camera.parameters, poses), free)
    while (worst := _disagreeing(refitted)) is not None and len(views) > max(MIN_VIEWS, 2 * pictures // 3):
        left_out.append(LeftOut(views[worst].name, f"disagrees with the others: {refitted.rms_views[worst]:.2f} px"))
        views, poses = [*views[:worst], *views[worst + 1 :]], poses.of(np.delete(np.arange(len(views)), worst))
        refitted = fit_bundle(stack_views(views), BundleStart(camera.parameters, poses), free)
    return _PosedViews(views, poses, left_out), refitted


def _verdict(
    camera: Camera, comparison: CameraComparison, changed: bool, fixed: BundleFit, refitted: BundleFit
) -> _Verdict:
    """The verdict with its reason, from a comparison that found a significant change or none."""
    if changed:
        return _what_changed(camera, comparison)
    px, rad = direction_difference(camera, refitted.parameters)
    focal_sigma = comparison.focal_sigma
    if 3 * focal_sigma > _MAX_FOCAL_CHANGE:
        why = (
            f"these pictures tell the focal length to {100 * focal_sigma:.1f} % only, and nothing beyond that changed: tilt "
            "the board by 20 to 40 degrees in different directions, near enough to fill the picture, and take more"
        )
        return _Verdict("cannot tell", why, px, rad)
    why = (
        f"{fixed.rms:.3f} px with the camera as it was, {refitted.rms:.3f} px with one fitted to these pictures; a focal "
        f"length changed by more than {300 * focal_sigma:.2g} % would have been seen"
    )
    return _Verdict("holds", why, px, rad)


def _notes(camera: Camera, refitted: BundleFit) -> list[str]:
    """What a person should know of the comparison, in sentences."""
    notes = []
    calibration_rms = _calibration_rms(camera)
    if camera.covariance is None:
        notes.append("the camera's file has no covariance: it was taken as exact, which finds changes too easily")
    if calibration_rms is not None and refitted.rms > _MAX_RMS_GROWTH * calibration_rms:
        notes.append(
            f"any camera leaves {refitted.rms:.2f} px of these pictures, the calibration left {calibration_rms:.2f}: are they "
            "sharp, is the board the same and flat?"
        )
    return notes


def _calibration_rms(camera: Camera) -> float | None:
    """The error of the calibration, px, where the camera's file states it."""
    rms = camera.info.get("rms_px")
    return float(rms) if isinstance(rms, int | float) else None


def _other_size(camera: Camera, observations: Observations) -> CameraCheck:
    """The result for pictures of another size than the camera's."""
    (w, h), (width, height) = observations.image_size, camera.size
    why = f"the pictures are {w} x {h} px, the camera was calibrated at {width} x {height}"
    if (w, h) == (height, width):
        why += " (turned?)"
    elif abs(w / h - width / height) < 0.01:
        why += f" (scaled by {w / width:.3g}, or cut?)"
    return _without_fit(camera, "does not hold", why, observations.views, observations.left_out)


def _without_fit(
    camera: Camera,
    verdict: Verdict,
    why: str,
    views: Sequence[BoardView],
    left_out: Sequence[LeftOut],
) -> CameraCheck:
    """A verdict that needs no fit, or where none succeeded."""
    return CameraCheck(
        verdict=verdict,
        why=why,
        rms_px=None,
        rms_refitted_px=None,
        rms_calibration_px=_calibration_rms(camera),
        significance=None,
        change=np.zeros(9),
        change_sigma=np.zeros(9),
        change_px=None,
        change_rad=None,
        used=tuple(view.name for view in views),
        left_out=tuple(left_out),
        notes=(),
    )


def _free(camera: Camera) -> tuple[str, ...]:
    """The parameters that the calibration estimated; without a covariance the default ones, and k3 where it is not zero."""
    if camera.covariance is not None and np.any(camera.covariance):
        return tuple(
            name
            for name, variance in zip(lens.PARAMETER_NAMES, np.diag(camera.covariance), strict=True)
            if variance > 0
        )
    return (*DEFAULT_FREE_PARAMETERS, "k3") if camera.distortion[4] else DEFAULT_FREE_PARAMETERS


def _posed(camera: Camera, observations: Observations) -> _PosedViews:
    """The views with initial poses from the rays of the camera as it was."""
    views, R, t = [], [], []
    left_out = list(observations.left_out)
    refuse_impossible_corners(observations)
    for view in observations.views:
        rays = camera.rays(view.image_points)
        if np.any(np.isnan(rays)):
            left_out.append(LeftOut(view.name, "reaches beyond where the lens model has an inverse"))
            continue
        solved, rvec, tvec = cv2.solvePnP(view.object_points, rays, np.eye(3), np.zeros(4), flags=cv2.SOLVEPNP_IPPE)
        if not solved or tvec[2] <= 0:
            left_out.append(LeftOut(view.name, "no pose of the board explains it"))
            continue
        views.append(view)
        R.append(cv2.Rodrigues(rvec)[0])
        t.append(tvec.ravel())
    return _PosedViews(views, BoardPoses(np.array(R).reshape(-1, 3, 3), np.array(t).reshape(-1, 3)), left_out)


def _disagreeing(refitted: BundleFit) -> int | None:
    """Index of the view whose error is far above that of the others; None where there is none."""
    worst = int(np.argmax(refitted.rms_views))
    others = float(np.median(np.delete(refitted.rms_views, worst)))
    return worst if refitted.rms_views[worst] > _MAX_RMS_RATIO * others else None


def _what_changed(camera: Camera, comparison: CameraComparison) -> _Verdict:
    """The verdict for a significant change, with the change in words."""
    kinds = comparison.named()
    change = np.zeros(9)
    change[[lens.PARAMETER_NAMES.index(name) for name in comparison.free]] = comparison.alone(kinds)[0]
    percent = 100 * change[:2] / camera.parameters[:2]
    words = []
    if "aspect" in kinds:
        words.append(f"fx changed by {percent[0]:+.2g} %, fy by {percent[1]:+.2g} % (picture stretched?)")
    elif "focal length" in kinds:
        words.append(f"focal length changed by {np.mean(percent):+.2g} % (lens refocused or zoomed?)")
    if "principal point" in kinds:
        words.append(
            f"principal point moved by {np.hypot(*change[2:4]):.1f} px (picture cut otherwise, lens knocked, or stabilised?)"
        )
    if "distortion" in kinds:
        words.append("distortion changed (another lens, or corrected by the camera itself?)")
    px, rad = direction_difference(camera, camera.parameters + change)
    why = f"{'; '.join(words)}; directions differ by {px:.2g} px or {np.degrees(rad):.2g} deg over the picture"
    return _Verdict("does not hold", why, px, rad)
