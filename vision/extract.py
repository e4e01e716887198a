"""A recorded video to joint angles."""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibration.camera import Camera
from calibration.dictionaries import marker_cells
from identification.dataset.series import Series
from mechanism.description import Neck, markers_of
from synchronisation.angles import Angles
from vision.light_patch import LightPatch
from vision.linkage.lens_bow import straightened
from vision.linkage.linkage_fit import LinkageFit, fit_linkage
from vision.linkage.shared_fit import PlacementPrior
from vision.markers.tracking import DOUBLED, Manner
from vision.markers.whole_video import follow
from vision.quality import gaps, quality
from vision.shutter import UNKNOWN, Shutter, at_middle_row
from vision.video import Video
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

SYSTEMATIC_PX = 0.01
"""px: corner offsets that last for the whole recording; 0.008 rms was seen on the sample, from the codec on still markers"""
ASKEW = 1.5
"""times as large a corner error with the placement of neck.yaml as with a free one tells that it is wrong"""


@dataclass(frozen=True)
class Extraction:
    """Angles, the fit behind them, and the corners that were found."""

    angles: Angles
    fit: LinkageFit
    corners: Array
    """(F, markers, 4, 2), px, NaN where a marker was not found; markers in neck.yaml's order"""
    quality: Series

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
            "gaps": a.notes["gaps"],
            "drift": a.notes["drift"],
            "placement": a.notes.get("placement"),
            "askew": a.notes["askew"],
            "T_camera_base": a.notes["T_camera_base"],
        }


def extract(
    video: Video,
    camera: Camera,
    neck: Neck,
    shutter: Shutter = UNKNOWN,
    placement: PlacementPrior | None = None,
    template: bool = True,
    workers: int = 1,
    light: LightPatch | None = None,
    progress: Callable[[int], object] = lambda frames: None,
) -> Extraction:
    """Angles of every frame of a video that was described; `workers` processes share the video, `progress` is told of frames done.

    With `template` corners are fitted to all grey levels of a marker, else to the edges of its square. With a `placement`
    prior it is estimated where each marker sits; without one neck.yaml is believed, and held against what the motion shows
    (`notes["askew"]`). A `light` that the controller switches is read along the way.

    Raises Refused for a damaged video, a picture size that is not the camera's, or where no marker of the arm is in view.
    """
    markers = markers_of(neck, "neck.yaml")
    if (video.width, video.height) != camera.size:
        raise Refused(
            video.path,
            f"is {video.width}x{video.height}, the camera was calibrated at {camera.width}x{camera.height}",
            "calibrate with pictures of the video's size",
        )
    if light:
        light.inside(video.width, video.height, str(video.path))
    seen = follow(video, markers, Manner(template, shutter.exposure_s), workers, progress, light)
    if np.isnan(seen.corners).all():
        other = f", though others of the dictionary are (ids {list(seen.foreign)[:8]})" if seen.foreign else ""
        raise Refused(
            video.path,
            f"no marker of neck.yaml is in view in {len(seen.time)} frames{other}",
            f"check markers.dictionary ({markers.dictionary}) and the ids",
        )
    cells = np.stack([marker_cells(markers.dictionary, marker.id) for marker in markers.on_bars]) if template else None
    corners = straightened(camera, seen.corners, cells)
    corners = at_middle_row(seen.time, corners, video.height, shutter)
    covariance = None if seen.covariance is None else seen.covariance.astype(float)
    time = shutter.middle(seen.time, video.height)
    fit = fit_linkage(
        neck,
        camera,
        corners,
        str(video.path),
        covariance=covariance,
        time=time,
        placement=placement,
        systematic_px=SYSTEMATIC_PX,
    )
    sigma = np.sqrt(np.diagonal(fit.covariance, axis1=1, axis2=2))
    sigma = np.where(np.isnan(fit.alpha), np.nan, sigma)
    shared = np.diagonal(fit.covariance - (fit.covariance if fit.noise is None else fit.noise), axis1=1, axis2=2)
    common = np.where(np.isnan(fit.alpha), np.nan, np.sqrt(np.maximum(shared, 0.0)))
    shares = (~np.isnan(corners[:, :, 0, 0])).mean(axis=0)
    twice = (seen.how == DOUBLED).sum(axis=0)
    notes: dict[str, Any] = {
        "source": video.path.name,
        "markers": [
            {"id": marker.id, "seen_share": float(shares[k]), "duplicates": int(twice[k])}
            for k, marker in enumerate(markers.on_bars)
        ],
        "foreign_ids": list(seen.foreign)[:50],
        "T_camera_base": {
            "rvec": fit.rvec.tolist(),
            "tvec_m": fit.tvec.tolist(),
            "sigma": fit.pose_sigma.tolist(),
        },
    }
    ids = [marker.id for marker in markers.on_bars]
    notes |= fit.notes
    notes["askew"] = None if placement else _askew(neck, camera, corners, covariance, str(video.path), fit)
    notes["gaps"] = gaps(time, fit.alpha, ids, seen.how)
    if light:
        later = light.later(video.height, shutter)
        notes["light"] = {**asdict(light), "exposure_s": shutter.exposure_s, "later_s": later}
    frame_quality = quality(seen, ids, fit.residual_px, shutter.exposure_s)
    return Extraction(Angles(time, fit.alpha, sigma, notes, seen.light, common), fit, corners, frame_quality)


def _askew(
    neck: Neck, camera: Camera, corners: Array, covariance: Array | None, where: str, believed: LinkageFit
) -> str | None:
    """A sentence where markers that sit as neck.yaml says explain the corners much worse than markers free to sit elsewhere."""
    free = fit_linkage(neck, camera, corners, where, covariance=covariance, placement=PlacementPrior(), drift=False)
    if believed.corner_sigma_px < ASKEW * free.corner_sigma_px or free.placement is None:
        return None
    worst = max(free.placement.numbers, key=lambda n: abs(n.value - n.nominal) / n.prior_sigma)
    shown = (
        f"{1e3 * (worst.value - worst.nominal):+.1f} mm"
        if worst.unit == "m"
        else f"{np.degrees(worst.value - worst.nominal):+.1f} deg"
    )
    return (
        f"the markers do not sit as neck.yaml says: corners fit to {believed.corner_sigma_px:.2f} px as described, to "
        f"{free.corner_sigma_px:.2f} px where they may sit otherwise (most: {worst.name} of {worst.where}, {shown}); "
        "estimate their placement, or correct neck.yaml"
    )
