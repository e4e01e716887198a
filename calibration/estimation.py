"""Views of a board -> camera, its uncertainty, and a refusal where the views cannot tell.

The reported sigma is the larger of two: of least squares, and of the jackknife that leaves out one view after another.
Corner errors of one picture have causes in common (print, blur, board shape), so that least squares, which takes every
corner for independent, comes out two to three times too small on real sets.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from calibration import lens
from calibration.bundle import DEFAULT_FREE, Fit, Poses, fit, start
from calibration.camera import Camera, camera_from
from calibration.corners import BoardView
from calibration.views import LeftOut, Observations
from xneck.errors import Refused

MIN_VIEWS = 6
_MIN_TILT = np.radians(10.0)  # largest angle between two boards
_MAX_FOCAL_SIGMA = 0.02  # of the focal length
_DISAGREES = 3.0  # a view's rms over the median of the others


@dataclass(frozen=True)
class PictureUse:
    """What became of one picture."""

    name: str
    used: bool
    why: str  # "" where used
    rms_px: float | None = None
    held_out_rms_px: float | None = None


@dataclass(frozen=True)
class Calibration:
    """A camera and what it was estimated from. Errors in px are root mean square distances over corners."""

    camera: Camera
    rms_px: float
    held_out_rms_px: float  # each view predicted by a camera estimated without it, only its pose fitted
    pictures: tuple[PictureUse, ...]
    sigma_least_squares: np.ndarray  # order of lens.NAMES, shape (9,)
    sigma_jackknife: np.ndarray  # the same by leaving out one view, shape (9,)
    free: tuple[str, ...]  # names of the estimated parameters
    corners: int  # number of corners used
    tilt: float  # largest angle between two boards, rad
    views: tuple[BoardView, ...]  # those used
    poses: Poses  # of those used
    notes: tuple[str, ...]  # what a person should know, in sentences


@dataclass(frozen=True)
class _LeaveOneOut:
    """One fit without each view, and that view's error when predicted by it."""

    parameters: np.ndarray  # shape (n, 9)
    rms_views: np.ndarray  # shape (n,), px


def calibrate(observations: Observations) -> Calibration:
    """Estimate the camera that took the views.

    Raises Refused for fewer than 6 distinct views, corners that are not finite, boards all tilted alike, views that
    disagree among themselves, and an error far above what corner finding leaves.
    """
    for view in observations.views:
        if not (np.all(np.isfinite(view.image_points)) and np.all(np.isfinite(view.object_points))):
            raise Refused(view.name, "corner coordinates that are not finite", "leave the picture out")
    views, left_out = _without_repeats(observations)
    _refuse_few(len(views), left_out)
    unexplained = Refused("pictures", "no camera explains the corners", "check board.yaml and take tilted views")
    try:
        parameters, poses = start(views, observations.image_size)
    except cv2.error as error:
        raise unexplained from error
    if not all(np.all(np.isfinite(values)) for values in (parameters, poses.R, poses.t)):
        raise unexplained
    fitted = fit(views, parameters, poses)
    views, fitted, disagreeing = _without_disagreeing(views, fitted)
    left_out += disagreeing
    _refuse_few(len(views), left_out)
    _refuse_poor(fitted, observations.image_size, disagreeing)
    plain = _leave_one_out(views, fitted)
    with_k3 = fit(views, fitted.parameters, fitted.poses, (*DEFAULT_FREE, "k3"))
    out_k3 = _leave_one_out(views, with_k3)
    chosen, out = (with_k3, out_k3) if _clearly_better(out_k3.rms_views, plain.rms_views) else (fitted, plain)
    return _result(observations, views, left_out, chosen, out)


def _without_repeats(observations: Observations) -> tuple[list[BoardView], list[LeftOut]]:
    """Views that differ: one of each pose, since a repeated one adds no information but shrinks sigma."""
    # a board on a table in front of a camera on a tripod moves by less than this
    same = max(1.0, 0.002 * observations.image_size[0])
    kept: list[BoardView] = []
    left_out = list(observations.left_out)
    for view in observations.views:
        for other in kept:
            _, mine, its = np.intersect1d(view.corner_ids, other.corner_ids, return_indices=True)
            moved = np.linalg.norm(view.image_points[mine] - other.image_points[its], axis=1)
            if len(mine) >= 4 and np.sqrt(np.mean(moved**2)) < same:
                left_out.append(LeftOut(view.name, f"the board stands as in {other.name}"))
                break
        else:
            kept.append(view)
    return kept, left_out


