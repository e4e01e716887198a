"""A periodogram against the drum's angle: what goes round with it, how many times a turn.

Waves of the angle are formed at the log's rate and filtered as the residual was: a fast drum's teeth are gone from both.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diagnosis.explained_energy import (
    Autocovariance,
    Energy,
    autocovariance,
    energy_taken,
    explained_energy,
    orthonormal,
)
from diagnosis.linearisation import RecordingLinearisation

Array = NDArray[np.float64]

_OVERSAMPLING = 4
"""orders tried for each that the drum's way can tell apart"""
_MAX_PER_MOTOR_TURN = 1.5
"""orders are tried up to so many a turn of the motor: once a turn is within (docs/thresholds.md)"""
_ZOOMS = 3


@dataclass(frozen=True)
class DrumWave:
    """The wave of the drum's angle that takes most of a motor's residual."""

    order: float
    """times a turn of the drum"""
    sigma: float
    """of the order"""
    gear: float
    energy: Energy
    """of its sine and cosine"""
    orders_tried: int
    """that can be told apart"""

    @property
    def log_p(self) -> float:
        """Of chance, with all orders that were tried."""
        return min(0.0, self.energy.log_p + float(np.log(self.orders_tried)))


def drum_wave(
    residual: Sequence[Array],
    recordings: Sequence[RecordingLinearisation],
    motor: int,
    basis: Array,
    covariance: Autocovariance,
) -> DrumWave | None:
    """The order that takes most of a motor's residual (S,) of each recording, beyond a basis; None where the drum does not turn."""
    R = recordings[0].hypothesis.neck.motors[motor].R
    drums = [recording.signals.theta[:, motor] / R for recording in recordings]
    span = float(max(np.ptp(d) for d in drums))
    if span <= 0:
        return None
    resolution = 2 * np.pi / span
    # one whole wave on the drum's way at least: slower ones are what any smooth law leaves
    orders = np.arange(resolution, max(_MAX_PER_MOTOR_TURN * R, 2 * resolution), resolution / _OVERSAMPLING)

    def waves(order: float) -> list[Array]:
        out = []
        for recording, drum in zip(recordings, drums, strict=True):
            wave = recording.signals.low_pass(np.exp(1j * order * drum))
            out.append(np.column_stack([wave.real, wave.imag]))
        return out

    flat = np.concatenate(residual)

    def taken(order: float) -> float:
        return energy_taken(flat, np.concatenate(waves(order)), basis)

    coarse = [taken(order) for order in orders]
    order, step = float(orders[int(np.argmax(coarse))]), resolution / _OVERSAMPLING
    for _ in range(_ZOOMS):
        near = order + step * np.linspace(-1, 1, 9)
        order, step = float(near[np.argmax([taken(o) for o in near])]), step / 4
    most = explained_energy(residual, waves(order), basis, covariance)
    # log likelihood is energy over twice the scale of what the waves leave; sigma from its curvature
    X = np.concatenate(waves(order))
    Q = orthonormal(X - basis @ (basis.T @ X))
    remainder = np.split(flat - Q @ (Q.T @ flat), np.cumsum([len(r) for r in residual])[:-1])
    remainder_covariance = autocovariance(remainder, covariance.grid_rows)
    scale = explained_energy(remainder, waves(order), basis, remainder_covariance).scale
    h = resolution / 8
    curvature = (2 * most.taken - taken(order + h) - taken(order - h)) / h**2
    return DrumWave(
        order=order,
        sigma=float(np.sqrt(2 * scale / curvature)) if curvature > 0 else float("inf"),
        gear=R,
        energy=most,
        orders_tried=max(1, round((orders[-1] - orders[0]) / resolution)),
    )
