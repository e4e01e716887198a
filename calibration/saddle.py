"""Corners of a board to a few hundredths of a pixel: a blurred saddle fitted to the grey values around each.

Where four squares meet, grey = a + b . du + c erf(d1 / s1) erf(d2 / s2), with d1 and d2 the distances from the two
edges and s1, s2 the blur across each (motion blurs one more than the other). The point, the directions of both edges,
their blurs, the light's slope and the contrast are estimated. Half a turn about its point leaves the model as it is, and
so it does the picture of such a corner, be the print's ink bled or the camera's tones curved: neither moves the corner.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import erf

_LARGEST = 9  # px: the lens bends edges, by 1e-2 px within such a window
_ITERATIONS = 20
_BLUR = (0.4, 8.0)  # px, of s


@dataclass(frozen=True)
class Saddles:
    """Fitted corners."""

    points: np.ndarray  # shape (k, 2), px
    sigma: np.ndarray  # standard deviation of one coordinate, from the grey values left over, shape (k,), px
    blur: np.ndarray  # standard deviation of the point spread across each of the two edges, shape (k, 2), px
    rest: np.ndarray  # grey values left over, root mean square, as a part of half the contrast, shape (k,)


def fit_saddles(grey: np.ndarray, points: np.ndarray, squares: np.ndarray, reach: float, arm: float) -> Saddles:
    """Fit a saddle near each of `points`, shape (k, 2), px, which must be right to about the blur.

    `squares`, shape (k, 2, 2): the columns are a square's two sides in px there. Grey values count up to `reach` squares
    from the corner, and up to `arm` squares from one of its edges (between markers: what is white), and no more than
    9 px away.
    """
    k = len(points)
    base = np.round(points).astype(int)
    span = np.arange(-_LARGEST, _LARGEST + 1)
    du = np.stack(np.meshgrid(span, span), axis=-1).reshape(-1, 2).astype(float)
    at = base[:, None, :] + du.astype(int)
    inside = np.all((at >= 0) & (at < np.array(grey.shape)[::-1]), axis=2)
    at = np.clip(at, 0, np.array(grey.shape)[::-1] - 1)
    values = grey[at[..., 1], at[..., 0]].astype(float)
    board = np.abs(np.einsum("kij,kpj->kpi", np.linalg.inv(squares), base[:, None] + du - points[:, None]))
    # never less than 2 px along the edges and 1.5 across: below that there is nothing to fit
    scale = np.linalg.svd(squares, compute_uv=False)[:, 1][:, None]
    weight = inside & (board.max(axis=2) < np.maximum(reach, 2.5 / scale))
    weight &= board.min(axis=2) < np.maximum(arm, 1.5 / scale)
    weight &= np.hypot(du[:, 0], du[:, 1]) <= _LARGEST
    p = points - base
    normals = np.stack([-squares[:, 1], squares[:, 0]], axis=1)  # columns: across each side
    angles = np.arctan2(normals[:, 1], normals[:, 0])
    state = np.column_stack([p, angles, np.full((k, 2), 1.5)])
    weights = weight.astype(float)
    linear = _linear(_saddle(state, du)[0], du, values, weights)
    state = np.column_stack([state, linear])
    damping = np.full(k, 1e-3)
    rest, jacobian = _residuals(state, du, values, weights)
    cost = np.sum(rest**2, axis=1)
    for _ in range(_ITERATIONS):
        normal = np.einsum("kpi,kpj->kij", jacobian, jacobian)
        diagonal = np.einsum("kii->ki", normal)
        damped = normal + (damping[:, None] * diagonal + 1e-9)[:, :, None] * np.eye(10)
        step = np.linalg.solve(damped, -np.einsum("kpi,kp->ki", jacobian, rest)[..., None])[..., 0]
        trial = state + step
        trial[:, 4:6] = np.clip(trial[:, 4:6], _BLUR[0], _BLUR[1])
        new_rest, new_jacobian = _residuals(trial, du, values, weights)
        new_cost = np.sum(new_rest**2, axis=1)
        better = new_cost < cost
        state[better], rest[better] = trial[better], new_rest[better]
        jacobian[better], cost[better] = new_jacobian[better], new_cost[better]
        damping = np.where(better, damping / 10, damping * 10)
        if np.all(np.abs(step[:, :2]).max(axis=1) < 1e-4):
            break
    count = weight.sum(axis=1)
    variance = cost / np.maximum(count - 10, 1)
    normal = np.einsum("kpi,kpj->kij", jacobian, jacobian)
    covariance = np.linalg.pinv(normal, hermitian=True)[:, :2, :2] * variance[:, None, None]
    sigma = np.sqrt(np.einsum("kii->k", covariance) / 2)
    rest_of_contrast = np.sqrt(variance) / np.maximum(np.abs(state[:, 9]), 1e-6)
    return Saddles(base + state[:, :2], sigma, state[:, 4:6] / np.sqrt(2), rest_of_contrast)


def _saddle(state: np.ndarray, du: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """erf erf, shape (k, p), and its derivatives by (x, y, angle 1, angle 2, s1, s2), shape (k, p, 6)."""
    away = du[None] - state[:, None, :2]
    cosine, sine = np.cos(state[:, None, 2:4]), np.sin(state[:, None, 2:4])
    s = state[:, None, 4:6]
    across = (cosine * away[..., :1] + sine * away[..., 1:]) / s
    along = cosine * away[..., 1:] - sine * away[..., :1]
    edges = erf(across)
    # by the distance from each edge
    slopes = 2 / np.sqrt(np.pi) * np.exp(-(across**2)) / s * edges[..., ::-1]
    by_point = np.stack([-np.sum(slopes * cosine, axis=2), -np.sum(slopes * sine, axis=2)], axis=2)
    return edges[..., 0] * edges[..., 1], np.concatenate([by_point, slopes * along, -slopes * across], axis=2)


def _linear(saddle: np.ndarray, du: np.ndarray, values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Level, slopes and contrast that fit best, shape (k, 4)."""
    flat = np.broadcast_to(np.column_stack([np.ones(len(du)), du]), (*saddle.shape, 3))
    columns = np.concatenate([flat, saddle[..., None]], axis=2) * weights[..., None]
    normal = np.einsum("kpi,kpj->kij", columns, columns) + 1e-9 * np.eye(4)
    return np.linalg.solve(normal, np.einsum("kpi,kp->ki", columns, values)[..., None])[..., 0]


def _residuals(
    state: np.ndarray, du: np.ndarray, values: np.ndarray, weights: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Predicted less seen, shape (k, p), and by the ten unknowns, shape (k, p, 10)."""
    saddle, by = _saddle(state, du)
    flat = np.broadcast_to(np.column_stack([np.ones(len(du)), du]), (*saddle.shape, 3))
    predicted = np.einsum("kpi,ki->kp", flat, state[:, 6:9]) + state[:, 9, None] * saddle
    jacobian = np.concatenate([state[:, 9, None, None] * by, flat, saddle[..., None]], axis=2)
    return (predicted - values) * weights, jacobian * weights[..., None]
