"""Is vision consistent with the cable lengths that the pulley model predicts, and if not, what is to blame.

The elongation x (41) of a healthy cable follows the motor force. What the force does not explain must be of the size of vision's
uncertainty and of the cables' own errors, and resemble no known fault.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.frames import FrameAngles
from identification.dataset.series import Series
from mechanism.arm import Arm
from mechanism.cable_lengths import Z
from mechanism.tolerance import Tolerance
from state_estimation.motors import motors_in
from synchronisation.check.absolute_law import CableForces
from synchronisation.check.exchanges import find_exchange
from synchronisation.check.explained_elongation import explain
from synchronisation.check.fault_search import law_prior_of, name_faults
from synchronisation.check.observation import observe
from synchronisation.check.scoring import LawPrior
from synchronisation.check.wording import exchange_record, fault_record, sentence, unexplained_record, usable
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

MAX_UNEXPLAINED_M, MAX_UNEXPLAINED_SHARE = 2e-4, 0.1
"""m, and share of its elongation about the mean: a cable's error beyond vision's noise, RMS, above both of which its elongation
counts as unexplained (docs/thresholds.md)"""
INDEPENDENT_S = 0.25
"""s between samples of an elongation's residual that count as independent (docs/thresholds.md)"""


@dataclass(frozen=True)
class CableCheck:
    """One cable: its elongation and how much of it the force explains."""

    cable: int
    elongation_mean: float
    """m"""
    elongation_rms: float
    """about the mean, m"""
    unexplained_rms: float
    """m"""
    expected_rms: float
    """m, vision's sigma through Z"""
    compliance: float
    """c1 at the mean force, m/N"""
    compliance_sigma: float
    """m/N"""
    offset: float
    """elongation at zero force against x = 0, m: pre-elongation in neck.yaml that is wrong, or an angle's constant error"""


@dataclass(frozen=True)
class Baseline:
    """What a healthy recording of the same arm has shown."""

    law: LawPrior
    """its cables' law of elongation"""
    forces: CableForces
    """friction of its motors, and lags of its cables"""


@dataclass(frozen=True)
class Check:
    """All cables, and the faults that were named."""

    cables: tuple[CableCheck, ...]
    faults: tuple[dict[str, Any], ...]
    with_baseline: bool = False
    parts: int = 1
    """consecutive parts of the recording that were checked one by one"""
    in_few_parts: tuple[dict[str, Any], ...] = ()
    """faults that too few parts show to count (checked_parts.py)"""

    @property
    def verdict(self) -> str:
        """`consistent` or `inconsistent`."""
        return "inconsistent" if self.faults else "consistent"

    def as_json(self) -> dict[str, Any]:
        """The contract's record of a check."""
        by_parts = {"parts": self.parts, "in_few_parts": list(self.in_few_parts)} if self.parts > 1 else {}
        return by_parts | {
            "verdict": self.verdict,
            "usable": usable(self.faults),
            "with_baseline": self.with_baseline,
            "faults": list(self.faults),
            "cables": [vars(cable) for cable in self.cables],
        }

    def as_text(self) -> str:
        """Verdict, cables and faults for a person, a line each."""
        lines = [self.verdict + (f", in {self.parts} parts one by one" if self.parts > 1 else "")]
        lines += [
            f"  cable {c.cable}: elongation {1e3 * c.elongation_mean:.2f} mm in the mean, {1e3 * c.elongation_rms:.2f} mm rms "
            f"about it, unexplained {1e3 * c.unexplained_rms:.3f} mm (vision alone {1e3 * c.expected_rms:.3f}), "
            f"compliance {1e6 * c.compliance:.1f} +- {1e6 * c.compliance_sigma:.1f} um/N"
            for c in self.cables
        ]
        lines += [f"  {sentence(fault)}" for fault in self.faults]
        lines += [
            f"  in {fault['parts']} of {self.parts} parts alone, and no verdict: {sentence(fault)}"
            for fault in self.in_few_parts
        ]
        if self.faults:
            fit = {True: "usable", False: "not usable as they are", "in part": "usable in part"}[usable(self.faults)]
            lines.append(f"  the data are {fit}")
        return "\n".join(lines)


