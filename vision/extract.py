"""A recorded video to joint angles."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibration.camera import Camera
from mechanism.description import Neck, markers_of
from vision.angles import Angles
from vision.linkage_fit import LinkageFit, fit_linkage
from vision.markers import Finder
from vision.video import describe, frames
from xneck.errors import Refused

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Extraction:
    """Angles, the fit behind them, and the corners that were found."""

    angles: Angles
    fit: LinkageFit
    corners: Array
    """(F, markers, 4, 2), px, NaN where a marker was not found; markers in neck.yaml's order"""

    def as_json(self) -> dict[str, Any]:
        """The contract's record of an extraction."""
        a = self.angles
        seen = a.complete
        median = float(np.median(a.sigma[seen])) if seen.any() else None
        return {
            "frames": len(a.time),
            "frames_with_all_angles": int(seen.sum()),
            "sigma_alpha_median_rad": median,
            "corner_sigma_px": self.fit.corner_sigma_px,
            "markers": a.notes["markers"],
            "T_camera_base": a.notes["T_camera_base"],
        }


def extract(
    video: str | Path, camera: Camera, neck: Neck, progress: Callable[[int], object] = lambda frames: None
) -> Extraction:
    """Angles of every frame; `progress` is told of each frame read. One pass, memory grows by some bytes a frame only.

    Raises Refused for a damaged video, a picture size that is not the camera's, or where no marker of the arm is in view.
    """
    markers = markers_of(neck, "neck.yaml")
    size = describe(video)
    if (size.width, size.height) != camera.size:
        raise Refused(
            video,
            f"is {size.width}x{size.height}, the camera was calibrated at {camera.width}x{camera.height}",
            "calibrate with pictures of the video's size",
        )
    finder = Finder(markers)
    order = {marker.id: k for k, marker in enumerate(markers.on_bars)}
    times: list[float] = []
    found: list[Array] = []
    twice = np.zeros(len(order), dtype=int)
    foreign: set[int] = set()
    for frame in frames(video):
        seen = finder.find(frame.grey)
        corners = np.full((len(order), 4, 2), np.nan)
        for i, c in seen.corners.items():
            corners[order[i]] = c
        for i in seen.duplicate:
            twice[order[i]] += 1
        foreign.update(seen.foreign)
        times.append(frame.time)
        found.append(corners)
        progress(1)
    corners = np.stack(found)
    if np.isnan(corners).all():
        other = f", though others of the dictionary are (ids {sorted(foreign)[:8]})" if foreign else ""
        raise Refused(
            video,
            f"no marker of neck.yaml is in view in {len(times)} frames{other}",
            f"check markers.dictionary ({markers.dictionary}) and the ids",
        )
    fit = fit_linkage(neck, camera, corners, str(video))
    sigma = np.sqrt(np.diagonal(fit.covariance, axis1=1, axis2=2))
    sigma = np.where(np.isnan(fit.alpha), np.nan, sigma)
    shares = (~np.isnan(corners[:, :, 0, 0])).mean(axis=0)
    notes = {
        "source": Path(video).name,
        "markers": [
            {"id": marker.id, "seen_share": float(shares[k]), "duplicates": int(twice[k])}
            for k, marker in enumerate(markers.on_bars)
        ],
        "foreign_ids": sorted(foreign)[:50],
        "T_camera_base": {
            "rvec": fit.rvec.tolist(),
            "tvec_m": fit.tvec.tolist(),
            "sigma": fit.pose_sigma.tolist(),
        },
    }
    return Extraction(Angles(np.array(times), fit.alpha, sigma, notes), fit, corners)
