"""Selection of views: each pose once, none that disagrees with the others; and notes on single corners far off."""

from collections.abc import Sequence

import numpy as np

from calibration.bundle_adjustment import BundleFit, BundleStart, fit_bundle, fit_noise, prediction_distances
from calibration.corner_detection import BoardView
from calibration.observations import LeftOut
from calibration.stacked_views import StackedViews

_MAX_RMS_RATIO = 3.0
"""a view's rms over the median of the others, above which it disagrees (docs/thresholds.md)"""
_OUTLIER_SIGMA = 6.0
"""standard deviations of a coordinate, above which a corner's distance is noted (docs/thresholds.md)"""
_SAME_POSE_SHARE = 0.002
"""RMS motion of the corners as a share of the picture's width, below which two views have the same pose (1 px at least)
(docs/thresholds.md)"""


def drop_repeated_views(
    views: Sequence[BoardView], image_size: tuple[int, int]
) -> tuple[list[BoardView], list[LeftOut]]:
    """One view of each pose, and those left out: a repeated pose adds no information but reduces the standard deviation."""
    # a board on a table in front of a camera on a tripod moves by less than this
    same = max(1.0, _SAME_POSE_SHARE * image_size[0])
    kept: list[BoardView] = []
    left_out: list[LeftOut] = []
    for view in views:
        for other in kept:
            _, in_view, in_other = np.intersect1d(view.corner_ids, other.corner_ids, return_indices=True)
            motion = np.linalg.norm(view.image_points[in_view] - other.image_points[in_other], axis=1)
            if len(in_view) >= 4 and np.sqrt(np.mean(motion**2)) < same:
                left_out.append(LeftOut(view.name, f"the board stands as in {other.name}"))
                break
        else:
            kept.append(view)
    return kept, left_out


def drop_disagreeing_views(
    views: Sequence[BoardView], stack: StackedViews, fitted: BundleFit, noise: float
) -> tuple[np.ndarray, BundleFit, list[LeftOut]]:
    """Leave out the worst view and refit, as long as its error is far above that of the others; at most a third of the views.

    Returns the indices of the views kept, their fit, and the views left out. The error within the fit decides, not the held-out
    one: a view that alone covers an edge of the picture is hard to predict and the most valuable of all. The error is Huber's
    loss, so that a few bad corners do not cost a view.
    """
    left_out: list[LeftOut] = []
    kept = np.arange(len(views))
    max_left_out = len(views) // 3
    while len(left_out) < max_left_out and len(kept) > 3:
        errors = fitted.robust_rms_views
        worst = int(np.argmax(errors))
        others = float(np.median(np.delete(errors, worst)))
        if errors[worst] <= _MAX_RMS_RATIO * others:
            break
        rest = np.delete(np.arange(len(kept)), worst)
        refitted = fit_bundle(
            stack.of(kept[rest]), BundleStart(fitted.parameters, fitted.poses.of(rest)), fitted.free, noise=noise
        )
        worst_view = stack.of(kept[[worst]])
        distances = prediction_distances(
            worst_view, refitted.parameters[None], refitted.shape.points[None], fitted.poses.of([worst]), steps=20
        )
        error = float(np.sqrt(np.sum(distances**2) / worst_view.visible.sum()))
        why = f"disagrees: {error:.2f} px when predicted from the others, which agree to {refitted.rms:.2f} px"
        left_out.append(LeftOut(views[int(kept[worst])].name, why))
        kept, fitted = kept[rest], refitted
    return kept, fitted, left_out


def outlier_corner_notes(views: Sequence[BoardView], stack: StackedViews, fitted: BundleFit) -> list[str]:
    """The views with corners so far off that Huber's loss gives them little weight, in sentences."""
    notes: list[str] = []
    far = fitted.distances > _OUTLIER_SIGMA * fit_noise(fitted)
    for view, row, distances in zip(views, far, fitted.distances, strict=True):
        if row.any():
            which = ", ".join(str(i) for i in stack.ids[row][:3]) + (", ..." if row.sum() > 3 else "")
            s = "s" if row.sum() > 1 else ""
            notes.append(f"{view.name}: corner{s} {which} up to {distances.max():.1f} px off, counted for little")
    return notes
