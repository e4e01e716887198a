"""The arm with its markers before a camera: where every corner falls, and how that depends on every unknown.

Unknown of a frame are its alpha_1..N. Shared by all frames are the camera's pose, where each marker sits on its bar, the
lengths L and b, and how the camera's pose changed in the course of the recording. Points of the plane are complex numbers;
image points are normalised coordinates x + jy of the camera frame (on its plane z = 1).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mechanism.arm import Arm
from mechanism.description import Markers
from mechanism.geometry import poses

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

STEP = 1e-6
"""rad and m, of central differences"""


@dataclass(frozen=True)
class Shared:
    """What all frames have in common; every field may be moved by a fit."""

    pose: Array
    """(6,): rvec (rad) and tvec (m) of T_camera_base"""
    placement: Array
    """(markers, 3): x, y (m) and angle (rad) of each marker on its bar"""
    lengths: Array
    """(2, N): L and b, m"""
    drift: Array
    """(terms, 6): change of the pose that goes with each drift term; (0, 6) where the camera stood still"""

    @property
    def vector(self) -> Array:
        """All of it in one, (p,)."""
        return np.concatenate([self.pose, self.placement.ravel(), self.lengths.ravel(), self.drift.ravel()])

    def moved(self, change: Array) -> "Shared":
        """With `change`, (p,), added."""
        v = self.vector + change
        a = 6 + self.placement.size
        c = a + self.lengths.size
        return Shared(
            v[:6], v[6:a].reshape(self.placement.shape), v[a:c].reshape(self.lengths.shape), v[c:].reshape(-1, 6)
        )


def nominal(arm: Arm, markers: Markers, pose: Array) -> Shared:
    """As neck.yaml has it, seen from `pose`, (6,)."""
    placement = np.array([[*m.at, m.angle] for m in markers.on_bars], dtype=float)
    return Shared(pose, placement, np.stack([arm.L, arm.b]), np.zeros((0, 6)))


@dataclass(frozen=True)
class Scene:
    """An arm and its markers."""

    arm: Arm
    markers: Markers
    free_lengths: bool = False
    """whether L and b may move; otherwise derivatives by them are not computed but zero"""

    @property
    def bodies(self) -> list[int]:
        """Of each marker, which body carries it: bars 0..N, then diagonals A1, B1, A2, ..."""
        n = self.arm.N
        return [
            n + 1 + 2 * (int(m.diagonal[1:]) - 1) + "AB".index(m.diagonal[0]) if m.diagonal else int(m.bar or 0)
            for m in self.markers.on_bars
        ]

    @property
    def square(self) -> Complex:
        """Corners of a marker about its middle, (4,), m, in OpenCV's order."""
        s = self.markers.size / 2
        return np.array([-s + 1j * s, s + 1j * s, s - 1j * s, -s - 1j * s])

    def carriers(self, lengths: Array, alpha: Array) -> tuple[Complex, Array]:
        """Middle (m) and angle (rad) of each marker's bar, (F, markers), at alpha (F, N)."""
        p = poses(replace(self.arm, L=lengths[0], b=lengths[1]), alpha)
        flat = (len(alpha), -1)
        middle = np.concatenate([p.bar_middle, p.diagonal_middle.reshape(flat)], axis=1)
        angle = np.concatenate([p.bar_angle, p.diagonal_angle.reshape(flat)], axis=1)
        return middle[:, self.bodies], angle[:, self.bodies]

    def plane(self, placement: Array, lengths: Array, alpha: Array) -> Complex:
        """Corners in the arm's plane, (F, markers, 4), m."""
        middle, angle = self.carriers(lengths, alpha)
        local = (placement[:, 0] + 1j * placement[:, 1])[:, None] + np.exp(1j * placement[:, 2:]) * self.square
        return middle[..., None] + np.exp(1j * angle)[..., None] * local

    def image(self, shared: Shared, alpha: Array, course: Array) -> Complex:
        """Corners in the image, (F, markers, 4); `course`, (F, terms): how much of each drift term a frame has."""
        return onto_image(self.plane(shared.placement, shared.lengths, alpha), frame_poses(shared, course))

    def by_angles(self, shared: Shared, alpha: Array, course: Array) -> Complex:
        """Derivatives of `image` by the frame's angles, (F, markers, 4, N)."""
        pose = frame_poses(shared, course)
        steps = STEP * np.eye(alpha.shape[1])

        def moved(step: Array) -> Complex:
            return onto_image(self.plane(shared.placement, shared.lengths, alpha + step), pose)

        return np.stack([moved(s) - moved(-s) for s in steps], axis=-1) / (2 * STEP)

    def by_shared(self, shared: Shared, alpha: Array, course: Array) -> Complex:
        """Derivatives of `image` by `shared.vector`, (F, markers, 4, p)."""
        pose = frame_poses(shared, course)
        plane = self.plane(shared.placement, shared.lengths, alpha)
        by_pose = _difference(lambda step: onto_image(plane, pose + step), 6)
        by_place = _difference(lambda s: onto_image(self.plane(shared.placement + s, shared.lengths, alpha), pose), 3)
        by_length = np.zeros((*plane.shape, shared.lengths.size), dtype=complex)
        if self.free_lengths:
            by_length = _difference(
                lambda s: onto_image(self.plane(shared.placement, shared.lengths + s.reshape(2, -1), alpha), pose),
                shared.lengths.size,
            )
        # a marker's place moves that marker alone
        own = np.zeros((*plane.shape, *shared.placement.shape), dtype=complex)
        for k in range(len(shared.placement)):
            own[:, k, :, k] = by_place[:, k]
        drift = by_pose[..., None, :] * course[:, None, None, :, None]
        flat = (*plane.shape, -1)
        return np.concatenate([by_pose, own.reshape(flat), by_length, drift.reshape(flat)], axis=-1)


