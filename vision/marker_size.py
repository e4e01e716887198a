"""Markers that are printed larger or smaller than neck.yaml says: distances between them are then all off by one factor.

Lengths of the bars that are off say nearly the same, so that a refusal speaks of both."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from vision.linkage.scene import Scene
from vision.marker_places import beside_places
from xneck_foundation.errors import Refused

Complex = NDArray[np.complex128]

MIN_BESIDE_M = 5e-3
"""m, beside their places: markers that lie nearer as described are of the size that they are said to have, and those that lie no
nearer with another size are not of that one either (docs/thresholds.md)"""
MIN_FACTOR, MAX_FACTOR = 1.1, 10.0
"""by which a size is off at least, since a base marker behind the arm's plane looks smaller too, and at most, as mm for cm
(docs/thresholds.md)"""
MAX_SHARE_OF_BESIDE = 1 / 5
"""of how far markers lie beside their places as described, what another size leaves at most (docs/thresholds.md)"""
_FACTORS = np.geomspace(1 / MAX_FACTOR, MAX_FACTOR, 41)


def refuse_other_marker_size(scene: Scene, image: Complex, beside: float, where: str) -> None:
    """Raises Refused where markers of another size would lie far nearer to their places; image: (F, markers, 4), normalised.

    beside: m, how far they lie beside them as described."""
    if beside < MIN_BESIDE_M:
        return

    def left(log_factor: float, quarter: int) -> float:
        factor = float(np.exp(log_factor))
        markers = scene.markers.model_copy(update={"size": factor * scene.markers.size})
        quarters = (quarter,) * len(markers.on_bars)
        return beside_places(replace(scene, markers=markers), image, quarters, where)

    step = float(np.log(_FACTORS[1] / _FACTORS[0]))
    least, log_factor = np.inf, 0.0
    for quarter in (0, 2):
        near = min(np.log(_FACTORS), key=lambda at, q=quarter: left(at, q))
        best: Any = minimize_scalar(left, bounds=(near - step, near + step), args=(quarter,), method="bounded")
        if best.fun < least:
            least, log_factor = float(best.fun), float(best.x)
    if least > min(MIN_BESIDE_M, MAX_SHARE_OF_BESIDE * beside) or abs(log_factor) < np.log(MIN_FACTOR):
        return
    factor, size = float(np.exp(log_factor)), 1e3 * scene.markers.size
    raise Refused(
        where,
        f"markers of {size:.4g} mm would lie {1e3 * beside:.0f} mm beside their places, and {1e3 * least:.1f} mm if they were "
        f"{factor * size:.4g} mm a side",
        "measure one from black edge to black edge, and correct markers.size in neck.yaml; if it is right, the bars' "
        f"lengths L and b there must be about {1 / factor:.2g} times as large",
    )
