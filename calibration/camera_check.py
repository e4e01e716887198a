"""Does a calibration still hold? New pictures of a board, held against the camera as it was.

With the camera fixed only the board's poses are fitted. Then the camera is refitted to the new pictures, and the change of
its parameters is held against both uncertainties, the calibration's and the new pictures' own. Corner errors that the new
pictures have in common (print, board shape) widen the second as the scatter of the views' gradients says.

Tested are the change as a whole and the changes that happen to cameras, each alone: a change of the focal length alone is
seen when it is several times smaller than one among nine free parameters could be.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, Literal

import cv2
import numpy as np
from scipy.stats import f as fisher

from calibration import lens
from calibration.board_poses import BoardPoses
from calibration.bundle_adjustment import DEFAULT_FREE_PARAMETERS, BundleFit, fit_bundle
from calibration.camera import Camera, camera_from
from calibration.corner_detection import BoardView
from calibration.observations import LeftOut, Observations
from calibration.projection_uncertainty import board_information, rays_by_rotation
from calibration.stacked_views import stack_views
from xneck_foundation.errors import Refused

MIN_VIEWS = 3
_FALSE_ALARM = 0.001
_TELLS = 0.02
"""of the focal length: a change that three sigma of the new pictures would hide makes them unable to tell"""
_NO_BOARD = 2e-3
"""of the picture's diagonal: what any camera leaves of corners that are another board's"""
_DISAGREES = 3.0  # a view's rms over the median of the others
_KINDS = ("focal length", "principal point", "aspect", "distortion")


@dataclass(frozen=True)
class CameraCheck:
    """Whether a camera explains new pictures, and what changed where it does not."""

    verdict: Literal["holds", "does not hold", "cannot tell"]
    why: str  # the sentence after the verdict
    rms_px: float | None  # poses alone fitted; None where the pictures could not be held against the camera
    rms_refitted_px: float | None  # the camera refitted too
    rms_then_px: float | None  # of the calibration itself, where its file says so
    significance: float | None  # probability of so large a change where nothing changed
    change: np.ndarray  # of the parameters, order of lens.NAMES, shape (9,)
    change_sigma: np.ndarray  # of both together, shape (9,)
    change_px: float | None  # of projection over the picture, the orientation refitted, rms
    change_ray: float | None  # the same as an angle between directions, rad
    used: tuple[str, ...]
    left_out: tuple[LeftOut, ...]
    notes: tuple[str, ...]

    def as_json(self) -> dict[str, Any]:
        """For --json."""
        return {
            "verdict": self.verdict,
            "why": self.why,
            "rms_px": self.rms_px,
            "rms_refitted_px": self.rms_refitted_px,
            "rms_calibration_px": self.rms_then_px,
            "probability_if_unchanged": self.significance,
            "change": dict(zip(lens.PARAMETER_NAMES, self.change.tolist(), strict=True)),
            "change_sigma": dict(zip(lens.PARAMETER_NAMES, self.change_sigma.tolist(), strict=True)),
            "change_px": self.change_px,
            "change_ray_rad": self.change_ray,
            "pictures": [{"file": name, "used": True, "why": ""} for name in self.used]
            + [{"file": entry.name, "used": False, "why": entry.why} for entry in self.left_out],
            "notes": list(self.notes),
        }


def check_camera(camera: Camera, observations: Observations) -> CameraCheck:
    """Does `camera` explain what was observed? Raises Refused for corners that are not finite.

    The rate of false alarms is 0.1 % where both uncertainties are honest.
    """
    if observations.image_size != camera.size:
        return _other_size(camera, observations)
    views, poses, left_out = _posed(camera, observations)
    if len(views) < MIN_VIEWS:
        why = f"{len(views)} usable picture{'' if len(views) == 1 else 's'} of the board, {MIN_VIEWS} are needed, better 8"
        return _without_fit(camera, "cannot tell", f"too few pictures: {why}", views, left_out)
    free = _free(camera)
    try:
        refitted = fit_bundle(stack_views(views), camera.parameters, poses, free)
        while (out := _disagreeing(refitted)) is not None and len(views) > max(
            MIN_VIEWS, 2 * len(observations.views) // 3
        ):
            left_out.append(LeftOut(views[out].name, f"disagrees with the others: {refitted.rms_views[out]:.2f} px"))
            views, poses = [*views[:out], *views[out + 1 :]], poses.of(np.delete(np.arange(len(views)), out))
            refitted = fit_bundle(stack_views(views), camera.parameters, poses, free)
        if not refitted.rms < _NO_BOARD * float(np.hypot(*camera.size)):
            why = f"no camera explains these corners ({refitted.rms:.1f} px): is it the board of board.yaml, and flat?"
            return _without_fit(camera, "cannot tell", why, views, left_out)
        fixed = fit_bundle(stack_views(views), camera.parameters, poses, ())
        old = np.zeros((9, 9)) if camera.covariance is None else camera.covariance
        # from the camera as it was a single linear step: where the pictures tell little, an iterated one runs away
        comparison = _compare(camera, old, views, fixed, free)
        # one of five tests may be the most extreme by chance
        every = (*((kind,) for kind in _KINDS), _KINDS)
        significance = min(1.0, 5 * min(comparison.probability(kinds) for kinds in every))
        changed = significance < _FALSE_ALARM
        if changed:  # then the pictures do tell, and a large change is not linear
            comparison = _compare(camera, old, views, refitted, free)
    except np.linalg.LinAlgError:
        why = "the pictures do not determine a camera: tilt the board by 20 to 40 degrees in different directions"
        return _without_fit(camera, "cannot tell", why, views, left_out)
    px, ray = _apart(camera, refitted.parameters)
    notes = []
    then = camera.info.get("rms_px")
    then = float(then) if isinstance(then, int | float) else None
    if camera.covariance is None:
        notes.append("the camera's file has no covariance: it was taken as exact, which finds changes too easily")
    if then is not None and refitted.rms > 2 * then:
        notes.append(
            f"any camera leaves {refitted.rms:.2f} px of these pictures, the calibration left {then:.2f}: are they sharp, "
            "is the board the same and flat?"
        )
    focal_sigma = comparison.focal_sigma
    if changed:
        verdict: Literal["holds", "does not hold", "cannot tell"] = "does not hold"
        why, px, ray = _what_changed(camera, comparison)
    elif 3 * focal_sigma > _TELLS:
        verdict = "cannot tell"
        why = (
            f"these pictures tell the focal length to {100 * focal_sigma:.1f} % only, and nothing beyond that changed: tilt "
            "the board by 20 to 40 degrees in different directions, near enough to fill the picture, and take more"
        )
    else:
        verdict = "holds"
        why = (
            f"{fixed.rms:.3f} px with the camera as it was, {refitted.rms:.3f} px with one fitted to these pictures; a focal "
            f"length changed by more than {300 * focal_sigma:.2g} % would have been seen"
        )
    whole_change, whole_sigma = np.zeros(9), np.zeros(9)
    columns = [lens.PARAMETER_NAMES.index(name) for name in free]
    whole_change[columns], whole_sigma[columns] = comparison.change, np.sqrt(np.diag(np.linalg.inv(comparison.weight)))
    return CameraCheck(
        verdict, why, fixed.rms, refitted.rms, then, significance, whole_change, whole_sigma, px, ray,
        tuple(view.name for view in views), tuple(left_out), (*observations.notes, *notes),
    )  # fmt: skip


def _other_size(camera: Camera, observations: Observations) -> CameraCheck:
    (w, h), (width, height) = observations.image_size, camera.size
    why = f"the pictures are {w} x {h} px, the camera was calibrated at {width} x {height}"
    if (w, h) == (height, width):
        why += " (turned?)"
    elif abs(w / h - width / height) < 0.01:
        why += f" (scaled by {w / width:.3g}, or cut?)"
    return _without_fit(camera, "does not hold", why, observations.views, observations.left_out)


def _without_fit(
    camera: Camera,
    verdict: Literal["does not hold", "cannot tell"],
    why: str,
    views: Sequence[BoardView],
    left_out: Sequence[LeftOut],
) -> CameraCheck:
    then = camera.info.get("rms_px")
    then = float(then) if isinstance(then, int | float) else None
    names = tuple(view.name for view in views)
    zero = np.zeros(9)
    return CameraCheck(verdict, why, None, None, then, None, zero, zero, None, None, names, tuple(left_out), ())


def _free(camera: Camera) -> tuple[str, ...]:
    """Those that the calibration estimated; without a covariance the usual ones and k3 where it is not zero."""
    if camera.covariance is not None and np.any(camera.covariance):
        return tuple(
            name for name, variance in zip(lens.PARAMETER_NAMES, np.diag(camera.covariance), strict=True) if variance > 0
        )
    return (*DEFAULT_FREE_PARAMETERS, "k3") if camera.distortion[4] else DEFAULT_FREE_PARAMETERS


def _posed(camera: Camera, observations: Observations) -> tuple[list[BoardView], BoardPoses, list[LeftOut]]:
    """Views with a first pose each, from the rays of the camera as it was."""
    views, R, t = [], [], []
    left_out = list(observations.left_out)
    for view in observations.views:
        if not (np.all(np.isfinite(view.image_points)) and np.all(np.isfinite(view.object_points))):
            raise Refused(view.name, "corner coordinates that are not finite", "leave the picture out")
        rays = camera.rays(view.image_points)
        if np.any(np.isnan(rays)):
            left_out.append(LeftOut(view.name, "reaches beyond where the lens model has an inverse"))
            continue
        found, rvec, tvec = cv2.solvePnP(view.object_points, rays, np.eye(3), np.zeros(4), flags=cv2.SOLVEPNP_IPPE)
        if not found or tvec[2] <= 0:
            left_out.append(LeftOut(view.name, "no pose of the board explains it"))
            continue
        views.append(view)
        R.append(cv2.Rodrigues(rvec)[0])
        t.append(tvec.ravel())
    return views, BoardPoses(np.array(R).reshape(-1, 3, 3), np.array(t).reshape(-1, 3)), left_out


def _disagreeing(refitted: BundleFit) -> int | None:
    """The view whose error is far above the others', if one is."""
    worst = int(np.argmax(refitted.rms_views))
    others = float(np.median(np.delete(refitted.rms_views, worst)))
    return worst if refitted.rms_views[worst] > _DISAGREES * others else None


