"""Markers that are turned by quarters against neck.yaml, or exchanged: which way up a print is, libraries do not agree upon.

The AprilTag library's own pictures are upside down against those by which OpenCV, and so `angle` in neck.yaml, counts. A marker may
also have been stuck on sideways. The arm shows it: angles that are wrong by quarter turns put the next bars where they are not.
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from calibration.camera import Camera
from mechanism.arm import arm_of
from mechanism.description import Neck, markers_of
from mechanism.printed_markers import Markers
from vision.linkage.initial_guess import select_frames
from vision.linkage.observed_corners import Floats, normalise_corners
from vision.linkage.scene import Scene
from vision.marker_places import beside_places
from vision.marker_size import refuse_other_marker_size
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

MIN_BESIDE = 0.2
"""of the mean length L: how far beside their places markers lie where they are not as described (docs/thresholds.md)"""
MAX_SHARE = 1 / 3
"""of that, which turned markers leave at most (docs/thresholds.md)"""
_FRAMES = 6
"""in which markers are looked at"""


@dataclass(frozen=True)
class TurnedPrints:
    """By how many quarters each marker is turned, anticlockwise in the upright picture, against neck.yaml."""

    quarters: tuple[int, ...]

    def upright(self, corners: Array, covariance: Floats | None) -> tuple[Array, Floats | None]:
        """Corners (F, markers, 4, 2) and their covariance (F, markers, 8, 8), of the markers as neck.yaml counts them."""
        if not any(self.quarters):
            return corners, covariance
        corners = corners.copy()
        covariance = None if covariance is None else covariance.copy()
        for k, quarter in enumerate(self.quarters):
            corners[:, k] = np.roll(corners[:, k], quarter, axis=1)
            if covariance is not None:
                covariance[:, k] = np.roll(covariance[:, k], 2 * quarter, axis=(1, 2))
        return corners, covariance

    def warnings(self, markers: Markers) -> list[str]:
        """A sentence on markers that are turned, if there are any."""
        if set(self.quarters) == {2}:
            whose = " as the AprilTag library's pictures are" if markers.dictionary.startswith("apriltag") else ""
            return [f"all markers are upside down{whose} against neck.yaml, which counts `angle` by OpenCV's: taken so"]
        turned = [
            f"{marker.id} on {marker.place} by {90 * quarter if quarter < 3 else -90} deg"
            for marker, quarter in zip(markers.on_bars, self.quarters, strict=True)
            if quarter
        ]
        if not turned:
            return []
        said = "marker " if len(turned) == 1 else "markers "
        return [f"{said}{', '.join(turned)} turned anticlockwise against neck.yaml: taken so; correct `angle` there"]


def turned_prints(neck: Neck, camera: Camera, corners: Array, where: str) -> TurnedPrints:
    """Of corners (F, markers, 4, 2), px, NaN where not found. None is turned where that would not explain far more.

    Raises Refused where no frame shows the base bar, where two markers lie in each other's place, or all are of another size."""
    markers = markers_of(neck, where)
    scene = Scene(arm_of(neck), markers, False)
    few = select_frames(markers, ~np.isnan(corners[:, :, 0, 0]), _FRAMES, where)
    image = normalise_corners(camera, corners[few])
    as_described = (0,) * len(markers.on_bars)
    beside = beside_places(scene, image, as_described, where)
    near = MIN_BESIDE * float(np.mean(scene.arm.L))
    if beside >= near:
        left, found = min(_best_turns(scene, image, quarter, where) for quarter in range(4))
        if left < min(near, MAX_SHARE * beside):
            return TurnedPrints(found)
    refuse_other_marker_size(scene, image, beside, where)
    if beside >= near:
        _refuse_exchanged(scene, image, beside, where)
    return TurnedPrints(as_described)


def _best_turns(scene: Scene, image: Complex, quarter: int, where: str) -> tuple[float, tuple[int, ...]]:
    """From all markers turned alike on, one turned otherwise at a time: how far they lie beside their places, and the turns."""
    found = (quarter,) * len(scene.markers.on_bars)
    left = beside_places(scene, image, found, where)
    while True:
        tried = [(*found[:k], q, *found[k + 1 :]) for k in range(len(found)) for q in range(4) if q != found[k]]
        best, turns = min((beside_places(scene, image, q, where), q) for q in tried)
        if best >= left:
            return left, found
        left, found = best, turns


def _refuse_exchanged(scene: Scene, image: Complex, beside: float, where: str) -> None:
    """Raises Refused where two markers that are exchanged would lie far nearer to their places."""
    on_bars = scene.markers.on_bars
    for (i, one), (j, other) in combinations(enumerate(on_bars), 2):
        order = list(range(len(on_bars)))
        order[i], order[j] = j, i
        left = min(beside_places(scene, image[:, order], [quarter] * len(order), where) for quarter in (0, 2))
        if left < MAX_SHARE * beside:
            raise Refused(
                where,
                f"marker {one.id} lies where neck.yaml has {other.id}, and {other.id} where it has {one.id}: markers are "
                f"{1e3 * beside:.0f} mm beside their places, and {1e3 * left:.0f} mm so",
                "exchange both ids in neck.yaml",
            )
