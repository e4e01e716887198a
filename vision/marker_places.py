"""How far markers lie beside the places that neck.yaml gives them, by the directions of a few frames alone."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from vision.linkage.initial_guess import initial_angles, initial_poses
from vision.linkage.scene import Scene, image_to_plane, nominal_parameters

Complex = NDArray[np.complex128]


def beside_places(scene: Scene, image: Complex, quarters: Sequence[int], where: str) -> float:
    """How far corners lie beside where they would by the markers' own turns, m; image: (F, markers, 4), normalised."""
    turned = np.stack([np.roll(image[:, k], quarter, axis=1) for k, quarter in enumerate(quarters)], axis=1)
    on_bar, _ = scene.on_bars(nominal_parameters(scene.arm, scene.markers, np.zeros(6)).placement)
    least = np.inf
    for pose in initial_poses(scene, on_bar, turned, where):
        start = nominal_parameters(scene.arm, scene.markers, pose)
        angles = initial_angles(scene.arm, scene.markers, start.placement[:, 2], image_to_plane(turned, pose))
        at = scene.image(start, angles, np.zeros((len(turned), 0)))
        square = np.nanmean(np.abs(turned - at) ** 2, axis=(1, 2))
        least = min(least, float(pose[5] * np.sqrt(np.median(square))))
    return least