def _compare(
    camera: Camera, old: np.ndarray, views: Sequence[BoardView], found: BundleFit, free: Sequence[str]
) -> "_Comparison":
    """The change from `camera` to the optimum that lies one linear step from `found`, and its weight.

    With S_i and g_i the normal matrix and gradient of view i, its pose eliminated, and g_i taken to the optimum, where they
    add up to zero: for independent corner errors of variance s2 the expected sum of g_i' S^-1 g_i is
    s2 sum tr(S^-1 S_i - (S^-1 S_i)^2); errors that a view's corners have in common make it larger, and widen the
    covariance s2 S^-1 by the same factor (never below 1).
    """
    columns = np.array([lens.PARAMETER_NAMES.index(name) for name in free])
    at = np.ix_(columns, columns)
    here = camera_from(found.parameters, camera.size)
    normals, gradients, squares, count = [], [], 0.0, 0
    for view, R, t in zip(views, found.poses.R, found.poses.t, strict=True):
        points = view.object_points @ R.T + t
        rays = points[:, :2] / points[:, 2:]
        left = (lens.rays_to_pixels(rays, found.parameters) - view.image_points).ravel()
        # the pose is at its optimum: the residuals are already free of what it absorbs
        A = lens.parameter_jacobian(rays, found.parameters).reshape(-1, 9)
        normals.append(board_information(here, points)[at])
        gradients.append((A.T @ left)[columns])
        squares, count = squares + float(left @ left), count + len(left)
    scale = np.sqrt(np.diag(sum(normals)))  # k and f differ by orders of magnitude
    scaled = [normal / np.outer(scale, scale) for normal in normals]
    inverse = np.linalg.inv(sum(scaled))
    whole = sum(gradients) / scale
    step = -inverse @ whole
    slopes = [g / scale + normal @ step for g, normal in zip(gradients, scaled, strict=True)]
    variance = (squares - float(whole @ inverse @ whole)) / max(count - 6 * len(views) - len(columns), 1)
    shares = [inverse @ normal for normal in scaled]
    expected = variance * sum(float(np.trace(share - share @ share)) for share in shares)
    grow = max(1.0, sum(float(g @ inverse @ g) for g in slopes) / expected)
    change = (found.parameters - camera.parameters)[columns] + step / scale
    both = variance * grow * inverse / np.outer(scale, scale) + old[at]
    if not np.all(np.diag(both) > 0):
        raise np.linalg.LinAlgError
    size = np.sqrt(np.diag(both))
    weight = np.linalg.inv(both / np.outer(size, size)) / np.outer(size, size)
    freedom = max((len(views) - 1) * len(columns) / 2, 1.0)
    return _Comparison(camera, tuple(free), change, weight, freedom)


