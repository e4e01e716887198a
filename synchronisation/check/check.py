"""Is vision consistent with the cable lengths that the pulley model predicts, and if not, what is to blame.

The elongation x (41) of a healthy cable follows the motor force; what is left must be of the size of vision's own uncertainty
and of the cables' own, and look like no known fault.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.frames import FrameAngles
from identification.dataset.series import Series
from mechanism.arm import Arm
from mechanism.cable_lengths import Z
from state_estimation.motors import Motors
from synchronisation.check.exchanges import find_exchange
from synchronisation.check.explained_elongation import explain
from synchronisation.check.fault_search import known_of, name_faults
from synchronisation.check.observation import observe
from synchronisation.check.scoring import Known
from synchronisation.check.wording import fault_of, fault_of_exchange, sentence, unexplained, usable
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

TOLERANCE_M = 2e-4
"""m: a cable's own error, beyond vision's noise, that is no fault; of healthy arms it is 5 to 50 um"""


@dataclass(frozen=True)
class CableCheck:
    """One cable: its elongation and how much of it the force explains."""

    cable: int
    elongation_mean: float
    elongation_rms: float
    """about the mean, m"""
    unexplained_rms: float
    """m"""
    expected_rms: float
    """m, vision's sigma through Z"""
    compliance: float
    """c1 at the mean force, m/N"""
    compliance_sigma: float
    offset: float
    """elongation at zero force against x = 0, m: pre-elongation in neck.yaml that is wrong, or an angle's constant error"""


@dataclass(frozen=True)
class Baseline:
    """What a healthy recording of the same arm has shown: its cables' law, and friction (M, 3), N."""

    known: Known
    friction: Array


@dataclass(frozen=True)
class Check:
    """All cables, and the verdict."""

    cables: tuple[CableCheck, ...]
    faults: tuple[dict[str, Any], ...]
    with_baseline: bool = False

    @property
    def verdict(self) -> str:
        """`consistent` or `inconsistent`."""
        return "inconsistent" if self.faults else "consistent"

    def as_json(self) -> dict[str, Any]:
        """The contract's record of a check."""
        return {
            "verdict": self.verdict,
            "usable": usable(self.faults),
            "with_baseline": self.with_baseline,
            "faults": list(self.faults),
            "cables": [vars(cable) for cable in self.cables],
        }


def check_elongations(
    arm: Arm, state: Series, seen: FrameAngles, clock_sigma: float = 0.0, baseline: Baseline | None = None
) -> Check:
    """Frames as `seen` on the log's clock against the motors of `state` (theta with derivatives, f), as a data set holds them.

    clock_sigma: of the offset between both, s.
    """
    observed = observe(arm, seen, motors_in(state), clock_sigma, baseline and baseline.friction)
    cables = _cables(arm, state)
    exchange = find_exchange(observed)
    if exchange is not None:
        return Check(cables, (fault_of_exchange(exchange),), baseline is not None)
    named, fit = name_faults(observed, baseline and baseline.known)
    faults = tuple(fault_of(n) for n in named)
    if not faults:
        noise = np.mean(np.diagonal(observed.vision, axis1=1, axis2=2), axis=0)
        own = np.sqrt(np.maximum(np.mean(fit.residual**2, axis=0) - noise, 0.0)).tolist()
        faults = tuple(unexplained(j, left, TOLERANCE_M / 3) for j, left in enumerate(own, 1) if left > TOLERANCE_M)
    return Check(cables, faults, baseline is not None)


def baseline_of(
    arm: Arm, state: Series, seen: FrameAngles, clock_sigma: float = 0.0, where: str = "baseline"
) -> Baseline:
    """From a healthy recording. Raises Refused where it is not: it would hide the fault that is looked for."""
    observed = observe(arm, seen, motors_in(state), clock_sigma)
    exchange = find_exchange(observed)
    named, fit = name_faults(observed)
    if exchange or named:
        raise not_healthy(where, fault_of_exchange(exchange) if exchange else fault_of(named[0]))
    return Baseline(known_of(observed, fit), observed.law.friction)


def not_healthy(where: str, fault: dict[str, Any]) -> Refused:
    """What to raise of a baseline with a fault."""
    return Refused(where, f"is not healthy itself: {sentence(fault)}", "give a recording that passes the check alone")


def motors_in(state: Series) -> Motors:
    """The motors' part of a data set's state."""
    theta, theta_d, theta_dd = (state.matrix("theta", suffix) for suffix in ("", "_d", "_dd"))
    return Motors(state.time, theta, theta_d, theta_dd, state.matrix("f"))


def _cables(arm: Arm, state: Series) -> tuple[CableCheck, ...]:
    explained = explain(arm, state)
    x, n = explained.x, explained.force
    sigma = state.matrix("sigma_alpha")
    noise = np.sqrt(np.mean(np.einsum("tij,ti->tj", Z(arm, state.matrix("alpha")) ** 2, sigma**2), axis=0))
    # neighbouring samples are not independent: count one a quarter of a second
    wider = np.sqrt(max(1.0, 0.25 / float(np.mean(np.diff(state.time)))))
    out = []
    for j, fit in enumerate(explained.fits):
        slope = np.array([1.0, 2 * float(np.mean(n[:, j]))])
        told = fit.covariance[1:3, 1:3]
        variance = float(slope @ told @ slope) if np.all(np.isfinite(told)) else np.inf
        out.append(
            CableCheck(
                cable=j + 1,
                elongation_mean=float(np.mean(x[:, j])),
                elongation_rms=float(np.std(x[:, j])),
                unexplained_rms=float(np.sqrt(np.mean(fit.residuals**2))),
                expected_rms=float(noise[j]),
                compliance=float(slope @ fit.value[1:3]),
                compliance_sigma=float(np.sqrt(variance) * wider),
                offset=float(fit.value[0]),
            )
        )
    return tuple(out)
