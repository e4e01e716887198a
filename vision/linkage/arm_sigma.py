"""A camera's uncertainty as the standard deviation of the joint angles of an arm before it.

The arm stands straight and with all joints bent by 30 degrees to either side; one pose for all and the angles are fitted to its
markers' corners through the same camera, as extraction does. What the pose absorbs is no error of an angle.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibration.camera import Camera
from calibration.projection_uncertainty import propagate_covariance, rays_by_pose
from mechanism.arm import arm_of
from mechanism.description import Neck, markers_of
from vision.linkage.scene import Scene, nominal_parameters
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

BENDS_RAD = (0.0, np.pi / 6, -np.pi / 6)
"""rad: bends of all joints in which the arm is looked at"""
_STEP_RAD = 1e-6
_FILLED_SHARE = 0.9
"""of the picture that the arm in all its bends fills where no distance is given"""


@dataclass(frozen=True)
class PlanarArm:
    """Points that move in a plane with joint angles."""

    joints: int
    points: Callable[[Array], Complex]
    """from angles (F, joints), rad, to points (F, n), m: x right, y up"""
    name: str


@dataclass(frozen=True)
class ArmSigma:
    """One standard deviation of the camera as errors at the arm."""

    alpha: Array
    """standard deviation of each joint's angle in each of BENDS_RAD, (bends, joints), rad"""
    bend: Array
    """standard deviation of each joint's motion from straight to bent, free of a constant error of its zero, (2, joints), rad"""
    pixels: Array
    """the points in each bend, (bends, n, 2), px"""
    sigma_px: Array
    """standard deviation of their pixels, the arm's pose refitted but not its angles, (bends, n)"""
    distance: float
    """from the camera to the arm's plane, m"""
    px_per_mm: float
    """in the arm's plane"""
    name: str
    """of the arm"""

    @property
    def worst_alpha(self) -> float:
        """Largest standard deviation of an angle, rad."""
        return float(self.alpha.max())

    @property
    def px(self) -> float:
        """Root mean square of `sigma_px` over all points."""
        return float(np.sqrt(np.mean(self.sigma_px**2)))

    @property
    def mm(self) -> float:
        """Root mean square of `sigma_px` as a length in the arm's plane, mm."""
        return self.px / self.px_per_mm

    def as_json(self) -> dict[str, object]:
        """The record for --json."""
        return {
            "body": self.name,
            "distance_m": self.distance,
            "px": self.px,
            "mm": self.mm,
            "alpha_rad": self.alpha.tolist(),
            "alpha_worst_rad": self.worst_alpha,
            "bends_rad": list(BENDS_RAD),
            "bend_worst_rad": float(self.bend.max()),
        }


def marker_arm(neck: Neck, where: str) -> PlanarArm:
    """The corners of the markers of a neck.yaml called `where`. Raises Refused where it has none."""
    scene = Scene(arm_of(neck), markers_of(neck, where))
    shared = nominal_parameters(scene.arm, scene.markers, np.zeros(6))

    def points(alpha: Array) -> Complex:
        return scene.points(shared.placement, shared.lengths, alpha)[0].reshape(len(alpha), -1)

    return PlanarArm(neck.N, points, f"markers of {where}")


def two_link_arm(length: float) -> PlanarArm:
    """A hinge between two links of `length`, m, each with a square marker of a fifth of that side in its middle."""
    half = length / 10
    square = np.array([-half + 1j * half, half + 1j * half, half - 1j * half, -half - 1j * half])

    def points(alpha: Array) -> Complex:
        below = np.broadcast_to(square - 0.5j * length, (len(alpha), 4))
        return np.concatenate([below, np.exp(1j * alpha) * (square + 0.5j * length)], axis=1)

    return PlanarArm(1, points, f"two links of {1e3 * length:g} mm")


