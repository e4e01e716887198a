"""Where the fit of the arm starts: frames that show enough, the camera's pose from the base, angles from directions."""

import cv2
import numpy as np
from numpy.typing import NDArray

from mechanism.arm import Arm
from mechanism.description import Markers
from mechanism.geometry import diagonal_angle
from vision.linkage.scene import Scene
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


def on_base(markers: Markers) -> list[int]:
    """Which markers sit on the base bar, by their order."""
    return [k for k, m in enumerate(markers.on_bars) if m.bar == 0]


def shared_frames(markers: Markers, seen: NDArray[np.bool_], count: int, where: str) -> NDArray[np.intp]:
    """At most `count` frames for what all share: those that show the base and most markers, evenly spread.

    Where some markers are seldom together, frames with fewer are taken too, so that each marker is represented.
    """
    base = on_base(markers)
    if not base:
        raise Refused(where, "no marker sits on the base bar (bar 0)", "angles need one there as reference")
    if not seen.any():
        raise Refused(where, "not a single marker of the arm is in view", "check markers.dictionary and the light")
    with_base = seen[:, base].any(axis=1)
    if not with_base.any():
        raise Refused(where, "the base bar's marker is never in view", "place the camera so that it is")
    number = np.where(with_base, seen.sum(axis=1), 0)
    taken = np.zeros(len(seen), dtype=bool)
    for least in range(number.max(), 0, -1):
        taken = number >= least
        each = seen[taken].sum(axis=0) >= np.minimum(seen[with_base].sum(axis=0), count // 10)
        if each.all():
            break
    good = np.flatnonzero(taken)
    return good[np.unique(np.linspace(0, len(good) - 1, count).astype(int))]


def first_poses(scene: Scene, placed: Complex, image: Complex, where: str) -> list[Array]:
    """Both poses (6,) that a planar target allows, from the base bar's markers averaged over frames (they stand still).

    placed: all markers' corners on their bars, (markers, 4), m; image: (F, markers, 4), normalised, NaN where not seen.
    """
    base = [k for k in on_base(scene.markers) if not np.isnan(image[:, k, 0]).all()]
    points = placed[base].ravel()
    mean = np.nanmedian(image[:, base].real, axis=0) + 1j * np.nanmedian(image[:, base].imag, axis=0)
    world = np.column_stack([points.real, points.imag, np.zeros(points.size)])
    pixels = np.column_stack([mean.real.ravel(), mean.imag.ravel()])
    found, rvecs, tvecs, _ = cv2.solvePnPGeneric(world, pixels, np.eye(3), np.zeros(5), flags=cv2.SOLVEPNP_IPPE)
    if not found:
        raise Refused(where, "the base bar's marker does not give the camera's pose", "is markers.size right?")
    both = [np.concatenate([np.ravel(r), np.ravel(t)]).astype(float) for r, t in zip(rvecs, tvecs, strict=True)]
    return [pose for pose in both if pose[5] > 0]


def first_angles(arm: Arm, markers: Markers, turned: Array, plane: Complex) -> Array:
    """alpha of each frame from the markers' own directions, shape (F, N); a bar without one lies between its neighbours.

    turned: each marker's angle on its bar, (markers,), rad; plane: corners in the arm's plane, (F, markers, 4).
    """
    n = arm.N
    side = plane[..., 1] - plane[..., 0] + plane[..., 2] - plane[..., 3]
    side = side * np.exp(-1j * turned)
    gamma = np.full((len(plane), n + 1), np.nan)
    gamma[:, 0] = 0.0
    table = np.linspace(-2.8, 2.8, 561)
    lean = diagonal_angle(arm, np.repeat(table[:, None], n, axis=1))  # (561, N, 2)
    for bar in range(1, n + 1):
        below = gamma[:, bar - 1]
        mine = [k for k, m in enumerate(markers.on_bars) if m.bar == bar]
        direction = np.nansum(side[:, mine], axis=1)
        gamma[:, bar] = np.where(direction != 0, np.angle(direction), np.nan)
        for k, m in enumerate(markers.on_bars):
            if m.diagonal and m.mechanism == bar:
                middle = lean[len(table) // 2, bar - 1, "AB".index(m.diagonal[0])]
                against = middle + np.angle(side[:, k] * np.exp(-1j * (below + middle)))
                alpha = np.interp(against, lean[:, bar - 1, "AB".index(m.diagonal[0])], table)
                gamma[:, bar] = np.where(np.isnan(gamma[:, bar]), below + alpha, gamma[:, bar])
    at = np.arange(n + 1)
    for row in gamma:
        known = ~np.isnan(row)
        row[:] = np.interp(at, at[known], np.unwrap(row[known]))
    return np.clip(np.diff(gamma, axis=1), -2.5, 2.5)
