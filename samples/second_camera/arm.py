"""Where the bars and diagonals of stacked crossed linkages are: the upper bar is moved until both diagonals have their length."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Links:
    """One pose of the arm in its plane, x right, y up, m; angles in rad."""

    middles: Array
    """(N + 1, 2), of bars 0..N"""
    turns: Array
    """(N + 1,)"""
    ends: Array
    """(N + 1, 2, 2): left and right end of each bar"""

    def carrier(self, marker: dict[str, Any]) -> tuple[Array, float]:
        """Middle (2,) and direction of what carries a marker of neck.yaml."""
        if not marker.get("diagonal"):
            k = int(marker["bar"])
            return self.middles[k], float(self.turns[k])
        side, i = marker["diagonal"][0], int(marker["diagonal"][1:])
        low, high = (0, 1) if side == "A" else (1, 0)
        start, end = self.ends[i - 1, low], self.ends[i, high]
        return (start + end) / 2, float(np.arctan2(*(end - start)[::-1]))


def links(alpha: Array, neck: dict[str, Any]) -> Links:
    """The arm of neck.yaml's contents at joint angles (N,), rad."""
    middles, turns, ends = [np.zeros(2)], [0.0], [_ends(np.zeros(2), 0.0, float(neck["mechanisms"][0]["b"]))]
    for angle, mechanism in zip(alpha, neck["mechanisms"], strict=True):
        L, b = float(mechanism["L"]), float(mechanism["b"])
        turn = turns[-1] + float(angle)
        left, right = _ends(middles[-1], turns[-1], b)
        at = middles[-1] + np.sqrt(L**2 - b**2) * np.array([-np.sin(turn - angle / 2), np.cos(turn - angle / 2)])
        for _ in range(20):
            new_left, new_right = _ends(at, turn, b)
            A, B = new_right - left, new_left - right
            off = np.array([A @ A - L**2, B @ B - L**2])
            if np.abs(off).max() < 1e-16:
                break
            at = at - np.linalg.solve(2 * np.stack([A, B]), off)
        middles.append(at)
        turns.append(turn)
        ends.append(_ends(at, turn, b))
    return Links(np.stack(middles), np.array(turns), np.stack(ends))


def _ends(middle: Array, turn: float, b: float) -> Array:
    half = b / 2 * np.array([np.cos(turn), np.sin(turn)])
    return np.stack([middle - half, middle + half])
