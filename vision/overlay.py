"""Markers, the fitted linkage and the angles in figures, drawn over the pictures of a video."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.camera import Camera
from mechanism.arm import arm_of
from mechanism.description import Neck
from mechanism.geometry import poses
from vision.extract import Extraction

Array = NDArray[np.float64]
Picture = NDArray[Any]
"""uint8; OpenCV's stubs say less"""

MARKER_COLOUR, BAR_COLOUR = (40, 200, 60), (30, 30, 230)  # BGR
DIAGONAL_COLOUR, TEXT_COLOUR = (230, 140, 30), (255, 255, 255)  # BGR


def draw_overlay(grey: Picture, index: int, neck: Neck, camera: Camera, extraction: Extraction) -> Picture:
    """Frame `index` as a BGR picture with its markers, bars, diagonals and angles."""
    out = draw_linkage(grey, index, neck, camera, extraction)
    alpha, sigma = extraction.angles.alpha[index], extraction.angles.sigma[index]
    lines = [f"frame {index}  {extraction.angles.time[index]:.3f} s"]
    for i, (a, s) in enumerate(zip(alpha, sigma, strict=True)):
        shown = "not seen" if np.isnan(a) else f"{np.degrees(a):7.2f} +- {np.degrees(s):.2f} deg"
        lines.append(f"alpha{i + 1} {shown}")
    out[: 40 + 26 * (len(lines) - 1), :330] //= 3  # a dark ground, so that the text can be read on any picture
    for row, line in enumerate(lines):
        cv2.putText(out, line, (12, 28 + 26 * row), cv2.FONT_HERSHEY_SIMPLEX, 0.7, TEXT_COLOUR, 1, cv2.LINE_AA)
    return out


def draw_linkage(grey: Picture, index: int, neck: Neck, camera: Camera, extraction: Extraction) -> Picture:
    """Frame `index` as a BGR picture with its markers, bars and diagonals."""
    out = cv2.cvtColor(np.ascontiguousarray(grey), cv2.COLOR_GRAY2BGR)
    for corners in extraction.corners[index]:
        if not np.isnan(corners).any():
            _polygon(out, corners, MARKER_COLOUR)
    alpha = extraction.angles.alpha[index]
    if not np.isnan(alpha).any():
        for points, colour in linkage_lines(neck, camera, frame_pose(extraction, index), alpha):
            _polygon(out, points, colour)
    return out


def frame_pose(extraction: Extraction, index: int) -> Array:
    """rvec (rad) and tvec (m) of T_camera_base at a frame, shape (6,)."""
    fit = extraction.fit
    return np.concatenate([fit.rvec, fit.tvec]) if fit.poses is None else fit.poses[index]


def linkage_lines(neck: Neck, camera: Camera, pose: Array, alpha: Array) -> list[tuple[Array, tuple[int, int, int]]]:
    """The fitted arm's bars as lines in pixels, bent as the lens bends them, each with its colour."""
    arm = arm_of(neck)
    p = poses(arm, alpha)
    half = np.append(arm.b, arm.b[-1]) / 2 * np.exp(1j * p.bar_angle)
    left, right = p.bar_middle - half, p.bar_middle + half
    lines = [(left[i], right[i], BAR_COLOUR) for i in range(arm.N + 1)]
    lines += [(left[i], right[i + 1], DIAGONAL_COLOUR) for i in range(arm.N)]
    lines += [(right[i], left[i + 1], DIAGONAL_COLOUR) for i in range(arm.N)]
    share = np.linspace(0, 1, 9)
    drawn = []
    for a, b, colour in lines:
        points = a + (b - a) * share
        world = np.column_stack([points.real, points.imag, np.zeros(len(points))])
        drawn.append((camera.project(world, pose[:3], pose[3:]), colour))
    return drawn


def _polygon(picture: Picture, points: Array, colour: tuple[int, int, int]) -> None:
    """Draw a line through pixels of shape (K, 2); four points are a marker's corners and are closed."""
    shifted = [np.rint(points * 16).astype(np.int32).reshape(-1, 1, 2)]
    cv2.polylines(picture, shifted, len(points) == 4, colour, 2, cv2.LINE_AA, shift=4)
