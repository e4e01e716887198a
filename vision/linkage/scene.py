"""The arm with its markers before a camera: where every corner falls in the image, and its derivatives by all unknowns.

A frame's own unknowns are alpha_1..N. Shared by all frames are the camera's pose, where each marker sits on its bar, how far
before the arm's plane and how tilted, the lengths L and b, and the changes of the camera's pose in the course of the recording.
Points along the plane are complex numbers, their heights above it, towards the camera, are real; image points are normalised
coordinates x + jy of the camera frame (on its plane z = 1).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mechanism.arm import Arm
from mechanism.geometry import poses
from mechanism.printed_markers import Markers

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

PLACEMENT = 6
"""numbers that say where a marker is on its bar"""
DIFFERENCE_STEP = 1e-6
"""rad and m, of central differences"""


@dataclass(frozen=True)
class SharedParameters:
    """The parameters that all frames have in common; a fit may estimate any of them."""

    pose: Array
    """(6,): rvec (rad) and tvec (m) of T_camera_base"""
    placement: Array
    """(markers, 6), of each marker on its bar: x, y (m) and angle (rad); depth (m), its middle's height above the arm's plane; tilt
    out of that plane, a rotation vector along the marker's own x and y (rad)"""
    lengths: Array
    """(2, N): L and b, m"""
    drift: Array
    """(terms, 6): change of the pose that goes with each drift term; (0, 6) where the camera stood still"""

    @property
    def vector(self) -> Array:
        """All parameters, shape (p,): pose, placement, lengths, drift."""
        return np.concatenate([self.pose, self.placement.ravel(), self.lengths.ravel(), self.drift.ravel()])

    def plus(self, change: Array) -> "SharedParameters":
        """These parameters with `change`, shape (p,), added."""
        v = self.vector + change
        lengths = 6 + self.placement.size
        drift = lengths + self.lengths.size
        return SharedParameters(
            pose=v[:6],
            placement=v[6:lengths].reshape(self.placement.shape),
            lengths=v[lengths:drift].reshape(self.lengths.shape),
            drift=v[drift:].reshape(-1, 6),
        )


def nominal_parameters(arm: Arm, markers: Markers, pose: Array) -> SharedParameters:
    """The parameters of neck.yaml and a camera at `pose`, (6,), that does not drift."""
    placement = np.array([[*m.at, m.angle, m.depth_known[0], 0.0, 0.0] for m in markers.on_bars], dtype=float)
    return SharedParameters(pose, placement, np.stack([arm.L, arm.b]), np.zeros((0, 6)))


