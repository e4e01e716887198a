"""Which views may speak: each pose once, none that disagrees with the others; and which single corners count for little."""

from collections.abc import Sequence

import numpy as np

from calibration.bundle_adjustment import BundleFit, fit_bundle, fit_noise, prediction_distances
from calibration.corner_detection import BoardView
from calibration.observations import LeftOut
from calibration.stacked_views import StackedViews

_DISAGREES = 3.0
"""a view's rms over the median of the others"""
_BAD = 6.0
"""sigmas from which on a corner is named"""


def drop_repeated_views(views: Sequence[BoardView], image_size: tuple[int, int]) -> tuple[list[BoardView], list[LeftOut]]:
    """Views that differ: one of each pose, since a repeated one adds no information but shrinks sigma."""
    # a board on a table in front of a camera on a tripod moves by less than this
    same = max(1.0, 0.002 * image_size[0])
    kept: list[BoardView] = []
    left_out: list[LeftOut] = []
    for view in views:
        for other in kept:
            _, mine, its = np.intersect1d(view.corner_ids, other.corner_ids, return_indices=True)
            moved = np.linalg.norm(view.image_points[mine] - other.image_points[its], axis=1)
            if len(mine) >= 4 and np.sqrt(np.mean(moved**2)) < same:
                left_out.append(LeftOut(view.name, f"the board stands as in {other.name}"))
                break
        else:
            kept.append(view)
    return kept, left_out


def drop_disagreeing_views(
    views: Sequence[BoardView], sightings: StackedViews, fitted: BundleFit, noise: float
) -> tuple[np.ndarray, BundleFit, list[LeftOut]]:
    """Leave out the worst view, refit, and again, while one is far above the others; at most a third of them.

    Returns the indices of those that stay and their fit. The error within the fit decides, not the held-out one: a view
    that alone covers an edge of the picture is hard to predict and the most valuable of all. Huber's loss is what counts,
    so that a view does not go for a few bad corners.
    """
    left_out: list[LeftOut] = []
    kept = np.arange(len(views))
    most = len(views) // 3
    while len(left_out) < most and len(kept) > 3:
        errors = fitted.robust_rms_views
        worst = int(np.argmax(errors))
        others = float(np.median(np.delete(errors, worst)))
        if errors[worst] <= _DISAGREES * others:
            break
        rest = np.delete(np.arange(len(kept)), worst)
        refitted = fit_bundle(sightings.of(kept[rest]), fitted.parameters, fitted.poses.of(rest), fitted.free, noise=noise)
        alone = sightings.of(kept[[worst]])
        distances = prediction_distances(
            alone, refitted.parameters[None], refitted.shape.points[None], fitted.poses.of([worst]), steps=20
        )
        error = float(np.sqrt(np.sum(distances**2) / alone.seen.sum()))
        why = f"disagrees: {error:.2f} px when predicted from the others, which agree to {refitted.rms:.2f} px"
        left_out.append(LeftOut(views[int(kept[worst])].name, why))
        kept, fitted = kept[rest], refitted
    return kept, fitted, left_out


def outlier_corner_notes(views: Sequence[BoardView], sightings: StackedViews, fitted: BundleFit) -> list[str]:
    """Views with corners so far off that Huber's loss all but ignores them, in sentences."""
    notes: list[str] = []
    off = fitted.distances > _BAD * fit_noise(fitted)
    for view, row, distances in zip(views, off, fitted.distances, strict=True):
        if row.any():
            which = ", ".join(str(i) for i in sightings.ids[row][:3]) + (", ..." if row.sum() > 3 else "")
            s = "s" if row.sum() > 1 else ""
            notes.append(f"{view.name}: corner{s} {which} up to {distances.max():.1f} px off, counted for little")
    return notes