def _without_disagreeing(views: list[BoardView], fitted: Fit) -> tuple[list[BoardView], Fit, list[LeftOut]]:
    """Leave out the worst view, refit, and again, while one is far above the others; at most a third of them.

    The error within the fit decides, not the held-out one: a view that alone covers an edge of the picture is hard to
    predict and the most valuable of all.
    """
    left_out: list[LeftOut] = []
    most = len(views) // 3
    while len(left_out) < most and len(views) > 3:
        worst = int(np.argmax(fitted.rms_views))
        others = float(np.median(np.delete(fitted.rms_views, worst)))
        if fitted.rms_views[worst] <= _DISAGREES * others:
            break
        rest = np.delete(np.arange(len(views)), worst)
        agreeing = [views[i] for i in rest.tolist()]
        refitted = fit(agreeing, fitted.parameters, fitted.poses.of(rest))
        error = fit([views[worst]], refitted.parameters, fitted.poses.of([worst]), ()).rms
        why = f"disagrees: {error:.2f} px when predicted from the others, which agree to {refitted.rms:.2f} px"
        left_out.append(LeftOut(views[worst].name, why))
        views, fitted = agreeing, refitted
    return views, fitted, left_out


def _leave_one_out(views: Sequence[BoardView], fitted: Fit) -> _LeaveOneOut:
    parameters = np.empty((len(views), 9))
    rms = np.empty(len(views))
    for i in range(len(views)):
        rest = np.delete(np.arange(len(views)), i)
        without = fit([views[j] for j in rest.tolist()], fitted.parameters, fitted.poses.of(rest), fitted.free)
        parameters[i] = without.parameters
        rms[i] = fit([views[i]], without.parameters, fitted.poses.of([i]), ()).rms
    return _LeaveOneOut(parameters, rms)


def _clearly_better(candidate: np.ndarray, plain: np.ndarray) -> bool:
    """Is the held-out error per view smaller, by 2 % and by two standard errors of the paired difference?

    Logarithms, because one view at the edge of the picture would outweigh all others by its error.
    """
    gain = np.log(plain / candidate)
    return bool(np.mean(gain) > max(0.02, 2 * float(np.std(gain, ddof=1) / np.sqrt(len(gain)))))


def _result(
    observations: Observations,
    views: Sequence[BoardView],
    left_out: Sequence[LeftOut],
    fitted: Fit,
    out: _LeaveOneOut,
) -> Calibration:
    n = len(views)
    away = out.parameters - out.parameters.mean(axis=0)
    sigma_jackknife = np.sqrt((n - 1) / n * np.sum(away**2, axis=0))
    sigma_least_squares = np.sqrt(np.diag(fitted.covariance))
    # the correlations of least squares (a jackknife of few views has no full rank) with the larger sigma of each
    estimated = sigma_least_squares > 0
    grow = np.ones(9)
    grow[estimated] = np.maximum(1.0, sigma_jackknife[estimated] / sigma_least_squares[estimated])
    covariance = fitted.covariance * np.outer(grow, grow)
    counts = np.array([len(view.corner_ids) for view in views])
    held_out = float(np.sqrt(np.sum(counts * out.rms_views**2) / counts.sum()))
    pictures = [PictureUse(entry.name, False, entry.why) for entry in left_out] + [
        PictureUse(view.name, True, "", float(rms), float(held))
        for view, rms, held in zip(views, fitted.rms_views, out.rms_views, strict=True)
    ]
    pictures.sort(key=lambda picture: picture.name)
    notes = [*observations.notes, *_notes(observations.image_size, views, fitted, grow)]
    info = {
        "rms_px": fitted.rms,
        "held_out_rms_px": held_out,
        "corners": int(counts.sum()),
        "notes": notes,
        "pictures": [{"file": picture.name, "used": picture.used, "why": picture.why} for picture in pictures],
    }
    return Calibration(
        camera=camera_from(fitted.parameters, observations.image_size, covariance=covariance, info=info),
        rms_px=fitted.rms,
        held_out_rms_px=held_out,
        pictures=tuple(pictures),
        sigma_least_squares=sigma_least_squares,
        sigma_jackknife=sigma_jackknife,
        free=fitted.free,
        corners=int(counts.sum()),
        tilt=_tilt(fitted.poses),
        views=tuple(views),
        poses=fitted.poses,
        notes=tuple(notes),
    )


