"""How good each frame was, and why angles are missing where they are."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series
from vision.markers.tracking import DOUBLED, LATE, LOST, NOT_FOUND, OTHER_PRINT, REPEATED
from vision.markers.video_tracking import MarkerTracks

Array = NDArray[np.float64]

CAUSES = {
    NOT_FOUND: "not found (hidden, blurred or out of the picture)",
    LOST: "lost while followed (covered, or glare)",
    DOUBLED: "in view twice",
    REPEATED: "in the picture before, shown again",
    LATE: "of another moment than the frame's stamp",
    OTHER_PRINT: "in view on another print of it, or perhaps so",
}


def frame_quality(tracks: MarkerTracks, ids: list[int], residual_px: Array, exposure_s: float) -> Series:
    """Quality columns over the frames.

    `residual_px` of the linkage's fit; `blur_px`, the distance that the fastest corner moves during the exposure; for each
    marker `how_id` (0 followed, 1 searched, 2 not found, 3 lost, 4 doubled, 5 repeated, 6 another print, 7 of another moment).
    Where corners were fitted by the template also, for each marker, the shares of it that are hidden and clipped, and whether the
    fit fell back to the edges; and the grey level of a switched light.
    """
    shift = np.abs(np.gradient(tracks.corners, tracks.time, axis=0)) * exposure_s
    filled = np.nan_to_num(shift, nan=-1.0)
    blur = np.max(np.linalg.norm(np.maximum(filled, 0.0), axis=-1), axis=(1, 2))
    columns = {"residual_px": residual_px, "blur_px": blur}
    by_marker = {"how": tracks.status}
    if tracks.covariance is not None:
        by_marker |= {"hidden": tracks.hidden, "clipped": tracks.clipped, "fell_back": tracks.fell_back}
    for name, values in by_marker.items():
        columns |= {f"{name}_id{i}": values[:, k].astype(float) for k, i in enumerate(ids)}
    if tracks.light is not None:
        columns["light"] = tracks.light
    return Series(tracks.time, columns)


def angle_gaps(time: Array, alpha: Array, ids: list[int], status: NDArray[np.int8]) -> list[dict[str, Any]]:
    """Runs of frames in which an angle is not known: frames, times, which angles, and what became of the markers.

    alpha: (F, N), rad, NaN where not known; status: (F, markers), as `MarkerTracks` has it.
    """
    missing = np.isnan(alpha)
    gaps = []
    changes = np.flatnonzero(np.any(missing[1:] != missing[:-1], axis=1)) + 1
    for begin, end in zip([0, *changes], [*changes, len(time)], strict=True):
        if not missing[begin].any():
            continue
        causes = [
            f"marker {i} {CAUSES[code]}"
            for k, i in enumerate(ids)
            if (code := int(np.bincount(status[begin:end, k]).argmax())) in CAUSES
        ]
        gaps.append(
            {
                "first_frame": int(begin),
                "last_frame": int(end - 1),
                "from_s": float(time[begin]),
                "to_s": float(time[end - 1]),
                "angles": [f"alpha{i + 1}" for i in np.flatnonzero(missing[begin])],
                "cause": "; ".join(causes) or "the markers seen do not determine them",
            }
        )
    return gaps
