"""A periodogram against the drum's angle: what goes round with it, how many times a turn.

Waves of the angle are formed at the log's rate and filtered as the residual was: a fast drum's teeth are gone from both.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diagnosis.explained_energy import Autocovariance, Energy, autocovariance, energy, orthonormal
from diagnosis.linearisation import RecordingLinearisation

Array = NDArray[np.float64]

_FINE = 4
"""orders tried for each that the drum's way can tell apart"""
_PER_MOTOR_TURN = 1.5
"""up to so many a turn of the motor: once a turn is within"""
_ZOOMS = 3


@dataclass(frozen=True)
class Periodic:
    """`order` times a turn of the drum, with sigma, and the energy of its two waves; `tried` orders that can be told apart."""

    order: float
    sigma: float
    gear: float
    energy: Energy
    tried: int

    @property
    def log_p(self) -> float:
        """Of chance, with all orders that were tried."""
        return min(0.0, self.energy.log_p + float(np.log(self.tried)))


def periodic(
    residual: Sequence[Array],
    places: Sequence[RecordingLinearisation],
    motor: int,
    beneath: Array,
    known: Autocovariance,
) -> Periodic | None:
    """The order that takes most of a motor's residual (S,) of each recording, beyond what stands beneath it; None where the drum
    does not turn."""
    R = places[0].hypothesis.neck.motors[motor].R
    drums = [place.signals.theta[:, motor] / R for place in places]
    span = float(max(np.ptp(d) for d in drums))
    if span <= 0:
        return None
    apart = 2 * np.pi / span
    # one whole wave on the drum's way at least: slower ones are what any smooth law leaves
    orders = np.arange(apart, max(_PER_MOTOR_TURN * R, 2 * apart), apart / _FINE)

    def waves(order: float) -> list[Array]:
        out = []
        for place, drum in zip(places, drums, strict=True):
            wave = place.signals.low_pass(np.exp(1j * order * drum))
            out.append(np.column_stack([wave.real, wave.imag]))
        return out

    def taken(order: float) -> Energy:
        return energy(residual, waves(order), beneath, known)

    found = [taken(order) for order in orders]
    best = int(np.argmax([e.taken for e in found]))
    order, step = float(orders[best]), apart / _FINE
    for _ in range(_ZOOMS):
        near = order + step * np.linspace(-1, 1, 9)
        order, step = float(near[np.argmax([taken(o).taken for o in near])]), step / 4
    most = taken(order)
    # log likelihood is energy over twice the scale of what the waves leave; sigma from its curvature
    X = np.concatenate(waves(order))
    Q = orthonormal(X - beneath @ (beneath.T @ X))
    flat = np.concatenate(residual)
    left = np.split(flat - Q @ (Q.T @ flat), np.cumsum([len(r) for r in residual])[:-1])
    scale = energy(left, waves(order), beneath, autocovariance(left, known.at)).scale
    h = apart / 8
    bend = (2 * most.taken - taken(order + h).taken - taken(order - h).taken) / h**2
    sigma = float(np.sqrt(2 * scale / bend)) if bend > 0 else float("inf")
    return Periodic(order, sigma, R, most, max(1, round((orders[-1] - orders[0]) / apart)))
