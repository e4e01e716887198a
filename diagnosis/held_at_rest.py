"""Joints and motors that dry friction holds at rest: against anything up to its greatest, whatever a law of their speed says.

What stands there beyond a law is neither noise nor another cause. Where a law has dry friction of joints, or of cables on their
pulleys, rows at rest count by what is seen of it. Motors have dry friction always, and count so once it is plain that theirs does
so (diagnosis/sticking_motors.py): most are well described by the law.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from diagnosis.input_variance import residuals_of_friction
from identification.signals import Signals

Array = NDArray[np.float64]

_SLIDES, _RESTS = 0.1, 0.5
"""of the greatest square of what may hold: up to where it slides, and from where it is at rest"""
_MIN_ROWS = 30
"""of either, for what is seen of it to be told"""
_HELD_S = 0.2
"""s: how long friction that holds something stays alike, at least"""


@dataclass(frozen=True)
class HeldShares:
    """Of the squares of what may hold motors and joints at rest otherwise than the laws say: what is seen of it."""

    motors: float = 0.0
    joints: float = 0.0

    def furthest_from(self, other: "HeldShares") -> float:
        """The larger of both differences."""
        return max(abs(self.motors - other.motors), abs(self.joints - other.joints))


NOTHING_HELD = HeldShares()


@dataclass(frozen=True)
class HeldAtRest:
    """By what dry friction may hold motors and joints at rest otherwise than the laws say, on one recording."""

    motors: Array
    """(T, M), N"""
    joints: Array
    """(T, N), N m"""

    def motor_squares(self, s: Signals) -> Array:
        """In the rows of the motors' equations, (M, S), N^2."""
        return _square_at_rows(self.motors, s)

    def joint_squares(self, s: Signals) -> Array:
        """In the rows of the arm's equations, (N, S), (N m)^2, of what holds joints themselves."""
        return _square_at_rows(self.joints, s)

    def variance(self, shares: HeldShares, s: Signals) -> Array:
        """Of all channels' rows, (C, S)."""
        of_motors = (
            shares.motors * self.motor_squares(s) if shares.motors else np.zeros((s.arm.M, len(s.low_pass.kept)))
        )
        lever = (s.Z[s.low_pass.kept] ** 2).transpose(1, 2, 0)
        of_joints = np.einsum("nms,ms->ns", lever, of_motors)
        if shares.joints:
            of_joints = of_joints + shares.joints * self.joint_squares(s)
        return np.concatenate([of_motors, of_joints])

    def residuals(self, shares: HeldShares, s: Signals, rng: np.random.Generator) -> Array:
        """Of all channels, (C, S), by one draw of what holds motors and joints."""
        out = np.zeros((s.arm.M + s.arm.N, len(s.low_pass.kept)))
        if shares.joints:
            out[s.arm.M :] -= s.low_pass((np.sqrt(shares.joints) * self.joints * _lasting(self.joints, s, rng)).T)
        if shares.motors:
            out += residuals_of_friction(s, np.sqrt(shares.motors) * self.motors * _lasting(self.motors, s, rng))
        return out


def held_share(excess: Sequence[Array], squares: Sequence[Array]) -> float:
    """Of the squares of what may hold joints, or motors, what is seen where they rest beyond what is left where they slide.

    excess: squares of each recording's residuals beyond those of noise, (K, S), of K joints or motors; squares: of what may hold
    them, in the same rows. Friction holds by no more than all of it.
    """
    seen = possible = 0.0
    for left, square in zip(np.concatenate(excess, axis=1), np.concatenate(squares, axis=1), strict=True):
        slides, rests = slides_and_rests(square)
        if min(slides.sum(), rests.sum()) >= _MIN_ROWS:
            seen += float(np.sum(left[rests] - max(0.0, np.mean(left[slides]))))
            possible += float(np.sum(square[rests]))
    return seen / possible if possible else 0.0


def slides_and_rests(square: Array) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Rows in which something plainly slides, and in which it plainly rests, by the square of what may hold it, (..., S)."""
    greatest = square.max(axis=-1, keepdims=True)
    return square < _SLIDES * greatest, square > _RESTS * greatest


def _square_at_rows(held: Array, s: Signals) -> Array:
    return np.maximum(s.low_pass((held**2).T), 0.0)


def _lasting(held: Array, s: Signals, rng: np.random.Generator) -> Array:
    """Noise of variance one that stays alike for a while, as large as `held`."""
    stays = np.exp(-s.step / _HELD_S)
    return np.asarray(lfilter([np.sqrt(1 - stays**2)], [1.0, -stays], rng.normal(size=held.shape), axis=0))