@dataclass(frozen=True)
class Scene:
    """An arm and its markers."""

    arm: Arm
    markers: Markers
    free_lengths: bool = False
    """whether L and b are estimated; otherwise the derivatives by them are not computed but zero"""

    @property
    def bodies(self) -> list[int]:
        """The body that carries each marker: bars 0..N, then diagonals A1, B1, A2, ..."""
        n = self.arm.N
        return [
            n + 1 + 2 * (int(m.diagonal[1:]) - 1) + "AB".index(m.diagonal[0]) if m.diagonal else int(m.bar or 0)
            for m in self.markers.on_bars
        ]

    @property
    def square(self) -> Complex:
        """Corners of a marker relative to its middle, (4,), m, in OpenCV's order."""
        s = self.markers.size / 2
        return np.array([-s + 1j * s, s + 1j * s, s - 1j * s, -s - 1j * s])

    def carriers(self, lengths: Array, alpha: Array) -> tuple[Complex, Array]:
        """Middle (m) and angle (rad) of the bar that carries each marker, both (F, markers), at alpha (F, N)."""
        p = poses(replace(self.arm, L=lengths[0], b=lengths[1]), alpha)
        flat = (len(alpha), -1)
        middle = np.concatenate([p.bar_middle, p.diagonal_middle.reshape(flat)], axis=1)
        angle = np.concatenate([p.bar_angle, p.diagonal_angle.reshape(flat)], axis=1)
        return middle[:, self.bodies], angle[:, self.bodies]

    def on_bars(self, placement: Array) -> tuple[Complex, Array]:
        """Corners in the frames of their bars, along the arm's plane and above it, both (markers, 4), m."""
        tilt = rotation_matrices(np.pad(placement[:, 4:], ((0, 0), (0, 1))))
        x, y, z = np.moveaxis(tilt[..., :2] @ np.stack([self.square.real, self.square.imag]), 1, 0)
        along = (placement[:, 0] + 1j * placement[:, 1])[:, None] + np.exp(1j * placement[:, 2:3]) * (x + 1j * y)
        return along, placement[:, 3:4] + z

    def points(self, placement: Array, lengths: Array, alpha: Array) -> tuple[Complex, Array]:
        """Corners along the arm's plane, (F, markers, 4), and above it, (markers, 4), m."""
        middle, angle = self.carriers(lengths, alpha)
        along, height = self.on_bars(placement)
        return middle[..., None] + np.exp(1j * angle)[..., None] * along, height

    def image(self, shared: SharedParameters, alpha: Array, course: Array) -> Complex:
        """Corners in the image, (F, markers, 4); course: share of each drift term that a frame has, (F, terms)."""
        return project_to_image(*self.points(shared.placement, shared.lengths, alpha), poses_by_frame(shared, course))

    def by_angles(self, shared: SharedParameters, alpha: Array, course: Array) -> Complex:
        """Derivatives of the corners in the image by the frame's angles, (F, markers, 4, N)."""
        pose = poses_by_frame(shared, course)
        steps = DIFFERENCE_STEP * np.eye(alpha.shape[1])

        def image_at(step: Array) -> Complex:
            return project_to_image(*self.points(shared.placement, shared.lengths, alpha + step), pose)

        return np.stack([image_at(s) - image_at(-s) for s in steps], axis=-1) / (2 * DIFFERENCE_STEP)

    def by_shared(self, shared: SharedParameters, alpha: Array, course: Array) -> Complex:
        """Derivatives of the corners in the image by `shared.vector`, (F, markers, 4, p)."""
        pose = poses_by_frame(shared, course)
        along, height = self.points(shared.placement, shared.lengths, alpha)
        by_pose = _difference(lambda step: project_to_image(along, height, pose + step), 6)
        by_each = _difference(
            lambda s: project_to_image(*self.points(shared.placement + s, shared.lengths, alpha), pose), PLACEMENT
        )
        by_length = np.zeros((*along.shape, shared.lengths.size), dtype=complex)
        if self.free_lengths:
            by_length = _difference(
                lambda s: project_to_image(
                    *self.points(shared.placement, shared.lengths + s.reshape(2, -1), alpha), pose
                ),
                shared.lengths.size,
            )
        # the placement of a marker moves that marker only
        by_placement = np.zeros((*along.shape, *shared.placement.shape), dtype=complex)
        for k in range(len(shared.placement)):
            by_placement[:, k, :, k] = by_each[:, k]
        by_drift = by_pose[..., None, :] * course[:, None, None, :, None]
        flat = (*along.shape, -1)
        return np.concatenate([by_pose, by_placement.reshape(flat), by_length, by_drift.reshape(flat)], axis=-1)


def poses_by_frame(shared: SharedParameters, course: Array) -> Array:
    """The camera's pose at each frame, (F, 6): rvec (rad) and tvec (m) of T_camera_base."""
    return shared.pose + course @ shared.drift


def project_to_image(along: Complex, height: Array, pose: Array) -> Complex:
    """Points `along` the arm's plane (F, ...) and at a `height` above it, m, as normalised image coordinates.

    pose: of the camera, (6,) or (F, 6).
    """
    R, t = rotation_matrices(pose[..., :3]), pose[..., 3:]
    X, Y = along.real, along.imag
    per_frame = (slice(None), *[None] * (along.ndim - 1)) if pose.ndim == 2 else ()
    x, y, z = (
        R[..., i, 0][per_frame] * X
        + R[..., i, 1][per_frame] * Y
        + R[..., i, 2][per_frame] * height
        + t[..., i][per_frame]
        for i in range(3)
    )
    return (x + 1j * y) / z


def image_to_plane(image: Complex, pose: Array) -> Complex:
    """Normalised image coordinates as points of the arm's plane, m, for one pose (6,)."""
    R = rotation_matrices(pose[:3])
    H = np.linalg.inv(np.column_stack([R[:, 0], R[:, 1], pose[3:]]))
    x, y = image.real, image.imag
    X, Y, w = (H[i, 0] * x + H[i, 1] * y + H[i, 2] for i in range(3))
    return X / w + 1j * (Y / w)


def rotation_matrices(vectors: Array) -> Array:
    """Rotation vectors (..., 3), rad, as matrices (..., 3, 3), smooth also beyond half a turn."""
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    cross = np.zeros((*vectors.shape, 3))
    x, y, z = np.moveaxis(vectors, -1, 0)
    cross[..., 0, 1], cross[..., 0, 2], cross[..., 1, 2] = -z, y, -x
    cross[..., 1, 0], cross[..., 2, 0], cross[..., 2, 1] = z, -y, x
    # sin a / a and (1 - cos a) / a^2 without a division by zero
    return np.eye(3) + np.sinc(angle / np.pi) * cross + np.sinc(angle / (2 * np.pi)) ** 2 / 2 * (cross @ cross)


def _difference(value: Callable[[Array], Complex], size: int) -> Complex:
    """Central differences of `value` at zero by each of `size` numbers, on a new last axis."""
    steps = DIFFERENCE_STEP * np.eye(size)
    return np.stack([value(s) - value(-s) for s in steps], axis=-1) / (2 * DIFFERENCE_STEP)
