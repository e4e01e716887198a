"""The lens model plumb_bob (Brown's, as ROS and OpenCV write it): mathematics only.

p = [fx, fy, cx, cy, k1, k2, p1, p2, k3]; a point (X, Y, Z) of the camera frame (x right, y down, z forward) falls on
x = X/Z, y = Y/Z, r2 = x^2 + y^2, c = 1 + k1 r2 + k2 r2^2 + k3 r2^3 and
    u = fx (x c + 2 p1 x y + p2 (r2 + 2 x^2)) + cx
    v = fy (y c + p1 (r2 + 2 y^2) + 2 p2 x y) + cy.
"""

import numpy as np

PARAMETER_NAMES = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3")
LENS_MODELS = {
    "k1 k2": PARAMETER_NAMES[:6],
    "k1 k2 p1 p2": PARAMETER_NAMES[:8],
    "k1 k2 p1 p2 k3": PARAMETER_NAMES,
}
"""The lens models to choose from and their free parameters; each model is part of the next. The rational model is not among
them: its coefficients diverge, and held-out views gain nothing."""


def rays_to_pixels(rays: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Rays (x, y), shape (..., 2), to pixels, shape (..., 2); `p` of shape (9,), or one for each ray, (..., 9)."""
    fx, fy, cx, cy, k1, k2, p1, p2, k3 = np.moveaxis(p, -1, 0)
    x, y = rays[..., 0], rays[..., 1]
    xx, yy, xy = x * x, y * y, x * y
    r2 = xx + yy
    c = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    u = fx * (x * c + 2 * p1 * xy + p2 * (r2 + 2 * xx)) + cx
    v = fy * (y * c + p1 * (r2 + 2 * yy) + 2 * p2 * xy) + cy
    return np.stack([u, v], axis=-1)


def ray_jacobian(rays: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Derivative of the pixels by the rays, shape (..., 2, 2); `p` as in `rays_to_pixels`."""
    fx, fy, _, _, k1, k2, p1, p2, k3 = np.moveaxis(p, -1, 0)
    x, y = rays[..., 0], rays[..., 1]
    r2 = x * x + y * y
    c = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    slope = 2 * (k1 + r2 * (2 * k2 + r2 * 3 * k3))  # dc/dx = slope x, dc/dy = slope y
    cross = slope * x * y + 2 * p1 * x + 2 * p2 * y
    out = np.empty((*r2.shape, 2, 2))
    out[..., 0, 0] = fx * (c + slope * x * x + 2 * p1 * y + 6 * p2 * x)
    out[..., 0, 1] = fx * cross
    out[..., 1, 0] = fy * cross
    out[..., 1, 1] = fy * (c + slope * y * y + 6 * p1 * y + 2 * p2 * x)
    return out


def parameter_jacobian(rays: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Derivative of the pixels by the nine parameters `p`, shape (9,): shape (..., 2, 9)."""
    x, y = rays[..., 0], rays[..., 1]
    xx, yy, xy = x * x, y * y, x * y
    r2 = xx + yy
    out = np.zeros((*r2.shape, 2, 9))
    ideal = (rays_to_pixels(rays, p) - p[2:4]) / p[:2]
    out[..., 0, 0], out[..., 1, 1] = ideal[..., 0], ideal[..., 1]
    out[..., 0, 2] = out[..., 1, 3] = 1.0
    fx, fy = p[0] * x, p[1] * y
    power = r2
    for column in (4, 5, 8):
        out[..., 0, column], out[..., 1, column] = fx * power, fy * power
        power = power * r2
    out[..., 0, 6], out[..., 1, 6] = 2 * p[0] * xy, p[1] * (r2 + 2 * yy)
    out[..., 0, 7], out[..., 1, 7] = p[0] * (r2 + 2 * xx), 2 * p[1] * xy
    return out


def pixels_to_rays(pixels: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Pixels, shape (n, 2), to rays (x, y), shape (n, 2), by Newton's method, to 1e-9 px.

    NaN where the model has no inverse: beyond the radius at which the lens model turns back.
    """
    pixels = np.asarray(pixels, np.float64).reshape(-1, 2)
    rays = (pixels - p[2:4]) / p[:2]
    for _ in range(30):
        error = rays_to_pixels(rays, p) - pixels
        if not np.any(np.abs(error) > 1e-9):
            break
        jacobian = ray_jacobian(rays, p)
        determinant = np.linalg.det(jacobian)
        singular = ~(np.abs(determinant) > 1e-3 * p[0] * p[1])
        jacobian[singular] = np.diag(p[:2])
        step = np.linalg.solve(jacobian, error[..., None])[..., 0]
        # far out the polynomial oscillates: no step is longer than half a radian's tangent
        step *= np.minimum(1.0, 0.5 / np.maximum(np.linalg.norm(step, axis=1), 1e-12))[:, None]
        rays = rays - step
    failed = (np.abs(rays_to_pixels(rays, p) - pixels).max(axis=1, initial=0.0) > 1e-6) | ~is_invertible(rays, p)
    rays[failed] = np.nan
    return rays


def is_invertible(rays: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Whether the radial part grows all the way from the middle to the ray, so that the model has an inverse there, shape (n,)."""
    r2 = np.sum(rays**2, axis=1)
    steps = np.linspace(0.0, 1.0, 33)[1:, None] * r2
    return np.all(1 + steps * (3 * p[4] + steps * (5 * p[5] + steps * 7 * p[8])) > 0, axis=0)
