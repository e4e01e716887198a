"""Instrumental variables: elongations that the motors tell, in which vision's noise had no part.

Least squares divides by the variance of the elongation with vision's noise in it, so that stiffness comes out too small.
Columns built from the force, the motor's turning and the laws found so far are the same but for that noise: as instruments
they take the bias away (Brunot, Janot and others on robots: IDIM-IV). Two stages; what the first got wrong only costs precision.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from identification.cable_memory import memory_states
from identification.residuals import law_forces, cable_motion
from identification.signals import Signals
from identification.unknowns import Unknowns
from mechanism.laws import Stretching
from mechanism.machine import Machine

Array = NDArray[np.float64]

_ROUNDS = 12
_CLOSE_N = 1e-3
"""RMS of the tension: there it ends"""
_SLOW = 0.9
"""or where a round leaves more than this part: rates by differences are not those of the filter"""
_FAR_M = 0.1
"""beyond any cable's elongation: a law that is far off must not run away"""
_SMALL_M, _SMALL_M_S, _SMALL_S = 1e-5, 1e-3, 1e-3
"""steps for the slopes of the cables' law"""


def instrument_signals(s: Signals, u: Unknowns, p: Array, recording: int) -> Signals:
    """The recording with the elongations under which the laws' tension is what the motors pull with.

    Sought from what a cable without memory would do, never from vision: where it ends early nothing of its noise is left."""
    values, x0 = u.values(p), u.get(p, "x0", recording)
    cables = _Cables(Machine(s.arm, u.laws, values), s)
    tension = law_forces(s, u.laws, values, x0, float(u.get(p, "delay", recording)[0])).drive - s.inertial
    stiffness, _, damping = cables.slopes(s.x + x0, s.x_d)
    if np.any(stiffness <= 0):
        return s
    x = _within(_answer(tension, stiffness, damping, s.step))
    # along vision's path they would hold its noise
    _, stiffness, damping = cables.slopes(x, np.gradient(x, s.step, axis=0))
    best, left = s, np.inf
    for _ in range(_ROUNDS):
        x_d = np.gradient(x, s.step, axis=0)
        wrong = tension - cables.pull(x, x_d)
        before, left = left, float(np.sqrt(np.mean(wrong**2)))
        if left < before:
            best = replace(s, x=x - x0, x_d=x_d)
        if left < _CLOSE_N or left > _SLOW * before:
            break
        x = _within(x + _answer(wrong, stiffness, damping, s.step))
    return best


@dataclass(frozen=True)
class _Cables:
    """The laws along elongations x, x' (T, M), m and m/s, of a recording."""

    machine: Machine
    s: Signals

    def pull(self, x: Array, x_d: Array, z: Array | None = None) -> Array:
        """(T, M), N, with what is remembered of this motion unless it is given."""
        at = self._at(x, x_d)
        memory = memory_states(self.machine, at, self.s.step) if z is None else z
        return np.broadcast_to(self.machine.pull(at, memory), x.shape)

    def slopes(self, x: Array, x_d: Array) -> tuple[Array, Array, Array]:
        """Of the pull, (M,) each: by lasting elongation, by sudden one, which is remembered too, and by its rate."""
        at, faster = self._at(x, x_d), x_d + _SMALL_M_S
        z = memory_states(self.machine, at, self.s.step)
        now, moving = self.pull(x, x_d, z), np.full_like(x, _SMALL_M_S)
        grown = self.machine.drift(self._at(x, moving), z) - self.machine.drift(self._at(x, 0 * moving), z)
        lasting = np.max((self.pull(x + _SMALL_M, x_d, z) - now) / _SMALL_M, axis=0)
        sudden = np.max((self.pull(x, x_d, z + _SMALL_S * grown) - now) / (_SMALL_S * _SMALL_M_S), axis=0)
        damping = np.mean((self.pull(x, faster, z) - now) / _SMALL_M_S, axis=0)
        return lasting, lasting + sudden, np.maximum(damping, 0.0)

    def _at(self, x: Array, x_d: Array) -> Stretching:
        return cable_motion(replace(self.s, x=x, x_d=x_d), np.zeros(1))


def _within(x: Array) -> Array:
    return np.clip(x, -_FAR_M, _FAR_M)


def _answer(force: Array, stiffness: Array, damping: Array, step: float) -> Array:
    """x of stiffness x + damping x' = force, (T, M)."""
    out = np.empty_like(force)
    for j, (k, c) in enumerate(zip(stiffness, damping / step, strict=True)):
        out[:, j], _ = lfilter([1 / (k + c)], [1, -c / (k + c)], force[:, j], zi=[c / (k + c) * force[0, j] / k])
    return out