def arm_sigma(camera: Camera, arm: PlanarArm, distance: float | None = None) -> ArmSigma:
    """One standard deviation of `camera` at an arm that faces it in the middle of the picture at `distance`, m.

    Without a distance the arm in all its bends fills the picture. Raises Refused where the arm does not fit into it.
    """
    alpha = np.array(BENDS_RAD)[:, None] * np.ones(arm.joints)
    view = _facing(camera, arm, alpha, distance)
    points, pixels = view.points(alpha), view.pixels(alpha)
    rays = points[:, :2] / points[:, 2:]
    if np.max(np.abs(camera.rays(pixels) - rays)) > 1e-6:  # also true for NaN
        raise Refused("camera", "its lens model turns back within the arm's picture", "calibrate with corners there")
    pose = rays_by_pose(points)
    bends, joints = alpha.shape
    by_angles = np.concatenate([pose, _rays_by_angles(view, alpha)], axis=2)
    angles = propagate_covariance(camera, rays, by_angles).covariance[6:, 6:]
    rigid = propagate_covariance(camera, rays, pose).sigma
    from_straight = np.concatenate([-np.tile(np.eye(joints), (2, 1)), np.eye(2 * joints)], axis=1)
    return ArmSigma(
        alpha=np.sqrt(np.diag(angles)).reshape(bends, joints),
        bend=np.sqrt(np.diag(from_straight @ angles @ from_straight.T)).reshape(2, joints),
        pixels=pixels.reshape(bends, -1, 2),
        sigma_px=rigid.reshape(bends, -1),
        distance=view.distance,
        px_per_mm=float(np.mean(camera.parameters[:2])) / view.distance / 1e3,
        name=arm.name,
    )


@dataclass(frozen=True)
class _ArmView:
    """An arm that faces a camera, its middle where the middle of the picture is."""

    camera: Camera
    arm: PlanarArm
    middle: complex
    """of the arm's plane, m"""
    distance: float
    """m"""

    def points(self, alpha: Array) -> Array:
        """The arm's points at angles (F, joints), rad, in the camera frame, (F n, 3), m."""
        # the camera's y is down, the arm's up
        ray = self.camera.rays((np.array(self.camera.size)[None] - 1) / 2)[0]
        at = (self.arm.points(alpha) - self.middle).ravel()
        x, y = at.real + ray[0] * self.distance, -at.imag + ray[1] * self.distance
        return np.column_stack([x, y, np.full(len(at), self.distance)])

    def pixels(self, alpha: Array) -> Array:
        """The arm's points in the picture, (F n, 2), px."""
        return self.camera.project(self.points(alpha), np.zeros(3), np.zeros(3))

    def fits(self, alpha: Array) -> bool:
        """Whether all points lie in the picture."""
        pixels = self.pixels(alpha)
        return bool(np.all((pixels > -0.5) & (pixels < np.array(self.camera.size) - 0.5)))


def _facing(camera: Camera, arm: PlanarArm, alpha: Array, distance: float | None) -> _ArmView:
    """The arm at `distance`, or where it fills the picture in all of the poses `alpha`, (bends, joints)."""
    plane = arm.points(alpha)
    low = complex(plane.real.min(), plane.imag.min())
    high = complex(plane.real.max(), plane.imag.max())
    extent = np.array([high.real - low.real, high.imag - low.imag])
    filled = float(np.max(camera.parameters[:2] * extent / (_FILLED_SHARE * np.array(camera.size))))
    view = _ArmView(camera, arm, (low + high) / 2, distance or filled)
    while (
        distance is None and not view.fits(alpha) and view.distance < 1e3
    ):  # a lens that stretches the picture's edges
        view = replace(view, distance=view.distance * 1.03)
    if not view.fits(alpha):
        what = f"at {view.distance:g} m the arm bent by 30 degrees does not fit into the picture"
        raise Refused("distance", what, "give a larger one")
    return view


def _rays_by_angles(view: _ArmView, alpha: Array) -> Array:
    """Derivatives of the rays by every angle of every bend, (bends n, 2, bends joints)."""
    bends, joints = alpha.shape
    count = len(view.points(alpha))
    per_bend = count // bends
    slopes = np.zeros((count, 2, bends * joints))
    for k in range(bends):
        rows = slice(k * per_bend, (k + 1) * per_bend)
        for i in range(joints):
            step = np.zeros_like(alpha)
            step[k, i] = _STEP_RAD
            change = (view.points(alpha + step) - view.points(alpha - step))[:, :2] / (2 * _STEP_RAD * view.distance)
            slopes[rows, :, k * joints + i] = change[rows]
    return slopes
