"""Is vision consistent with the cable lengths that the pulley model predicts.

The elongation x (41) of a healthy cable follows the motor force (see elongation.py); what is left must be of the size of
vision's own uncertainty.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.series import Series
from mechanism.arm import Arm
from mechanism.cable_lengths import Z
from vision.elongation import explain

Array = NDArray[np.float64]

TOLERANCE_M = 2e-4
"""m: what the simple force model may leave unexplained (creep, damping, friction's transition) besides vision's noise"""


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
class Check:
    """All cables, and the verdict."""

    cables: tuple[CableCheck, ...]
    faults: tuple[dict[str, Any], ...]

    @property
    def verdict(self) -> str:
        """`consistent` or `inconsistent`."""
        return "inconsistent" if self.faults else "consistent"

    def as_json(self) -> dict[str, Any]:
        """The contract's record of a check."""
        return {
            "verdict": self.verdict,
            "faults": list(self.faults),
            "cables": [vars(cable) for cable in self.cables],
        }


def check_elongations(arm: Arm, series: Series, sigma_alpha: Array) -> Check:
    """Elongations of a series (alpha, theta_d, theta_dd, f, x) against the motor forces; sigma_alpha (T, N), rad."""
    explained = explain(arm, series)
    x, n = explained.x, explained.force
    noise = np.sqrt(np.mean(np.einsum("tij,ti->tj", Z(arm, series.matrix("alpha")) ** 2, sigma_alpha**2), axis=0))
    cables, faults = [], []
    for j, fit in enumerate(explained.fits):
        mean = float(np.mean(n[:, j]))
        slope = np.array([0.0, 1.0, 2 * mean, 0.0])
        # neighbouring samples are not independent: count one a quarter of a second
        wider = np.sqrt(max(1.0, 0.25 / float(np.mean(np.diff(series.time)))))
        found = CableCheck(
            cable=j + 1,
            elongation_mean=float(np.mean(x[:, j])),
            elongation_rms=float(np.std(x[:, j])),
            unexplained_rms=float(np.sqrt(np.mean(fit.residuals**2))),
            expected_rms=float(noise[j]),
            compliance=float(slope @ fit.value),
            compliance_sigma=float(np.sqrt(slope @ fit.covariance @ slope) * wider),
            offset=float(fit.value[0]),
        )
        cables.append(found)
        limit = float(np.hypot(TOLERANCE_M, 3 * noise[j]))
        if found.unexplained_rms > limit:
            faults.append(_fault("unexplained_elongation", j, found.unexplained_rms, limit / 3))
        if found.compliance < -2 * found.compliance_sigma:
            faults.append(_fault("theta_sign", j, found.compliance, found.compliance_sigma, "m/N"))
    return Check(tuple(cables), tuple(faults))


def _fault(name: str, cable: int, size: float, sigma: float, unit: str = "m") -> dict[str, Any]:
    return {
        "fault": name,
        "where": f"cable {cable + 1}",
        "size": size,
        "unit": unit,
        "sigma": sigma,
        "indistinguishable_from": [],
    }
