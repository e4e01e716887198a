"""A cable that goes slack for moments, while the others go on making the torques that the motion needs."""

import numpy as np

from samples.generator.prescribed import STEP_S, Slack
from samples.generator.taut_string import Array

_TIMES = (2, 5)
"""least number, and one more than the most; in a recording of less than _SHORT_S once is enough"""
_SHORT_S = 15.0
_HANGING_S = (0.4, 1.0)
_RAMP_S = 0.15
_APART_S = 0.5
_LEFT_N = 2.0
"""of tension that other cables keep"""


def slackening(cable: int, depth: float, share: float, rng: np.random.Generator) -> Slack:
    """Cable number `cable` (from 0) loses this share of its tension, and hangs `depth` m where it has lost all.

    Tensions may change along one direction only without changing a torque, so that this happens where the motion leaves
    the cable the least of all; a motion with too few such moments is none for it.
    """

    def slack(tension: Array, Z: Array) -> tuple[Array, Array] | None:
        along = _without_torque(Z)
        along = along / along[:, [cable]]
        rest = np.delete(tension - along * tension[:, [cable]], cable, axis=1).min(axis=1)
        windows = _windows(rest > _LEFT_N, rng)
        if len(windows) < (_TIMES[0] if len(tension) * STEP_S > _SHORT_S else 1):
            return None
        lost, hanging = np.zeros(len(tension)), np.zeros_like(tension)
        ramp = round(_RAMP_S / STEP_S)
        for first, last in windows:
            u = np.clip(np.minimum(np.arange(last - first), np.arange(last - first)[::-1]) / ramp, 0, 1)
            lost[first:last] = u**3 * (10 - 15 * u + 6 * u**2)
            loose = slice(first + ramp, last - ramp)
            hanging[loose, cable] = depth * np.sin(np.linspace(0, np.pi, last - first - 2 * ramp)) ** 4
        return tension - along * (share * lost * tension[:, cable])[:, None], hanging

    return slack


def _without_torque(Z: Array) -> Array:
    """The tensions that make no torque, (T, M), to a factor; Z (T, M - 1, M): its minors, with alternating signs."""
    m = Z.shape[-1]
    return np.stack([(-1) ** j * np.linalg.det(np.delete(Z, j, axis=-1)) for j in range(m)], axis=-1)


def _windows(possible: Array, rng: np.random.Generator) -> list[tuple[int, int]]:
    """Some spans of rows, first and last, in which slackening is possible throughout, in random order."""
    edges = np.diff(np.concatenate([[0], possible.astype(int), [0]]))
    spans = np.stack([np.flatnonzero(edges > 0), np.flatnonzero(edges < 0)], axis=-1)
    shortest, longest = (round((s + 2 * _RAMP_S) / STEP_S) for s in _HANGING_S)
    wanted = rng.integers(*_TIMES)
    out: list[tuple[int, int]] = []
    for first, last in rng.permutation(spans):
        if last - first > shortest and len(out) < wanted:
            rows = int(rng.integers(shortest, min(longest, last - first) + 1))
            start = int(rng.integers(first, last - rows + 1))
            if all(min(start + rows, b) + _APART_S / STEP_S < max(start, a) for a, b in out):
                out.append((start, start + rows))
    return out
