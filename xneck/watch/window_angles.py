"""Joint angles of the newest frames: the linkage fitted to a few seconds alone, for a look and not for a result."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from calibration.camera import Camera
from calibration.dictionaries import marker_cells
from mechanism.description import Neck, markers_of
from synchronisation.angles import Angles
from vision.extract import ExtractionOptions, linkage_options
from vision.linkage.lens_bow import correct_lens_bow
from vision.linkage.linkage_fit import fit_linkage
from vision.shutter import at_middle_row
from vision.turned_prints import turned_prints
from xneck.watch.video_watch import SeenFrame

Array = NDArray[np.float64]


def window_angles(
    neck: Neck, camera: Camera, options: ExtractionOptions, frames: Sequence[SeenFrame], where: str, max_hz: float
) -> Angles:
    """Angles of those frames that determine all of them, at most `max_hz` in a second.

    Raises Refused where the frames do not show what the pose of the camera needs.
    """
    time = np.array([f.time for f in frames])
    every = max(1, round(1 / (max_hz * float(np.median(np.diff(time)))))) if len(time) > 1 else 1
    frames, time = frames[::every], time[::every]
    markers = markers_of(neck, "neck.yaml")
    cells = np.stack([marker_cells(markers.dictionary, m.id) for m in markers.on_bars]) if options.template else None
    corners = correct_lens_bow(camera, np.stack([f.tracked.corners for f in frames]), cells)
    corners = at_middle_row(time, corners, camera.size[1], options.shutter)
    covariance = None
    if options.template:
        covariance = np.stack([c for f in frames if (c := f.tracked.covariance) is not None]).astype(float)
    corners, covariance = turned_prints(neck, camera, corners, where).upright(corners, covariance)
    linkage = linkage_options(options, drift=False)
    fit = fit_linkage(neck, camera, corners, where, covariance=covariance, options=linkage)
    known = np.isfinite(fit.alpha).all(axis=1)
    variance = np.diagonal(fit.covariance, axis1=1, axis2=2)[known]
    notes = {}
    if options.light:
        delay = options.light.delay_s(camera.size[1], options.shutter)
        notes["light"] = {"exposure_s": options.shutter.exposure_s, "later_s": delay}
    middle = options.shutter.middle(time, camera.size[1])[known]
    return Angles(time=middle, alpha=fit.alpha[known], sigma=np.sqrt(variance), notes=notes)
