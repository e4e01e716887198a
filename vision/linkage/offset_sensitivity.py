"""Sensitivity of the linkage's fit to corner offsets that stay the same over a recording."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.linkage.linkage_equations import inverse_normals, whiten
from vision.linkage.observed_corners import ObservedCorners
from vision.linkage.scene import Scene, SharedParameters

Array = NDArray[np.float64]


@dataclass(frozen=True)
class OffsetSensitivity:
    """How corner offsets that stay the same over all frames change the estimates; 8 a marker, normalised coordinates.

    Such offsets do not average out. They come from the codec's error on a marker that stands still, from light, and from the
    lens model.
    """

    reduced: Array
    """(p, p): normal matrix of the shared parameters, the angles eliminated"""
    on_shared: Array
    """(p, 8 markers): derivative of the right-hand side that belongs to `reduced` by the offsets"""
    on_angles: Array
    """(F, N, 8 markers): derivative of the angles by the offsets, the shared parameters held"""


def offset_sensitivity(
    scene: Scene, observed: ObservedCorners, shared: SharedParameters, alpha: Array, course: Array
) -> OffsetSensitivity:
    """Sensitivity to lasting corner offsets at `shared` and `alpha`, (F, N), rad."""
    count = observed.image.shape[1]
    unit = np.zeros((count, 4, 8 * count), dtype=complex)
    for k in range(count):
        for c in range(4):
            unit[k, c, 8 * k + 2 * c], unit[k, c, 8 * k + 2 * c + 1] = 1.0, 1.0j
    Ja = whiten(observed, scene.by_angles(shared, alpha, course))
    Js = whiten(observed, scene.by_shared(shared, alpha, course))
    E = whiten(observed, np.broadcast_to(unit, (len(alpha), *unit.shape)))
    JaT, JsT = np.swapaxes(Ja, 1, 2), np.swapaxes(Js, 1, 2)
    on_angles = inverse_normals(JaT @ Ja) @ (JaT @ E)
    reduced = JsT @ (Js - Ja @ (inverse_normals(JaT @ Ja) @ (JaT @ Js)))
    return OffsetSensitivity(np.sum(reduced, axis=0), np.sum(JsT @ (E - Ja @ on_angles), axis=0), on_angles)
