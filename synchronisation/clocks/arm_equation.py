"""Motor viscosity from the arm's equation, which hardly asks the clock: Z t = M alpha'' + c + g + joint friction.

With t = n - fs dry(theta') - fv theta', n late by a delay. Through the cables alone fv looks like an offset (5 ms for 0.02
N s/rad); here it turns the joints by Z fv theta', which no friction of the joints does. Masses, springs, a load at the tip,
the base's tilt, motors' inertia, how soon their friction turns over and joint friction are nuisances, and so are the
dimensions, which the cables tell too. Both sides pass the same filters.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from mechanism.arm import Arm
from mechanism.cable_lengths import Z
from mechanism.dynamics import terms
from synchronisation.clocks.cables import LARGER, larger
from synchronisation.clocks.signals import LogSignals, cubic, low_pass
from synchronisation.clocks.unknowns import ClockUnknowns

Array = NDArray[np.float64]

FINE = 100.0
"""Hz, at which signals are filtered"""
RATE = 25.0
"""Hz, of the products"""
SMOOTH = 8.0
"""Hz, of every signal before products are formed"""
CUTOFF = 4.0
"""Hz, of both sides; vision's noise in alpha'' grows with the square of the frequency"""
EVERY = 2
"""products that make a row"""
GAP = 0.2
"""s without frames that are not bridged"""
SETTLING = 0.4
"""s left out beside gaps and ends"""
CAD_ERROR = 0.01
"""relative, of masses and spring stiffness in neck.yaml"""
PAYLOAD = 3.0
"""times its own mass may the last top bar carry"""
TILT = 0.05
"""rad, of the base against gravity"""
_LATER = 2e-3
"""s, of the difference that gives the slope by the offset"""


@dataclass(frozen=True)
class ArmRows:
    """Rows K of the N joints: residual (K, N), N m; slopes by offset and delay (K, N), dimensions (K, N, P), fs and fv
    (K, N, M), nuisances (K, N, Q)."""

    residual: Array
    by_offset: Array
    by_delay: Array
    by_dimension: Array
    by_fs: Array
    by_fv: Array
    by_nuisance: Array
    prior: Array
    """(P,), sigma of each nuisance; infinite where nothing is known"""
    time: Array
    """(K,), s, log clock"""
    offset: float
    """of the clock that the rows were made with, s"""
    slow: Array
    """joint speeds at the rows, before any product, (T, N), and what makes rows of such"""
    kept: NDArray[np.bool_]

    def at(self, state: ClockUnknowns) -> Array:
        """Residuals (K, N), N m, of a state near that of the rows, with its joints known."""
        m = len(state.fv)
        out = self.residual + self.by_offset * (state.offset - self.offset) + self.by_delay * state.delay
        out = out + self.by_dimension @ state.dimensions
        return out + self.by_fv @ state.fv + self.by_fs @ state.joints[:m] + self.by_nuisance @ state.joints[m:]

    def with_width(self, joint_width: float) -> "ArmRows":
        """The same rows where a joint's dry friction turns over another width, rad/s."""
        n = self.residual.shape[1]
        nuisance = self.by_nuisance.copy()
        nuisance[..., -3 * n : -2 * n] = _rows_of(_dry(self.slow, joint_width), self.kept)
        return replace(self, by_nuisance=nuisance)


