"""The lens model plumb_bob (Brown's, as ROS and OpenCV write it): mathematics only.

p = [fx, fy, cx, cy, k1, k2, p1, p2, k3]; a point (X, Y, Z) of the camera frame (x right, y down, z forward) falls on
x = X/Z, y = Y/Z, r2 = x^2 + y^2, c = 1 + k1 r2 + k2 r2^2 + k3 r2^3 and
    u = fx (x c + 2 p1 x y + p2 (r2 + 2 x^2)) + cx
    v = fy (y c + p1 (r2 + 2 y^2) + 2 p2 x y) + cy.
"""

import numpy as np

NAMES = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3")


def distort(rays: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Rays (x, y), shape (n, 2), to pixels, shape (n, 2)."""
    x, y = rays[:, 0], rays[:, 1]
    r2 = x * x + y * y
    c = 1 + r2 * (p[4] + r2 * (p[5] + r2 * p[8]))
    u = p[0] * (x * c + 2 * p[6] * x * y + p[7] * (r2 + 2 * x * x)) + p[2]
    v = p[1] * (y * c + p[6] * (r2 + 2 * y * y) + 2 * p[7] * x * y) + p[3]
    return np.column_stack([u, v])


def ray_jacobian(rays: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Derivative of the pixels by the rays, shape (n, 2, 2)."""
    x, y = rays[:, 0], rays[:, 1]
    r2 = x * x + y * y
    c = 1 + r2 * (p[4] + r2 * (p[5] + r2 * p[8]))
    slope = 2 * (p[4] + r2 * (2 * p[5] + r2 * 3 * p[8]))  # dc/dx = slope x, dc/dy = slope y
    cross = slope * x * y + 2 * p[6] * x + 2 * p[7] * y
    out = np.empty((len(rays), 2, 2))
    out[:, 0, 0] = p[0] * (c + slope * x * x + 2 * p[6] * y + 6 * p[7] * x)
    out[:, 0, 1] = p[0] * cross
    out[:, 1, 0] = p[1] * cross
    out[:, 1, 1] = p[1] * (c + slope * y * y + 6 * p[6] * y + 2 * p[7] * x)
    return out


def parameter_jacobian(rays: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Derivative of the pixels by the nine parameters, shape (n, 2, 9)."""
    x, y = rays[:, 0], rays[:, 1]
    r2 = x * x + y * y
    ideal = (distort(rays, p) - p[2:4]) / p[:2]
    out = np.zeros((len(rays), 2, 9))
    out[:, 0, 0], out[:, 1, 1] = ideal[:, 0], ideal[:, 1]
    out[:, 0, 2] = out[:, 1, 3] = 1.0
    for column, power in ((4, r2), (5, r2**2), (8, r2**3)):
        out[:, 0, column], out[:, 1, column] = p[0] * x * power, p[1] * y * power
    out[:, 0, 6], out[:, 1, 6] = p[0] * 2 * x * y, p[1] * (r2 + 2 * y * y)
    out[:, 0, 7], out[:, 1, 7] = p[0] * (r2 + 2 * x * x), p[1] * 2 * x * y
    return out


def undistort(pixels: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Pixels, shape (n, 2), to rays (x, y), shape (n, 2), by Newton's method, to 1e-9 px.

    NaN where the model has no inverse: beyond the radius at which the lens model turns back.
    """
    pixels = np.asarray(pixels, np.float64).reshape(-1, 2)
    rays = (pixels - p[2:4]) / p[:2]
    for _ in range(30):
        error = distort(rays, p) - pixels
        if not np.any(np.abs(error) > 1e-9):
            break
        jacobian = ray_jacobian(rays, p)
        determinant = np.linalg.det(jacobian)
        turning = ~(np.abs(determinant) > 1e-3 * p[0] * p[1])
        jacobian[turning] = np.diag(p[:2])
        step = np.linalg.solve(jacobian, error[..., None])[..., 0]
        # far out the polynomial is wild: no step longer than half a radian's tangent
        step *= np.minimum(1.0, 0.5 / np.maximum(np.linalg.norm(step, axis=1), 1e-12))[:, None]
        rays = rays - step
    lost = (np.abs(distort(rays, p) - pixels).max(axis=1, initial=0.0) > 1e-6) | ~unfolded(rays, p)
    rays[lost] = np.nan
    return rays


def unfolded(rays: np.ndarray, p: np.ndarray) -> np.ndarray:
    """True where the radial part still grows all the way from the middle to the ray, shape (n,)."""
    r2 = np.sum(rays**2, axis=1)
    steps = np.linspace(0.0, 1.0, 33)[1:, None] * r2
    return np.all(1 + steps * (3 * p[4] + steps * (5 * p[5] + steps * 7 * p[8])) > 0, axis=0)
