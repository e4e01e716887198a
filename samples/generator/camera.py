"""The camera that saw the sample: a pinhole with lens distortion, its place in front of the arm, and its faults.

Pixels follow OpenCV: an integer coordinate is the centre of a pixel, so the picture spans -0.5 .. width - 0.5.
The plane of motion is z = 0 of the base frame (x right, y up, z towards the viewer); the camera's own frame has
x right, y down, z forward.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

Vector = tuple[float, float, float]
FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Camera:
    """One camera, with everything that turns a scene into grey levels. Hashable, so that its maps are made once."""

    width: int
    """px"""
    height: int
    """px"""
    fx: float
    """px"""
    fy: float
    """px"""
    cx: float
    """px"""
    cy: float
    """px"""
    k1: float
    k2: float
    p1: float
    p2: float
    k3: float
    rotation: Vector
    """rotation vector of T_camera_base, rad"""
    translation: Vector
    """the base frame's origin in the camera's frame, m"""
    exposure_s: float
    """s; the shutter is global and a frame's time is the middle of its exposure"""
    psf_sigma_px: float
    """standard deviation of the lens blur, px; the area of a pixel comes on top"""
    read_noise: float
    """standard deviation of the noise of a black pixel, grey levels"""
    shot_noise: float
    """added variance for each grey level of signal, grey levels"""
    vignette: float
    """share of the light that is lost in the farthest corner"""

    @property
    def size(self) -> tuple[int, int]:
        """(width, height), px"""
        return self.width, self.height

    @property
    def matrix(self) -> FloatArray:
        """Camera matrix, shape (3, 3), px."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    @property
    def distortion(self) -> FloatArray:
        """k1, k2, p1, p2, k3 in OpenCV's order, shape (5,)."""
        return np.array([self.k1, self.k2, self.p1, self.p2, self.k3])

    @property
    def T_camera_base(self) -> FloatArray:
        """Pose, shape (4, 4), m."""
        return pose(self.rotation, self.translation)

    def scaled(self, factor: float) -> "Camera":
        """The same view on a sensor of fewer or more pixels; blur in pixels and noise stay."""
        return replace(
            self,
            width=round(self.width * factor),
            height=round(self.height * factor),
            fx=self.fx * factor,
            fy=self.fy * factor,
            cx=(self.cx + 0.5) * factor - 0.5,  # the picture's corner at -0.5 is what stays
            cy=(self.cy + 0.5) * factor - 0.5,
        )

    def project(self, points_base: ArrayLike) -> FloatArray:
        """Pixels, shape (..., 2), of points of the base frame, shape (..., 3), m; (..., 2) means z = 0."""
        points = np.asarray(points_base, dtype=float)
        if points.shape[-1] == 2:
            points = np.concatenate([points, np.zeros((*points.shape[:-1], 1))], axis=-1)
        return self.project_from(self.T_camera_base, points)

    def project_from(self, T_camera_body: FloatArray, points_body: FloatArray) -> FloatArray:
        """Pixels of points, shape (..., 3), m, of a body at the given pose, shape (4, 4) -> (..., 2)."""
        points = points_body @ T_camera_body[:3, :3].T + T_camera_body[:3, 3]
        return self._to_pixel(self._distort(points[..., :2] / points[..., 2:]))

    def directions(self, pixels: ArrayLike) -> FloatArray:
        """Undistorted directions x/z, y/z of pixels, shape (..., 2), px -> (..., 2).

        The distortion moves a point by a few per cent only, so plain substitution gains more than a digit a step;
        it goes on until nothing moves any more.
        """
        distorted = (np.asarray(pixels, dtype=float) - (self.cx, self.cy)) / (self.fx, self.fy)
        guess = distorted.copy()
        for _ in range(60):
            step = distorted - self._distort(guess)
            guess = guess + step
            if np.abs(step).max(initial=0.0) < 1e-13:
                break
        return guess

    def on_plane(self, pixels: ArrayLike) -> FloatArray:
        """Points x, y of the plane of motion, shape (..., 2), m, that pixels, shape (..., 2), px, look at."""
        return meet_plane(self.directions(pixels), self.T_camera_base)

    def _distort(self, x: FloatArray) -> FloatArray:
        """Brown's model as OpenCV writes it, on normalised coordinates, shape (..., 2)."""
        u, v = x[..., 0], x[..., 1]
        r2 = u * u + v * v
        radial = 1 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3))
        return np.stack(
            [
                u * radial + 2 * self.p1 * u * v + self.p2 * (r2 + 2 * u * u),
                v * radial + self.p1 * (r2 + 2 * v * v) + 2 * self.p2 * u * v,
            ],
            axis=-1,
        )

    def _to_pixel(self, x: FloatArray) -> FloatArray:
        return x * (self.fx, self.fy) + (self.cx, self.cy)


