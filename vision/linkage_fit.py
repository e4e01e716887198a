"""From marker corners to joint angles: the arm as one object in its plane, seen by a calibrated camera.

Unknown are the camera's pose against the base bar, one for the recording, and alpha_1..N of every frame. All markers of all
bars enter together through the linkage's geometry, so a bar whose marker is hidden keeps its angle where its neighbours
determine it. Residuals are taken in undistorted pixels, focal length times normalised coordinates.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.camera import Camera
from mechanism.arm import Arm, arm_of
from mechanism.description import Markers, Neck, markers_of
from mechanism.geometry import poses
from xneck.errors import Refused

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

POSE_FRAMES = 300
"""frames, spread over the recording, from which the camera's pose is estimated"""
MAX_SIGMA = np.radians(3.0)
"""an angle less certain than this counts as not seen"""
ROUNDS = 30
HUBER = 3.0
"""standard deviations from which on a corner pulls with constant force only"""


@dataclass(frozen=True)
class LinkageFit:
    """Angles of all frames and what they rest on."""

    alpha: Array
    """(F, N), rad; NaN where the frame's markers do not determine it"""
    covariance: Array
    """(F, N, N), rad^2; from the corners' noise as the residuals show it"""
    rvec: Array
    """rotation vector of T_camera_base, (3,)"""
    tvec: Array
    """translation of T_camera_base, (3,), m"""
    pose_sigma: Array
    """standard deviations of rvec (rad) and tvec (m), (6,)"""
    corner_sigma_px: float
    residual_px: Array
    """RMS corner residual of each frame, (F,), px"""


def marker_points(markers: Markers) -> Complex:
    """Corners of all markers in their bars' frames as complex numbers, shape (markers, 4), m, in OpenCV's corner order."""
    s = markers.size / 2
    square = np.array([-s + 1j * s, s + 1j * s, s - 1j * s, -s - 1j * s])
    return np.array([complex(*m.at) + np.exp(1j * m.angle) * square for m in markers.on_bars])


def plane_points(arm: Arm, markers: Markers, alpha: Array) -> Complex:
    """Marker corners in the arm's plane, complex, shape (..., markers, 4), m, at alpha of shape (..., N)."""
    p = poses(arm, alpha)
    bars = [m.bar for m in markers.on_bars]
    return p.bar_middle[..., bars, None] + np.exp(1j * p.bar_angle[..., bars, None]) * marker_points(markers)


def onto_image(points: Complex, rvec: Array, tvec: Array) -> Complex:
    """Plane points (complex, z = 0) as normalised image coordinates x + jy, of the same shape."""
    R = cv2.Rodrigues(np.asarray(rvec, dtype=float))[0]
    X, Y = points.real, points.imag
    x, y, z = (R[i, 0] * X + R[i, 1] * Y + tvec[i] for i in range(3))
    return (x + 1j * y) / z


def onto_plane(image: Complex, rvec: Array, tvec: Array) -> Complex:
    """Normalised image coordinates x + jy back onto the plane z = 0, complex, m."""
    R = cv2.Rodrigues(np.asarray(rvec, dtype=float))[0]
    H = np.linalg.inv(np.column_stack([R[:, 0], R[:, 1], tvec]))
    x, y = image.real, image.imag
    X, Y, w = (H[i, 0] * x + H[i, 1] * y + H[i, 2] for i in range(3))
    return X / w + 1j * (Y / w)