def check_elongations(
    arm: Arm,
    state: Series,
    frames: FrameAngles,
    clock_sigma: float = 0.0,
    baseline: Baseline | None = None,
    tolerance: Tolerance | None = None,
) -> Check:
    """Checks frames on the log's clock against the motors of a data set's `state` (theta with derivatives, f).

    clock_sigma: of the offset between both, s. tolerance: of the arm's drawing, a workshop's where it is not said.
    """
    observation = observe(arm, frames, motors_in(state), clock_sigma, baseline and baseline.forces, tolerance)
    cables = _cable_checks(arm, state)
    exchange = find_exchange(observation)
    if exchange is not None:
        return Check(cables, (exchange_record(exchange),), baseline is not None)
    named, fit = name_faults(observation, baseline and baseline.law)
    faults = tuple(fault_record(n) for n in named)
    if not faults:
        noise = np.mean(np.diagonal(observation.vision, axis1=1, axis2=2), axis=0)
        unexplained = np.sqrt(np.maximum(np.mean(fit.residuals**2, axis=0) - noise, 0.0)).tolist()
        faults = tuple(
            unexplained_record(cable.cable, rms, most / 3)
            for cable, rms in zip(cables, unexplained, strict=True)
            if rms > (most := max(MAX_UNEXPLAINED_M, MAX_UNEXPLAINED_SHARE * cable.elongation_rms))
        )
    return Check(cables, faults, baseline is not None)


def baseline_of(
    arm: Arm,
    state: Series,
    frames: FrameAngles,
    clock_sigma: float = 0.0,
    where: str = "baseline",
    tolerance: Tolerance | None = None,
) -> Baseline:
    """The baseline that a healthy recording gives. Raises Refused where it is not healthy: it would hide the fault sought."""
    observation = observe(arm, frames, motors_in(state), clock_sigma, tolerance=tolerance)
    exchange = find_exchange(observation)
    named, fit = name_faults(observation)
    if exchange or named:
        raise not_healthy(where, exchange_record(exchange) if exchange else fault_record(named[0]))
    return Baseline(law_prior_of(observation, fit), observation.law.forces)


def not_healthy(where: str, fault: dict[str, Any]) -> Refused:
    """The refusal of a baseline that has a fault."""
    return Refused(where, f"is not healthy itself: {sentence(fault)}", "give a recording that passes the check alone")


def _cable_checks(arm: Arm, state: Series) -> tuple[CableCheck, ...]:
    explained = explain(arm, state)
    x, n = explained.x, explained.force
    sigma = state.matrix("sigma_alpha")
    noise = np.sqrt(np.mean(np.einsum("tij,ti->tj", Z(arm, state.matrix("alpha")) ** 2, sigma**2), axis=0))
    # neighbouring samples are not independent: one in each INDEPENDENT_S counts
    correlation_factor = np.sqrt(max(1.0, INDEPENDENT_S / float(np.mean(np.diff(state.time)))))
    checks = []
    for j, fit in enumerate(explained.fits):
        slope = np.array([1.0, 2 * float(np.mean(n[:, j]))])
        covariance = fit.covariance[1:3, 1:3]
        variance = float(slope @ covariance @ slope) if np.all(np.isfinite(covariance)) else np.inf
        checks.append(
            CableCheck(
                cable=j + 1,
                elongation_mean=float(np.mean(x[:, j])),
                elongation_rms=float(np.std(x[:, j])),
                unexplained_rms=float(np.sqrt(np.mean(fit.residuals**2))),
                expected_rms=float(noise[j]),
                compliance=float(slope @ fit.value[1:3]),
                compliance_sigma=float(np.sqrt(variance) * correlation_factor),
                offset=float(fit.value[0]),
            )
        )
    return tuple(checks)
