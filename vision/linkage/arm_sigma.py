"""What a camera's uncertainty does to the joint angles of an arm seen through it.

The arm is seen straight and with all joints bent by 30 degrees to either side; its pose, one for all, and its angles are
fitted to its markers' corners through the same camera, as extraction does. What the pose absorbs is no error of an angle.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.camera import Camera
from calibration.projection import by_pose, carried
from mechanism.arm import arm_of
from mechanism.description import Neck, markers_of
from vision.linkage.scene import Scene, nominal
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

BENDS = (0.0, np.pi / 6, -np.pi / 6)
"""rad, of all joints"""
_STEP = 1e-6
_FILLED = 0.9
"""of the picture, by the arm in all its poses, where no distance is given"""


@dataclass(frozen=True)
class PlaneArm:
    """Points that move in a plane with joint angles."""

    joints: int
    points: Callable[[Array], Complex]
    """angles (F, joints), rad, to points (F, n), m: x right, y up"""
    name: str


@dataclass(frozen=True)
class ArmSigma:
    """One sigma of the camera, at the arm."""

    alpha: Array
    """of each joint in each of BENDS, (poses, joints), rad"""
    bend: Array
    """of the joint's motion from straight to bent, which a constant error of its zero leaves alone, (2, joints), rad"""
    pixels: Array
    """the points in each pose, (poses, n, 2), px"""
    sigma_px: Array
    """of their pixels, the arm's pose refitted but not its angles, (poses, n)"""
    distance: float
    """m"""
    scale: float
    """px of 1 mm in the arm's plane"""
    name: str

    @property
    def worst_alpha(self) -> float:
        """rad."""
        return float(self.alpha.max())

    @property
    def px(self) -> float:
        """Root mean square over points, px."""
        return float(np.sqrt(np.mean(self.sigma_px**2)))

    @property
    def mm(self) -> float:
        """The same in the arm's plane."""
        return self.px / self.scale

    def as_json(self) -> dict[str, object]:
        """For --json."""
        return {
            "body": self.name,
            "distance_m": self.distance,
            "px": self.px,
            "mm": self.mm,
            "alpha_rad": self.alpha.tolist(),
            "alpha_worst_rad": self.worst_alpha,
            "bends_rad": list(BENDS),
            "bend_worst_rad": float(self.bend.max()),
        }


def neck_arm(neck: Neck, where: str) -> PlaneArm:
    """The corners of the markers of neck.yaml. Raises Refused where it has none."""
    scene = Scene(arm_of(neck), markers_of(neck, where))
    shared = nominal(scene.arm, scene.markers, np.zeros(6))

    def points(alpha: Array) -> Complex:
        return scene.plane(shared.placement, shared.lengths, alpha).reshape(len(alpha), -1)

    return PlaneArm(neck.N, points, f"markers of {where}")


def link_arm(length: float) -> PlaneArm:
    """A hinge between two links of `length`, m, each with a square marker of a fifth of it in its middle."""
    half = length / 10
    square = np.array([-half + 1j * half, half + 1j * half, half - 1j * half, -half - 1j * half])

    def points(alpha: Array) -> Complex:
        below = np.broadcast_to(square - 0.5j * length, (len(alpha), 4))
        return np.concatenate([below, np.exp(1j * alpha) * (square + 0.5j * length)], axis=1)

    return PlaneArm(1, points, f"two links of {1e3 * length:g} mm")


def arm_sigma(camera: Camera, arm: PlaneArm, distance: float | None = None) -> ArmSigma:
    """One sigma of `camera` at the arm, which faces it in the middle of the picture at `distance`, m.

    Without a distance the arm in all its poses fills the picture. Raises Refused where the arm does not fit into it.
    """
    alpha = np.array(BENDS)[:, None] * np.ones(arm.joints)
    plane = arm.points(alpha)
    low = complex(plane.real.min(), plane.imag.min())
    high = complex(plane.real.max(), plane.imag.max())
    extent = np.array([high.real - low.real, high.imag - low.imag])
    focal = camera.parameters[:2]
    away = distance or float(np.max(focal * extent / (_FILLED * np.array(camera.size))))
    # the camera's y is down, the arm's up; its middle lies where the picture's middle is
    ray = camera.rays((np.array(camera.size)[None] - 1) / 2)[0]

    def seen(angles: Array) -> Array:
        """Points in the camera frame, (F n, 3), m."""
        at = (arm.points(angles) - (low + high) / 2).ravel()
        return np.column_stack([at.real + ray[0] * away, -at.imag + ray[1] * away, np.full(len(at), away)])

    def fits(pixels: Array) -> bool:
        return bool(np.all((pixels > -0.5) & (pixels < np.array(camera.size) - 0.5)))

    points = seen(alpha)
    pixels = camera.project(points, np.zeros(3), np.zeros(3))
    while distance is None and not fits(pixels) and away < 1e3:  # a lens that stretches the picture's edges
        away *= 1.03
        points = seen(alpha)
        pixels = camera.project(points, np.zeros(3), np.zeros(3))
    if not fits(pixels):
        what = f"at {away:g} m the arm bent by 30 degrees does not fit into the picture"
        raise Refused("distance", what, "give a larger one")
    rays = points[:, :2] / points[:, 2:]
    if np.max(np.abs(camera.rays(pixels) - rays)) > 1e-6:  # also true for NaN
        raise Refused("camera", "its lens model turns back within the arm's picture", "calibrate with corners there")
    pose = by_pose(points)
    frames, joints = alpha.shape
    turns = np.zeros((len(points), 2, frames * joints))
    per = len(points) // frames
    for k in range(frames):
        for i in range(joints):
            step = np.zeros_like(alpha)
            step[k, i] = _STEP
            moved = (seen(alpha + step) - seen(alpha - step))[:, :2] / (2 * _STEP * away)
            turns[k * per : (k + 1) * per, :, k * joints + i] = moved[k * per : (k + 1) * per]
    whole = carried(camera, rays, np.concatenate([pose, turns], axis=2)).covariance[6:, 6:]
    rigid = carried(camera, rays, pose).sigma
    changes = np.concatenate([-np.tile(np.eye(joints), (2, 1)), np.eye(2 * joints)], axis=1)
    return ArmSigma(
        np.sqrt(np.diag(whole)).reshape(frames, joints),
        np.sqrt(np.diag(changes @ whole @ changes.T)).reshape(2, joints),
        pixels.reshape(frames, per, 2),
        rigid.reshape(frames, per),
        away,
        float(np.mean(focal)) / away / 1e3,
        arm.name,
    )
