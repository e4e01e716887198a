"""Refinement of a board's corners to a few hundredths of a pixel by a blurred saddle fitted to the grey values around each.

Where four squares meet, grey = a + b . du + c erf(d1 / s1) erf(d2 / s2), with d1 and d2 the distances from the two
edges and s1, s2 the blur across each (motion blurs one more than the other). The point, the directions of both edges,
their blurs, the light's slope and the contrast are estimated. The model is symmetric under half a turn about its point. So is
the picture of such a corner with bled ink or a curved tone scale: neither displaces the corner.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import erf

_MAX_REACH_PX = 9
"""px: half side of the largest window, within which the lens bends edges by 1e-2 px"""
_MAX_ITERATIONS = 20
_TOLERANCE_PX = 1e-4
"""px: a corner that a step moves by less stays"""
_BLUR_RANGE_PX = (0.4, 8.0)
"""px: allowed values of s1 and s2"""


@dataclass(frozen=True)
class Saddles:
    """Fitted corners."""

    points: np.ndarray  # shape (k, 2), px
    sigma: np.ndarray  # standard deviation of one coordinate, from the residual grey values, shape (k,), px
    blur: np.ndarray  # standard deviation of the point spread across each of the two edges, shape (k, 2), px
    residual: np.ndarray  # root mean square of the residual grey values as a share of half the contrast, shape (k,)


def fit_saddles(grey: np.ndarray, points: np.ndarray, squares: np.ndarray, reach: float, arm: float) -> Saddles:
    """Fit a saddle near each of `points`, shape (k, 2), px, whose error must not exceed the blur by much.

    `squares`, shape (k, 2, 2): the columns are the two sides of a square at that point, px. Used are grey values up to `reach`
    squares from the corner, up to `arm` squares from one of its edges (which leaves out markers), and up to 9 px away.
    """
    k = len(points)
    base = np.round(points).astype(int)
    span = np.arange(-_MAX_REACH_PX, _MAX_REACH_PX + 1)
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
    weight &= np.hypot(du[:, 0], du[:, 1]) <= _MAX_REACH_PX
    columns, weight, values = _packed(weight, values)
    du = du[columns]
    p = points - base
    normals = np.stack([-squares[:, 1], squares[:, 0]], axis=1)  # columns: across each side
    angles = np.arctan2(normals[:, 1], normals[:, 0])
    state = np.column_stack([p, angles, np.full((k, 2), 1.5)])
    weights = weight.astype(float)
    linear = _linear(_saddle(state, du)[0], du, values, weights)
    state = np.column_stack([state, linear])
    damping = np.full(k, 1e-3)
    residual, jacobian = _residuals(state, du, values, weights)
    cost, normal = np.sum(residual**2, axis=1), jacobian.transpose(0, 2, 1) @ jacobian
    moving = np.arange(k)
    for _ in range(_MAX_ITERATIONS):
        diagonal = np.einsum("kii->ki", normal[moving])
        damped = normal[moving] + (damping[moving, None] * diagonal + 1e-9)[:, :, None] * np.eye(10)
        gradient = jacobian[moving].transpose(0, 2, 1) @ residual[moving, :, None]
        step = np.linalg.solve(damped, -gradient)[..., 0]
        trial = state[moving] + step
        trial[:, 4:6] = np.clip(trial[:, 4:6], *_BLUR_RANGE_PX)
        new_residual, new_jacobian = _residuals(trial, du[moving], values[moving], weights[moving])
        new_cost = np.sum(new_residual**2, axis=1)
        better = new_cost < cost[moving]
        moved, new_jacobian = moving[better], new_jacobian[better]
        state[moved], residual[moved], jacobian[moved] = trial[better], new_residual[better], new_jacobian
        cost[moved], normal[moved] = new_cost[better], new_jacobian.transpose(0, 2, 1) @ new_jacobian
        damping[moving] *= np.where(better, 0.1, 10.0)
        moving = moving[np.abs(step[:, :2]).max(axis=1) >= _TOLERANCE_PX]
        if not len(moving):
            break
    count = weight.sum(axis=1)
    variance = cost / np.maximum(count - 10, 1)
    covariance = np.linalg.pinv(normal, hermitian=True)[:, :2, :2] * variance[:, None, None]
    sigma = np.sqrt(np.einsum("kii->k", covariance) / 2)
    residual_share = np.sqrt(variance) / np.maximum(np.abs(state[:, 9]), 1e-6)
    return Saddles(base + state[:, :2], sigma, state[:, 4:6] / np.sqrt(2), residual_share)


def _packed(weight: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The used pixels of each window, first in each row: their places, weights and values, shape (k, p) with p the most of any."""
    most = max(1, int(weight.sum(axis=1).max(initial=0)))
    places = np.argsort(~weight, axis=1, kind="stable")[:, :most]
    return places, np.take_along_axis(weight, places, axis=1), np.take_along_axis(values, places, axis=1)


def _saddle(state: np.ndarray, du: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """erf erf at pixels du (k, p, 2), shape (k, p), and its derivatives by (x, y, angle 1, angle 2, s1, s2), shape (k, p, 6)."""
    offset = du - state[:, None, :2]
    cosine, sine = np.cos(state[:, None, 2:4]), np.sin(state[:, None, 2:4])
    s = state[:, None, 4:6]
    across = (cosine * offset[..., :1] + sine * offset[..., 1:]) / s
    along = cosine * offset[..., 1:] - sine * offset[..., :1]
    edges = erf(across)
    # derivatives by the distance from each edge
    slopes = 2 / np.sqrt(np.pi) * np.exp(-(across**2)) / s * edges[..., ::-1]
    by_point = np.stack([-np.sum(slopes * cosine, axis=2), -np.sum(slopes * sine, axis=2)], axis=2)
    return edges[..., 0] * edges[..., 1], np.concatenate([by_point, slopes * along, -slopes * across], axis=2)


def _linear(saddle: np.ndarray, du: np.ndarray, values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Level, slopes and contrast by linear least squares, shape (k, 4)."""
    columns = np.concatenate([np.ones_like(du[..., :1]), du, saddle[..., None]], axis=2) * weights[..., None]
    turned = columns.transpose(0, 2, 1)
    return np.linalg.solve(turned @ columns + 1e-9 * np.eye(4), turned @ values[..., None])[..., 0]


def _residuals(
    state: np.ndarray, du: np.ndarray, values: np.ndarray, weights: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Predicted less observed grey values, shape (k, p), and their derivatives by the ten unknowns, shape (k, p, 10)."""
    saddle, slopes = _saddle(state, du)
    level, contrast = state[:, 6, None], state[:, 9, None]
    predicted = level + (du @ state[:, 7:9, None])[..., 0] + contrast * saddle
    jacobian = np.concatenate([contrast[..., None] * slopes, np.ones_like(du[..., :1]), du, saddle[..., None]], axis=2)
    return (predicted - values) * weights, jacobian * weights[..., None]
