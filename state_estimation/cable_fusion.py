"""Vision and cables together: which cables are used, with which error, and whether they agree with vision."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.frames import FrameAngles
from identification.dataset.series import interpolated
from mechanism.arm import Arm
from mechanism.cable_lengths import Z
from mechanism.elasticity import elongation
from state_estimation.cable_equations import CABLE_HZ, CableEquations, cable_measurements, cable_rows
from state_estimation.elongation_error_spectrum import ErrorSpectrum, fit_error_spectrum, white_spectrum
from state_estimation.elongation_law import ElongationLaw, fitted, law_of, left_by
from state_estimation.elongation_regressors import TENSION
from state_estimation.fast_motion import fast_motion_variance
from state_estimation.fusion import SplineSolution, solve_splines, vision_equations, vision_misfit
from state_estimation.motors import Motors
from state_estimation.variance_components import estimate_variance_components

Array = NDArray[np.float64]

MAX_ERROR_RATIO = 3.0
"""a cable is left out if its elongation error is more than this many times what vision's noise leaves uncertain of its length
(docs/thresholds.md)"""
MAX_EXCESS_MISFIT = 0.1
"""relative increase of vision's mean square residual above which the cables are taken to disagree with vision
(docs/thresholds.md)"""
ERROR_FACTOR, MAX_TRIES = 1.6, 3
"""factor on the errors of cables that disagree with vision, and how often it is applied before no cable is used
(docs/thresholds.md)"""
MAX_MISFIT_RATIO = 1.01
"""of the mean square that speeds by the motors' equations leave of elongations over what speeds at the rows leave
(docs/thresholds.md)"""
MIN_COMPLIANCE_SHARE = 0.1
"""of the cables' median compliance: what each has at the least where motors shake the arm through them (docs/thresholds.md)"""
MAX_LINEARISATION_ERROR_M = 1e-9
"""m, RMS of a cable: equations whose linearisation errs by more are linearised anew; errors of cables are hundreds of times that"""
_UNUSED_ERROR_M = 1.0
"""m: error that takes all weight from a cable that is left out"""


def fuse_cables(
    arm: Arm, frames: FrameAngles, motors: Motors, vision: SplineSolution
) -> tuple[SplineSolution | None, dict[str, Any]]:
    """The splines by vision and cables, or None where cables cannot be used, and notes that say why.

    vision: the splines by vision alone.
    """
    law, spectra, notes, poor = _error_spectra(arm, frames, motors)
    if poor.all():
        return None, notes
    inside = np.flatnonzero((motors.time >= frames.time[0]) & (motors.time <= frames.time[-1]))
    rows = inside[:: _stride(motors)]
    time = motors.time[rows]
    cables = cable_measurements(law, time, motors.theta[rows])
    components = estimate_variance_components(vision, frames, cables, spectra, ~poor)
    spectra, priors, cables = components.spectra, components.priors, cables.with_law(components.law)

    def equations(near: Array) -> Iterator[CableEquations]:
        return cable_rows(cables, vision.knots, near, vision.mean, spectra)

    of_frames, near = vision_equations(vision.knots, vision.mean, frames), components.alpha
    fused = solve_splines(of_frames, priors, equations(near))
    if cables.linearisation_error(near, fused.alpha(time)) > MAX_LINEARISATION_ERROR_M:
        fused = solve_splines(of_frames, priors, equations(fused.alpha(time)))
    misfit_alone = vision_misfit(vision, frames)
    excess = vision_misfit(fused, frames) / misfit_alone - 1
    for _ in range(MAX_TRIES):
        if excess < MAX_EXCESS_MISFIT:
            break
        # the law has an error that the residuals did not show: the cables count for less
        spectra = [s if unused else s.scaled(ERROR_FACTOR) for s, unused in zip(spectra, poor, strict=True)]
        fused = solve_splines(of_frames, priors, equations(fused.alpha(time)))
        excess = vision_misfit(fused, frames) / misfit_alone - 1
    notes["cable_error_m"] = [
        None if unused else float(np.sqrt(s.variance)) for s, unused in zip(spectra, poor, strict=True)
    ]
    if excess > MAX_EXCESS_MISFIT:
        notes["why"] = f"cables pull the angles from what vision saw (its variance grows by {100 * excess:.0f} %)"
        return None, notes
    compliance = cables.factors(fused.beta)[:, TENSION]
    usual = float(np.median(compliance[~poor]))
    if usual > 0:
        # of a cable that is left out nothing is known, and of one that hardly stretches not how little
        compliance = np.where(poor, usual, np.maximum(compliance, MIN_COMPLIANCE_SHARE * usual))
        fast = fast_motion_variance(cables.law, compliance, fused.alpha(time), fused.knots.step)
        fused = fused if fast is None else replace(fused, unresolved=fast)
    return fused, notes


def _error_spectra(
    arm: Arm, frames: FrameAngles, motors: Motors
) -> tuple[ElongationLaw, list[ErrorSpectrum], dict[str, Any], NDArray[np.bool_]]:
    """The law of the elongations by vision, the spectra of its errors, and the cables left out, as notes and as a mask (M,)."""
    complete = np.isfinite(frames.alpha).all(axis=1)
    complete &= (frames.time >= motors.time[0]) & (frames.time <= motors.time[-1])
    time, alpha, sigma = frames.time[complete], frames.alpha[complete], frames.sigma[complete]
    variance = np.einsum("tij,ti->tj", Z(arm, alpha) ** 2, sigma**2)
    x = elongation(arm, alpha, interpolated(time, motors.time, motors.theta))
    law, X = _elongation_law(arm, motors, time, x)
    step = _stride(motors) * float(np.mean(np.diff(motors.time)))
    spectra = [fit_error_spectrum(time, x[:, j], variance[:, j], X[:, j], step) for j in range(arm.M)]
    errors = np.sqrt([s.variance for s in spectra])
    poor = errors > MAX_ERROR_RATIO * np.sqrt(np.median(variance, axis=0))
    left_out = [
        {"cable": int(j) + 1, "why": f"the force leaves {1e6 * errors[j]:.0f} um of its elongation unexplained"}
        for j in np.flatnonzero(poor)
    ]
    used = [white_spectrum(_UNUSED_ERROR_M, step) if bad else s for s, bad in zip(spectra, poor, strict=True)]
    return law, used, {"cables_left_out": left_out}, poor


def _elongation_law(arm: Arm, motors: Motors, time: Array, x: Array) -> tuple[ElongationLaw, Array]:
    """The law of elongations x (F, M) at times (F,), its friction taken at the speeds that follow from it by the motors' equations;
    and its regressors at these times.

    Speeds at the rows stay where those explain the elongations less well: their equation is none of such motors.
    """
    at_rows = law_of(arm, motors, time, x)
    within_rows = fitted(at_rows.with_own_friction, time, x)
    X, X_within = at_rows.at(time), within_rows.at(time)
    return (within_rows, X_within) if _misfit(X_within, x) < MAX_MISFIT_RATIO * _misfit(X, x) else (at_rows, X)


def _misfit(X: Array, x: Array) -> float:
    """Mean square, over frames and cables, of what regressors X (F, M, P) leave of x (F, M), m^2."""
    return float(np.mean(left_by(X, x) ** 2))


def _stride(motors: Motors) -> int:
    """Rows of the log from one of the cables' equations to the next."""
    return max(1, int(1 / (CABLE_HZ * float(np.mean(np.diff(motors.time))))))