def fit_linkage(neck: Neck, camera: Camera, corners: Array, where: str) -> LinkageFit:
    """Angles from corners of shape (F, markers, 4, 2), px as detected, NaN where a marker was not found.

    Raises Refused where no marker is on the base bar, or too few frames show what the pose needs.
    """
    markers = markers_of(neck, where)
    arm = arm_of(neck)
    focal = float(np.sqrt(camera.K[0, 0] * camera.K[1, 1]))
    flat = camera.rays(np.nan_to_num(corners.reshape(-1, 2)))
    image: Complex = (flat[:, 0] + 1j * flat[:, 1]).reshape(corners.shape[:-1])
    image[np.isnan(corners).any(axis=(-2, -1))] = np.nan
    seen = ~np.isnan(image[..., 0])
    chosen = _pose_frames(markers, seen, where)
    scene = _Scene(arm, markers, focal)
    fits = []
    for pose in _start(markers, image, chosen, where):
        first = _first_angles(markers, onto_plane(image[chosen], pose[:3], pose[3:]), arm.N)
        fits.append(_gauss_newton(scene, image[chosen], pose, first, free_pose=True))
    best = min(fits, key=lambda fit: fit.at.cost)
    pose = best.pose
    first = _first_angles(markers, onto_plane(image, pose[:3], pose[3:]), arm.N)
    fit = _gauss_newton(scene, image, pose, first, free_pose=False)
    measured = 2 * 4 * seen.sum(axis=1)
    freedom = np.maximum(measured - arm.N, 1)
    usable = measured > arm.N
    squares = np.sum(np.abs(fit.at.residual) ** 2, axis=1)
    # the median frame, so that a few frames with a wrong corner do not inflate all
    variance = float(np.median((squares / freedom)[usable])) if usable.any() else np.nan
    covariance = _inverse(fit.at.normal) * variance
    # a frame that fits worse than the median says so itself
    covariance = covariance * np.maximum(squares / freedom / variance, 1.0)[:, None, None]
    pose_covariance = np.linalg.inv(best.at.reduced) * variance
    by_pose = -fit.at.solved @ fit.at.mixed  # d alpha / d pose of the least squares, (F, N, 6)
    covariance = covariance + by_pose @ pose_covariance @ np.swapaxes(by_pose, 1, 2)
    sigma = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    return LinkageFit(
        alpha=np.where(sigma < MAX_SIGMA, fit.alpha, np.nan),
        covariance=covariance,
        rvec=pose[:3],
        tvec=pose[3:],
        pose_sigma=np.sqrt(np.diag(pose_covariance)),
        corner_sigma_px=float(np.sqrt(variance)),
        residual_px=np.sqrt(squares / np.maximum(measured / 2, 1)),
    )


def _pose_frames(markers: Markers, seen: NDArray[np.bool_], where: str) -> NDArray[np.intp]:
    """Frames for the pose: those with most markers, evenly spread; a base marker must be among them."""
    base = [k for k, m in enumerate(markers.on_bars) if m.bar == 0]
    if not base:
        raise Refused(where, "no marker sits on the base bar (bar 0)", "angles need one there as reference")
    if not seen.any():
        raise Refused(where, "not a single marker of the arm is in view", "check markers.dictionary and the light")
    with_base = seen[:, base].any(axis=1)
    if not with_base.any():
        raise Refused(where, "the base bar's marker is never in view", "place the camera so that it is")
    score = np.where(with_base, seen.sum(axis=1), 0)
    good = np.flatnonzero(score == score.max())
    return good[np.unique(np.linspace(0, len(good) - 1, POSE_FRAMES).astype(int))]


def _start(markers: Markers, image: Complex, chosen: NDArray[np.intp], where: str) -> list[Array]:
    """Both poses that a planar target allows, from the base bar's markers averaged over the frames (they stand still)."""
    on_base = [k for k, m in enumerate(markers.on_bars) if m.bar == 0 and not np.isnan(image[chosen, k, 0]).all()]
    points = marker_points(markers)[on_base].ravel()
    seen = np.nanmedian(image[chosen][:, on_base].real, axis=0) + 1j * np.nanmedian(
        image[chosen][:, on_base].imag, axis=0
    )
    world = np.column_stack([points.real, points.imag, np.zeros(points.size)])
    pixels = np.column_stack([seen.real.ravel(), seen.imag.ravel()])
    found, rvecs, tvecs, _ = cv2.solvePnPGeneric(world, pixels, np.eye(3), np.zeros(5), flags=cv2.SOLVEPNP_IPPE)
    if not found:
        raise Refused(where, "the base bar's marker does not give the camera's pose", "is markers.size right?")
    both = [np.concatenate([np.ravel(r), np.ravel(t)]).astype(float) for r, t in zip(rvecs, tvecs, strict=True)]
    return [pose for pose in both if pose[5] > 0]


def _first_angles(markers: Markers, plane: Complex, n: int) -> Array:
    """alpha of each frame from the markers' own directions, shape (F, N); a bar without one lies between its neighbours."""
    side = plane[..., 1] - plane[..., 0] + plane[..., 2] - plane[..., 3]
    direction = np.full((len(plane), n + 1), np.nan, dtype=complex)
    direction[:, 0] = 1.0
    for bar in range(1, n + 1):
        mine = [k for k, m in enumerate(markers.on_bars) if m.bar == bar]
        if mine:
            turned = side[:, mine] * np.exp(-1j * np.array([markers.on_bars[k].angle for k in mine]))
            direction[:, bar] = np.nansum(turned, axis=1)
    direction[direction == 0] = np.nan
    gamma = np.zeros((len(plane), n + 1))
    at = np.arange(n + 1)
    for k, row in enumerate(direction):
        known = ~np.isnan(row)
        gamma[k] = np.interp(at, at[known], np.unwrap(np.angle(row[known])))
    return np.clip(np.diff(gamma, axis=1), -2.5, 2.5)