def _notes(image_size: tuple[int, int], views: Sequence[BoardView], fitted: Fit, grow: np.ndarray) -> list[str]:
    width, height = image_size
    notes: list[str] = []
    points = np.concatenate([view.image_points for view in views])
    column = np.clip((3 * points[:, 0] / width).astype(int), 0, 2)
    row = np.clip((3 * points[:, 1] / height).astype(int), 0, 2)
    empty = [
        f"{('upper', 'middle', 'lower')[r]} {('left', 'middle', 'right')[c]}".replace("middle middle", "middle")
        for r in range(3)
        for c in range(3)
        if not np.any((column == c) & (row == r))
    ]
    if empty:
        notes.append(f"no corners in these ninths of the picture: {', '.join(empty)}; the lens is a guess there")
    if grow[:2].max() > 1.5:
        notes.append(
            f"the views differ by more than their corners' noise: sigma of the focal length is {grow[:2].max():.1f} "
            "times that of least squares (is the board flat?)"
        )
    border = np.array([[0, 0], [width - 1, 0], [0, height - 1], [width - 1, height - 1]], float)
    if np.any(np.isnan(lens.undistort(border, fitted.parameters))):
        notes.append("the lens model turns back before the picture's corners: do not use it there")
    return notes


def _tilt(poses: Poses) -> float:
    """The largest angle between the planes of two boards, rad."""
    normals = poses.R[:, :, 2]
    # arcsin of the cross product: arccos has no digits for small angles
    cross = np.linalg.norm(np.cross(normals[:, None], normals[None]), axis=2)
    return float(np.max(np.arctan2(cross, normals @ normals.T)))


def _refuse_few(count: int, left_out: Sequence[LeftOut]) -> None:
    if count >= MIN_VIEWS:
        return
    shown = "; ".join(f"{entry.name}: {entry.why}" for entry in left_out[:3])
    more = f" and {len(left_out) - 3} more" if len(left_out) > 3 else ""
    raise Refused(
        "pictures",
        f"{count} distinct views of the board" + (f" (left out: {shown}{more})" if shown else ""),
        f"take {MIN_VIEWS} or more, better 15, tilted by 20 to 40 degrees in all directions, all over the picture",
    )


def _refuse_poor(fitted: Fit, image_size: tuple[int, int], disagreeing: Sequence[LeftOut]) -> None:
    limit = max(1.0, 4e-4 * float(np.hypot(*image_size)))  # px; corner finding leaves 0.05 to 0.5 px
    if fitted.rms > limit:
        also = f" even without {', '.join(entry.name for entry in disagreeing)}" if disagreeing else ""
        raise Refused(
            "pictures",
            f"no camera with this lens model explains the corners: {fitted.rms:.2f} px rms{also}",
            "check the board's columns, rows and sizes, that it is flat, that nothing zoomed or focused between "
            "pictures, and that the lens is no fisheye",
        )
    tilt = _tilt(fitted.poses)
    if tilt < _MIN_TILT:
        raise Refused(
            "pictures",
            f"all boards are tilted alike (within {np.degrees(tilt):.1f} degrees), which cannot tell the focal length",
            "tilt the board by 20 to 40 degrees in different directions",
        )
    focal = fitted.parameters[:2]
    sigma = np.sqrt(np.diag(fitted.covariance))[:2]
    if np.any(focal <= 0) or np.any(sigma > _MAX_FOCAL_SIGMA * focal) or not fitted.converged:
        raise Refused(
            "pictures",
            f"the focal length is known to {100 * float(np.max(sigma / np.abs(focal))):.1f} % only",
            "add views tilted by 20 to 40 degrees in different directions, near enough to fill the picture",
        )