def _apart(camera: Camera, parameters: np.ndarray) -> tuple[float, float]:
    """How far two cameras put the same directions apart over the picture, the orientation refitted: rms, px and rad."""
    u, v = (np.linspace(0, side - 1, count) for side, count in zip(camera.size, (16, 12), strict=True))
    rays = camera.rays(np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2))
    rays = rays[np.all(np.isfinite(rays), axis=1)]
    B = (lens.ray_jacobian(rays, camera.parameters) @ rays_by_rotation(rays)).reshape(-1, 3)
    moved = (lens.rays_to_pixels(rays, parameters) - lens.rays_to_pixels(rays, camera.parameters)).ravel()
    left = moved - B @ np.linalg.lstsq(B, moved, rcond=None)[0]
    px = float(np.sqrt(np.mean(left**2) * 2))
    return px, px / float(np.mean(camera.parameters[:2]))


@dataclass(frozen=True)
class _Comparison:
    """The change of the free parameters and its weight (inverse covariance), so that kinds of change are tested alone."""

    camera: Camera
    free: tuple[str, ...]
    change: np.ndarray  # shape (m,)
    weight: np.ndarray  # shape (m, m)
    freedom: float  # of the weight's scale

    def directions(self, kinds: Sequence[str]) -> np.ndarray:
        """Columns that span the changes of these kinds, shape (m, r)."""
        p = dict(zip(lens.PARAMETER_NAMES, self.camera.parameters.tolist(), strict=True))
        columns: list[dict[str, float]] = []
        if "focal length" in kinds:
            columns.append({"fx": p["fx"], "fy": p["fy"]})
        if "aspect" in kinds:
            columns.append({"fx": p["fx"], "fy": -p["fy"]})
        if "principal point" in kinds:
            columns += [{"cx": 1.0}, {"cy": 1.0}]
        if "distortion" in kinds:
            columns += [{name: 1.0} for name in ("k1", "k2", "p1", "p2", "k3")]
        out = np.array([[column.get(name, 0.0) for column in columns] for name in self.free])
        return out[:, np.any(out != 0, axis=0)]

    def alone(self, kinds: Sequence[str]) -> tuple[np.ndarray, float]:
        """The change if only these kinds happened, shape (m,), and how much of the distance it explains."""
        D = self.directions(kinds)
        pull = D.T @ self.weight @ self.change
        size = np.linalg.lstsq(D.T @ self.weight @ D, pull, rcond=1e-15)[0] if D.size else np.zeros(0)
        return D @ size, float(pull @ size)

    def probability(self, kinds: Sequence[str]) -> float:
        """Of so large a change of these kinds where nothing changed."""
        rank = self.directions(kinds).shape[1]
        return float(fisher.sf(self.alone(kinds)[1] / rank, rank, self.freedom)) if rank else 1.0

    @property
    def focal_sigma(self) -> float:
        """Sigma of the focal length's change alone, as a share of it; infinite where it was not estimated."""
        D = self.directions(("focal length",))
        return float((D.T @ self.weight @ D)[0, 0] ** -0.5) if D.size else float("inf")

    def named(self) -> tuple[str, ...]:
        """The fewest kinds that leave nothing significant, or a tenth, of the change."""
        whole = self.alone(_KINDS)[1]
        for count in range(1, len(_KINDS)):
            found = max(combinations(_KINDS, count), key=lambda kinds: self.alone(kinds)[1])
            left = whole - self.alone(found)[1]
            rest = len(self.free) - self.directions(found).shape[1]
            if left < 0.1 * whole or fisher.sf(left / rest, rest, self.freedom) > 0.01:
                return found
        return _KINDS


def _what_changed(camera: Camera, comparison: _Comparison) -> tuple[str, float, float]:
    """In words, and how far directions differ by it, px and rad."""
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
    px, ray = _apart(camera, camera.parameters + change)
    return (
        f"{'; '.join(words)}; directions differ by {px:.2g} px or {np.degrees(ray):.2g} deg over the picture",
        px,
        ray,
    )