@dataclass(frozen=True)
class _Scene:
    """The arm with its markers before a camera of unit pixels `focal`."""

    arm: Arm
    markers: Markers
    focal: float

    def corners(self, pose: Array, alpha: Array) -> Complex:
        """Undistorted pixels against the optical axis, complex, (F, 4 markers)."""
        points = onto_image(plane_points(self.arm, self.markers, alpha), pose[:3], pose[3:])
        return self.focal * points.reshape(len(alpha), -1)

    def slopes(self, pose: Array, alpha: Array) -> tuple[Complex, Complex]:
        """Derivatives of `corners` by the angles (F, 4 markers, N) and by the pose (F, 4 markers, 6), central differences."""
        h = 1e-6

        def stacked(values: list[Complex]) -> Complex:
            return np.stack(values, axis=-1) / (2 * h)

        by_angle = [self.corners(pose, alpha + d) - self.corners(pose, alpha - d) for d in h * np.eye(alpha.shape[1])]
        by_pose = [self.corners(pose + d, alpha) - self.corners(pose - d, alpha) for d in h * np.eye(6)]
        return stacked(by_angle), stacked(by_pose)


@dataclass(frozen=True)
class _Linear:
    """Normal equations at a pose and angles, corners weighted; g of the angles, (F, N), and of the pose, (6,)."""

    residual: Complex
    """(F, 4 markers), px, zero where not seen"""
    cost: float
    normal: Array
    """(F, N, N): J^T J by the angles"""
    mixed: Array
    """(F, N, 6): J^T J between angles and pose"""
    solved: Array
    """(F, N, N): inverse of normal, zero in directions without information"""
    reduced: Array
    """(6, 6): J^T J of the pose with the angles eliminated"""
    g_angles: Array
    g_pose: Array


@dataclass(frozen=True)
class _Fit:
    pose: Array
    alpha: Array
    at: _Linear


def _linearise(scene: _Scene, target: Complex, seen: NDArray[np.bool_], pose: Array, alpha: Array) -> _Linear:
    r = (target - scene.corners(pose, alpha)) * seen
    scale = 1.5 * float(np.median(np.abs(r[seen]))) + 1e-12
    w = np.minimum(1.0, HUBER * scale / np.maximum(np.abs(r), 1e-12)) * seen
    Ja, Jp = scene.slopes(pose, alpha)
    normal = np.einsum("fki,fk,fkj->fij", Ja.conj(), w, Ja).real
    mixed = np.einsum("fki,fk,fkj->fij", Ja.conj(), w, Jp).real
    solved = _inverse(normal, finite=True)
    full = np.einsum("fki,fk,fkj->ij", Jp.conj(), w, Jp).real
    return _Linear(
        residual=r,
        cost=float(np.sum(w * np.abs(r) ** 2)),
        normal=normal,
        mixed=mixed,
        solved=solved,
        reduced=full - np.einsum("fni,fnm,fmj->ij", mixed, solved, mixed),
        g_angles=np.einsum("fki,fk->fi", Ja.conj(), w * r).real,
        g_pose=np.einsum("fki,fk->i", Jp.conj(), w * r).real,
    )


def _gauss_newton(scene: _Scene, image: Complex, pose: Array, alpha: Array, free_pose: bool) -> _Fit:
    """All frames at once. The pose couples them, each frame's angles stand alone: they are eliminated by a Schur complement."""
    seen = ~np.isnan(image).reshape(len(image), -1)
    target = np.where(seen, scene.focal * image.reshape(seen.shape), 0)
    for _ in range(ROUNDS):
        k = _linearise(scene, target, seen, pose, alpha)
        turn = np.zeros(6)
        if free_pose:
            turn = np.linalg.solve(k.reduced, k.g_pose - np.einsum("fni,fnm,fm->i", k.mixed, k.solved, k.g_angles))
        change = np.einsum("fnm,fm->fn", k.solved, k.g_angles - k.mixed @ turn)
        pose = pose + turn
        alpha = np.clip(alpha + np.clip(change, -0.5, 0.5), -2.8, 2.8)
        if max(np.max(np.abs(change)), np.max(np.abs(turn))) < 1e-9:
            break
    return _Fit(pose, alpha, _linearise(scene, target, seen, pose, alpha))


def _inverse(normal: Array, finite: bool = False) -> Array:
    """Inverses of (F, N, N); a direction without information gets infinite variance, or none with `finite`."""
    w, v = np.linalg.eigh(normal)
    live = w > 1e-9 * np.maximum(w[:, -1:], 1e-300)
    inverse = np.where(live, 1 / np.where(live, w, 1.0), 0.0 if finite else 1e12)
    return np.einsum("fik,fk,fjk->fij", v, inverse, v)
