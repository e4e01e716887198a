"""Instrumental variables: elongations that follow from the motors, free of vision's noise.

Least squares divides by the variance of the elongation with vision's noise in it, so that stiffness comes out too small.
Columns built from the force, the motor's motion and the laws fitted so far are the same but for that noise: as instruments
they remove the bias (Brunot, Janot and others on robots: IDIM-IV). What the first stage, least squares, got wrong only
costs precision.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from identification.cable_memory import cables_remember, pull_memory
from identification.decimation import CUTOFF_HZ
from identification.filters import low_pass
from identification.residuals import LawForces, cable_motion, law_forces_at
from identification.signals import Signals
from identification.unknowns import Unknowns
from mechanism.laws import CableMotion
from mechanism.machine import Machine

Array = NDArray[np.float64]

_MAX_ITERATIONS = 12
_TOLERANCE_N = 1e-3
"""N, RMS of the tension's error: smaller ends the iteration (docs/thresholds.md)"""
_MAX_REDUCTION = 0.9
"""factor of the error in an iteration: a larger one ends it, as rates by differences are not those of the filter
(docs/thresholds.md)"""
_MAX_ELONGATION_M = 0.1
"""m, beyond any cable's elongation: a law that is far off must not diverge"""
_STEP_M, _STEP_M_S, _STEP_S = 1e-5, 1e-3, 1e-3
"""steps of the differences for the slopes of the cables' law"""


def instrument_signals(s: Signals, u: Unknowns, p: Array, recording: int, forces: LawForces | None = None) -> Signals:
    """The recording with the elongations under which the laws' tension equals the force that the motors exert.

    The iteration starts from a cable without memory, never from vision, so that vision's noise is absent wherever it ends.
    forces: what `law_forces_at` gives on the recording as it is, where that is known.
    """
    values, x0 = u.values(p, recording), u.get(p, "x0", recording)
    cables = _Cables(Machine(s.arm, u.laws, values), s)
    forces = forces or law_forces_at(s, u, p, recording)
    tension = forces.drive - s.inertial
    stiffness, _, damping = cables.slopes(s.x + x0, s.x_d)
    if np.any(stiffness <= 0):
        return s
    x = _clipped(_response(tension, stiffness, damping, s.step))
    # slopes along vision's elongations would hold its noise
    _, stiffness, damping = cables.slopes(x, np.gradient(x, s.step, axis=0))
    best, error_rms = s, np.inf
    for _ in range(_MAX_ITERATIONS):
        x_d = np.gradient(x, s.step, axis=0)
        error = tension - cables.pull(x, x_d)
        rms_before, error_rms = error_rms, float(np.sqrt(np.mean(error**2)))
        if error_rms < rms_before:
            best = replace(s, x=x - x0, x_d=x_d)
        if error_rms < _TOLERANCE_N or error_rms > _MAX_REDUCTION * rms_before:
            break
        x = _clipped(x + _response(error, stiffness, damping, s.step))
    return best


def remembering_by_motors(s: Signals, u: Unknowns, p: Array, recording: int) -> Signals:
    """The recording, with elongations that follow from the motors for its cables to remember, where they do.

    Along those by vision its noise would make a memory forget."""
    if not cables_remember(Machine(s.arm, u.laws, u.values(p, recording))):
        return s
    return replace(s, remembered=remembered_elongations(instrument_signals(s, u, p, recording)))


def remembered_elongations(motor_signals: Signals) -> tuple[Array, Array]:
    """Elongations that follow from the motors, (T, M), m, and their rates, as cables remember them.

    Counts of the encoders shake these by their accelerations, and what shakes forgets. A cable's memory does not ask how fast it
    came by its way, so that its elongations are taken without what is too fast for the residuals."""
    x = low_pass(motor_signals.x, 1 / motor_signals.step, CUTOFF_HZ)
    return x, np.gradient(x, motor_signals.step, axis=0)


@dataclass(frozen=True)
class _Cables:
    """The cables' laws along elongations x, x' (T, M), m and m/s, of a recording."""

    machine: Machine
    s: Signals

    def pull(self, x: Array, x_d: Array, z: Array | None = None) -> Array:
        """Tension as if cables could push, (T, M), N; z: memory variables, those of this motion unless given."""
        at = self._at(x, x_d)
        memory = pull_memory(self.machine, at, self.s.step) if z is None else z
        return np.broadcast_to(self.machine.pull(at, memory), x.shape)

    def slopes(self, x: Array, x_d: Array) -> tuple[Array, Array, Array]:
        """Slopes of the tension, (M,) each: by a lasting elongation, by a sudden one, and by the elongation's rate.

        A sudden elongation changes the memory variables too.
        """
        at, faster = self._at(x, x_d), x_d + _STEP_M_S
        z = pull_memory(self.machine, at, self.s.step)
        pull_0, moving = self.pull(x, x_d, z), np.full_like(x, _STEP_M_S)
        z_change = self.machine.memory_rate(self._at(x, moving), z) - self.machine.memory_rate(
            self._at(x, 0 * moving), z
        )
        lasting = np.max((self.pull(x + _STEP_M, x_d, z) - pull_0) / _STEP_M, axis=0)
        sudden = np.max((self.pull(x, x_d, z + _STEP_S * z_change) - pull_0) / (_STEP_S * _STEP_M_S), axis=0)
        damping = np.mean((self.pull(x, faster, z) - pull_0) / _STEP_M_S, axis=0)
        return lasting, lasting + sudden, np.maximum(damping, 0.0)

    def _at(self, x: Array, x_d: Array) -> CableMotion:
        return cable_motion(replace(self.s, x=x, x_d=x_d), np.zeros(1))


def _clipped(x: Array) -> Array:
    return np.clip(x, -_MAX_ELONGATION_M, _MAX_ELONGATION_M)


def _response(force: Array, stiffness: Array, damping: Array, step: float) -> Array:
    """Solution x of stiffness x + damping x' = force, (T, M), m."""
    out = np.empty_like(force)
    for j, (k, c) in enumerate(zip(stiffness, damping / step, strict=True)):
        out[:, j], _ = lfilter([1 / (k + c)], [1, -c / (k + c)], force[:, j], zi=[c / (k + c) * force[0, j] / k])
    return out
