"""How good each frame was, and why angles are missing where they are."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series
from vision.markers.tracking import DOUBLED, HIDDEN, UNREADABLE
from vision.markers.whole_video import Followed

Array = NDArray[np.float64]

CAUSES = {
    HIDDEN: "not found (hidden, blurred or out of the picture)",
    UNREADABLE: "lost while followed (covered, or glare)",
    DOUBLED: "in view twice",
}


def quality(seen: Followed, ids: list[int], residual_px: Array, exposure_s: float) -> Series:
    """Columns over the frames: residual_px of the fit, blur_px (fastest corner's way during the exposure), and for each marker
    how it was come by (0 followed, 1 searched, 2 not found, 3 lost, 4 doubled); where corners were fitted by the template also
    what share of it is hidden or clipped, and whether the fit fell back to the edges; and the grey level of a switched light."""
    way = np.abs(np.gradient(seen.corners, seen.time, axis=0)) * exposure_s
    filled = np.nan_to_num(way, nan=-1.0)
    blur = np.max(np.linalg.norm(np.maximum(filled, 0.0), axis=-1), axis=(1, 2))
    columns = {"residual_px": residual_px, "blur_px": blur}
    parts = {"how": seen.how}
    if seen.covariance is not None:
        parts |= {"hidden": seen.hidden, "clipped": seen.clipped, "fell_back": seen.fell_back}
    for name, values in parts.items():
        columns |= {f"{name}_id{i}": values[:, k].astype(float) for k, i in enumerate(ids)}
    if seen.light is not None:
        columns["light"] = seen.light
    return Series(seen.time, columns)


def gaps(time: Array, alpha: Array, ids: list[int], how: NDArray[np.int8]) -> list[dict[str, Any]]:
    """Runs of frames in which an angle is not known: frames, times, which angles, and what became of the markers."""
    missing = np.isnan(alpha)
    out = []
    changes = np.flatnonzero(np.any(missing[1:] != missing[:-1], axis=1)) + 1
    for begin, end in zip([0, *changes], [*changes, len(time)], strict=True):
        if not missing[begin].any():
            continue
        causes = [
            f"marker {i} {CAUSES[code]}"
            for k, i in enumerate(ids)
            if (code := int(np.bincount(how[begin:end, k]).argmax())) in CAUSES
        ]
        out.append(
            {
                "first_frame": int(begin),
                "last_frame": int(end - 1),
                "from_s": float(time[begin]),
                "to_s": float(time[end - 1]),
                "angles": [f"alpha{i + 1}" for i in np.flatnonzero(missing[begin])],
                "cause": "; ".join(causes) or "the markers seen do not determine them",
            }
        )
    return out