def arm_rows(
    arm: Arm, signals: LogSignals, frame_time: Array, alpha: Array, joint_width: float, offset: float, rubs: Array
) -> ArmRows:
    """The equation at fv = fs = 0, for frames at `frame_time` (F,), s, on the log's clock, with angles alpha (F, N), rad.

    rubs: (M,), N, what motors' dry friction roughly is, for the slopes by dimensions."""
    first, last = max(frame_time[0], signals.time[0]), min(frame_time[-1], signals.time[-1])
    fine = np.arange(first, last, 1 / FINE)
    time = fine[:: round(FINE / RATE)]
    bridged = cubic(frame_time, alpha)
    smooth = cubic(fine, low_pass(bridged(fine), FINE, SMOOTH))

    def moving(at: Array) -> tuple[Array, Array, Array]:
        return smooth(at), smooth(at, 1), smooth(at, 2)

    def pull(curve: BSpline) -> Array:
        return low_pass(curve(fine), FINE, SMOOTH)[:: round(FINE / RATE)]

    a, a_d, a_dd = moving(time)
    n, d, v = pull(signals.force), pull(signals.rubbing), pull(signals.speed)
    e, r = pull(signals.turning), pull(signals.command.derivative())
    parts = _parts(arm)
    by_part = np.stack([_torque(part, a, a_d, a_dd) for part in parts], axis=-1)
    jacobian = Z(arm, a)
    residual = by_part.sum(axis=-1) - np.einsum("tnm,tm->tn", jacobian, n)
    b, b_d, b_dd = moving(time - _LATER)
    later = _torque(arm, b, b_d, b_dd) - np.einsum("tnm,tm->tn", Z(arm, b), n)
    taut = n - rubs * d

    def unbalanced(one: Arm) -> Array:
        return _torque(one, a, a_d, a_dd) - np.einsum("tnm,tm->tn", Z(one, a), taut)

    now = unbalanced(arm)
    by_dimension = np.stack([unbalanced(other) - now for other in larger(arm)], axis=-1) / LARGER
    joints = np.eye(arm.N)
    across = np.stack([-arm.gravity[..., 1], arm.gravity[..., 0]], axis=-1)
    nothing = {"spring_stiffness": np.zeros_like(arm.spring_stiffness)}
    tilt = terms(replace(arm, gravity=across, **nothing), a, np.zeros_like(a)).g
    slow = low_pass(a_d, RATE, CUTOFF)
    nuisance = np.concatenate(
        [
            by_part,
            tilt[..., None],
            jacobian * pull(signals.inertial)[:, None, :],
            jacobian * e[:, None, :],
            _dry(slow, joint_width),
            a_d[..., None] * joints,
            np.ones_like(a_d)[..., None] * joints,
        ],
        axis=-1,
    )
    wrong = np.full(len(parts), CAD_ERROR)
    wrong[arm.N - 1] = PAYLOAD  # of the last top bar: what hangs there is not in neck.yaml
    known = np.concatenate([wrong, [TILT], np.full(arm.M, CAD_ERROR), np.full(arm.M + 3 * arm.N, np.inf)])
    keep = _away_from_gaps(time, frame_time)

    return ArmRows(
        _rows_of(residual, keep),
        _rows_of((later - residual) / _LATER, keep),
        _rows_of(np.einsum("tnm,tm->tn", jacobian, r), keep),
        _rows_of(by_dimension, keep),
        _rows_of(jacobian * d[:, None, :], keep),
        _rows_of(jacobian * v[:, None, :], keep),
        _rows_of(nuisance, keep),
        known,
        time[::EVERY][keep[::EVERY]],
        offset,
        slow,
        keep,
    )


def _rows_of(values: Array, keep: NDArray[np.bool_]) -> Array:
    """What the last filter leaves of products (T, ...), at the rows."""
    return low_pass(values, RATE, CUTOFF)[::EVERY][keep[::EVERY]]


def _dry(speed: Array, width: float) -> Array:
    """Dry friction of each joint for itself, (T, N, N)."""
    return (2 / np.pi * np.arctan(speed / width))[..., None] * np.eye(speed.shape[1])


def _parts(arm: Arm) -> list[Arm]:
    """The arm as a sum of arms that have one mechanism's top bar, diagonals or springs each."""
    nothing = {
        name: np.zeros_like(getattr(arm, name))
        for name in ("top_mass", "top_inertia", "diagonal_mass", "diagonal_inertia", "spring_stiffness")
    }
    groups = (("top_mass", "top_inertia"), ("diagonal_mass", "diagonal_inertia"), ("spring_stiffness",))
    return [
        replace(arm, **nothing | {name: np.where(np.arange(arm.N) == i, getattr(arm, name), 0.0) for name in names})
        for names in groups
        for i in range(arm.N)
    ]


def _torque(arm: Arm, a: Array, a_d: Array, a_dd: Array) -> Array:
    """M alpha'' + c + g, (T, N), N m."""
    found = terms(arm, a, a_d)
    return np.einsum("tij,tj->ti", found.M, a_dd) + found.c + found.g


def _away_from_gaps(time: Array, frame_time: Array) -> NDArray[np.bool_]:
    wide = np.flatnonzero(np.diff(frame_time) > GAP)
    keep = (time > time[0] + SETTLING) & (time < time[-1] - SETTLING)
    for k in wide:
        keep &= (time < frame_time[k] - SETTLING) | (time > frame_time[k + 1] + SETTLING)
    return keep