def frame_poses(shared: Shared, course: Array) -> Array:
    """The camera's pose at each frame, (F, 6)."""
    return shared.pose + course @ shared.drift


def onto_image(points: Complex, pose: Array) -> Complex:
    """Plane points (F, ...), m, in normalised image coordinates, seen from poses of shape (6,) or (F, 6)."""
    R, t = rotations(pose[..., :3]), pose[..., 3:]
    X, Y = points.real, points.imag
    around = (slice(None), *[None] * (points.ndim - 1)) if pose.ndim == 2 else ()
    x, y, z = (R[..., i, 0][around] * X + R[..., i, 1][around] * Y + t[..., i][around] for i in range(3))
    return (x + 1j * y) / z


def onto_plane(image: Complex, pose: Array) -> Complex:
    """Normalised image coordinates back onto the arm's plane, complex, m; pose (6,)."""
    R = rotations(pose[:3])
    H = np.linalg.inv(np.column_stack([R[:, 0], R[:, 1], pose[3:]]))
    x, y = image.real, image.imag
    X, Y, w = (H[i, 0] * x + H[i, 1] * y + H[i, 2] for i in range(3))
    return X / w + 1j * (Y / w)


def rotations(vectors: Array) -> Array:
    """Rotation vectors (..., 3), rad, as matrices (..., 3, 3), smooth also beyond half a turn."""
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    cross = np.zeros((*vectors.shape, 3))
    x, y, z = np.moveaxis(vectors, -1, 0)
    cross[..., 0, 1], cross[..., 0, 2], cross[..., 1, 2] = -z, y, -x
    cross[..., 1, 0], cross[..., 2, 0], cross[..., 2, 1] = z, -y, x
    # sin a / a and (1 - cos a) / a^2 without a division by zero
    return np.eye(3) + np.sinc(angle / np.pi) * cross + np.sinc(angle / (2 * np.pi)) ** 2 / 2 * (cross @ cross)


def _difference(value: Callable[[Array], Complex], size: int) -> Complex:
    steps = STEP * np.eye(size)
    return np.stack([value(s) - value(-s) for s in steps], axis=-1) / (2 * STEP)
