"""Start of the linkage's fit: the frames to use, the camera's pose from the base bar, angles from the markers' directions."""

import cv2
import numpy as np
from numpy.typing import NDArray

from mechanism.arm import Arm
from mechanism.geometry import diagonal_angle
from mechanism.printed_markers import Markers
from vision.linkage.scene import Scene
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


def base_markers(markers: Markers) -> list[int]:
    """Indices of the markers that sit on the base bar."""
    return [k for k, m in enumerate(markers.on_bars) if m.bar == 0]


def refuse_without_base(markers: Markers, where: str) -> None:
    """Raises Refused where no marker sits on the base bar."""
    if not base_markers(markers):
        raise Refused(where, "no marker sits on the base bar (bar 0)", "angles need one there as reference")


def select_frames(markers: Markers, visible: NDArray[np.bool_], count: int, where: str) -> NDArray[np.intp]:
    """At most `count` frames for the shared parameters: those that show the base and most markers, evenly spread.

    visible: (F, markers). Where some markers are seldom in view together, frames with fewer markers are taken too, so that
    each marker is represented.
    """
    refuse_without_base(markers, where)
    base = base_markers(markers)
    if not visible.any():
        raise Refused(where, "not a single marker of the arm is in view", "check markers.dictionary and the light")
    with_base = visible[:, base].any(axis=1)
    if not with_base.any():
        raise Refused(
            where,
            "the base bar's marker was found in no frame, though others were",
            "is it in the picture, uncovered, sharp, and 2 px or more a cell?",
        )
    counts = np.where(with_base, visible.sum(axis=1), 0)
    selected = np.zeros(len(visible), dtype=bool)
    for least in range(counts.max(), 0, -1):
        selected = counts >= least
        represented = visible[selected].sum(axis=0) >= np.minimum(visible[with_base].sum(axis=0), count // 10)
        if represented.all():
            break
    frames = np.flatnonzero(selected)
    return frames[np.unique(np.linspace(0, len(frames) - 1, count).astype(int))]


def initial_poses(scene: Scene, corners_on_bar: Complex, image: Complex, where: str) -> list[Array]:
    """Both poses (6,) that a planar target allows, from the corners of the base bar's markers, which stand still.

    corners_on_bar: corners of all markers on their bars, (markers, 4), m; image: (F, markers, 4), normalised, NaN where not
    found.
    """
    base = [k for k in base_markers(scene.markers) if not np.isnan(image[:, k, 0]).all()]
    points = corners_on_bar[base].ravel()
    mean = np.nanmedian(image[:, base].real, axis=0) + 1j * np.nanmedian(image[:, base].imag, axis=0)
    world = np.column_stack([points.real, points.imag, np.zeros(points.size)])
    pixels = np.column_stack([mean.real.ravel(), mean.imag.ravel()])
    solved, rvecs, tvecs, _ = cv2.solvePnPGeneric(world, pixels, np.eye(3), np.zeros(5), flags=cv2.SOLVEPNP_IPPE)
    if not solved:
        raise Refused(where, "the base bar's marker does not give the camera's pose", "is markers.size right?")
    both = [np.concatenate([np.ravel(r), np.ravel(t)]).astype(float) for r, t in zip(rvecs, tvecs, strict=True)]
    return [pose for pose in both if pose[5] > 0]


def initial_angles(arm: Arm, markers: Markers, marker_angles: Array, plane: Complex) -> Array:
    """alpha of each frame from the markers' directions, (F, N), rad; a bar without a marker gets the mean of its neighbours.

    marker_angles: each marker's angle on its bar, (markers,), rad; plane: corners in the arm's plane, (F, markers, 4), m.
    """
    n = arm.N
    side = plane[..., 1] - plane[..., 0] + plane[..., 2] - plane[..., 3]
    side = side * np.exp(-1j * marker_angles)
    gamma = np.full((len(plane), n + 1), np.nan)
    gamma[:, 0] = 0.0
    table = np.linspace(-2.8, 2.8, 561)
    inclination = diagonal_angle(arm, np.repeat(table[:, None], n, axis=1))  # (561, N, 2)
    for bar in range(1, n + 1):
        below = gamma[:, bar - 1]
        on_bar = [k for k, m in enumerate(markers.on_bars) if m.bar == bar]
        direction = np.nansum(side[:, on_bar], axis=1)
        gamma[:, bar] = np.where(direction != 0, np.angle(direction), np.nan)
        for k, m in enumerate(markers.on_bars):
            if m.diagonal and m.mechanism == bar:
                middle = inclination[len(table) // 2, bar - 1, "AB".index(m.diagonal[0])]
                orientation = middle + np.angle(side[:, k] * np.exp(-1j * (below + middle)))
                alpha = np.interp(orientation, inclination[:, bar - 1, "AB".index(m.diagonal[0])], table)
                gamma[:, bar] = np.where(np.isnan(gamma[:, bar]), below + alpha, gamma[:, bar])
    at = np.arange(n + 1)
    for row in gamma:
        known = ~np.isnan(row)
        row[:] = np.interp(at, at[known], np.unwrap(row[known]))
    return np.clip(np.diff(gamma, axis=1), -2.5, 2.5)