def rotation_matrix(vector: ArrayLike) -> FloatArray:
    """Rodrigues: rotation vector, shape (3,), rad -> shape (3, 3)."""
    v = np.asarray(vector, dtype=float)
    angle = float(np.linalg.norm(v))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = v / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def rotation_vector(R: FloatArray) -> Vector:
    """Inverse of `rotation_matrix`, also near half a turn, where this camera is: through the eigenvector of 1."""
    values, vectors = np.linalg.eig(R)
    axis = np.real(vectors[:, np.argmin(np.abs(values - 1))])
    skew = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    angle = np.arctan2(axis @ skew, np.trace(R) - 1)
    x, y, z = (axis * angle).tolist()
    return x, y, z


def pose(rotation: ArrayLike, translation: ArrayLike) -> FloatArray:
    """Rotation vector, shape (3,), rad, and translation, shape (3,), m -> shape (4, 4)."""
    T = np.eye(4)
    T[:3, :3] = rotation_matrix(rotation)
    T[:3, 3] = translation
    return T


def facing(aim: ArrayLike, distance: float, yaw: float, pitch: float, roll: float) -> FloatArray:
    """T_camera_plane, shape (4, 4), of a plane whose point `aim`, shape (2,), m, is `distance` m straight ahead.

    At zero angles the camera looks squarely at the plane, with the plane's x to the right and its y up;
    yaw, pitch and roll (rad) then turn the plane about the camera's y, x and z.
    """
    half_turn = np.diag([1.0, -1.0, -1.0])  # z towards the viewer against z forward
    turned = rotation_matrix((0, 0, roll)) @ rotation_matrix((pitch, 0, 0)) @ rotation_matrix((0, yaw, 0)) @ half_turn
    T = np.eye(4)
    T[:3, :3] = turned
    T[:3, 3] = np.array([0.0, 0.0, distance]) - turned[:, :2] @ np.asarray(aim, dtype=float)
    return T


def meet_plane(directions: FloatArray, T_camera_plane: FloatArray) -> FloatArray:
    """Points x, y, shape (..., 2), m, of a body's plane z = 0 that are seen in directions x/z, y/z, shape (..., 2)."""
    to_image = T_camera_plane[:3, [0, 1, 3]]
    x = np.concatenate([directions, np.ones((*directions.shape[:-1], 1))], axis=-1) @ np.linalg.inv(to_image).T
    return x[..., :2] / x[..., 2:]


@lru_cache(maxsize=4)
def pixel_directions(camera: Camera) -> FloatArray:
    """Undistorted direction of every pixel, shape (height, width, 2); read only."""
    v, u = np.mgrid[0 : camera.height, 0 : camera.width]
    directions = camera.directions(np.stack([u, v], axis=-1))
    directions.flags.writeable = False
    return directions


def _sample_camera() -> Camera:
    T = facing(aim=(0.0, 0.125), distance=0.65, yaw=np.radians(12), pitch=np.radians(5), roll=np.radians(-1.5))
    x, y, z = T[:3, 3].tolist()
    return Camera(
        *(1280, 720, 1290.4, 1288.1, 647.3, 353.6),
        *(-0.121, 0.052, 4e-4, -3e-4, -0.008),
        rotation=rotation_vector(T[:3, :3]),
        translation=(x, y, z),
        exposure_s=0.004,
        psf_sigma_px=0.8,
        read_noise=1.2,
        shot_noise=0.035,
        vignette=0.18,
    )


SAMPLE_CAMERA = _sample_camera()
"""A machine vision camera 0.65 m from the arm, a little to its side: a marker of 30 mm is about 60 px wide."""
