"""Identified parameters as text."""

import numpy as np

from identification.estimates import BENDING_FRICTION, MIN_UNBIASED_PROBABILITY, Estimates
from identification.identifiability import durbin_wu_hausman
from identification.recorded_check import inconsistency
from xneck_foundation.one_line import indexed
from xneck_foundation.unit_text import printed_unit

BENDS = "friction bends before it slides: without that law forces and motion do not fit, so that it is identified too"
LED_ASTRAY = "instruments lead astray here: numbers are by least squares, which vision's noise may bias"


def as_text(estimates: Estimates) -> str:
    """A parameter a row, with its sigma, or why it is not identified and what motion would identify it."""
    lines = [
        f"check: {found}; these numbers rest on it"
        for found in dict.fromkeys(inconsistency(check) for check in estimates.checks)
        if found
    ]
    lines += [f"Estimates that hold: {', '.join(name.replace('_', ' ') for name in estimates.laws)}"]
    if BENDING_FRICTION in estimates.laws:
        lines.append(BENDS)
    labels = [indexed(p.name, p.index) for p, _ in estimates.with_identifiability]
    width = max(7, *(len(label) + 2 for label in labels))
    for label, (p, verdict) in zip(labels, estimates.with_identifiability, strict=True):
        sigma = f"{p.sigma:.2g}" if np.isfinite(p.sigma) else "unknown"
        words = (
            "" if verdict.identified else f"  not identified: {'; '.join(filter(None, [verdict.why, verdict.record]))}"
        )
        lines.append(f"{label:{width}}{printed_unit(p.unit):9}{p.value:>12.5g} +- {sigma:8}{words}".rstrip())
    motor, arm = estimates.rms()
    lines.append(f"left of the motor equations {_listed(motor)} N, of the arm's {_listed(arm)} N m (rms)")
    lines.append(_of_instruments(estimates))
    return "\n".join(lines)


def _of_instruments(estimates: Estimates) -> str:
    """What least squares alone would have done, or that it had to."""
    if estimates.solution.is_least_squares:
        return LED_ASTRAY
    _, probability = durbin_wu_hausman(estimates.solution)
    biased = "would be biased by vision's noise" if probability < MIN_UNBIASED_PROBABILITY else "would do as well"
    return f"Durbin-Wu-Hausman: p = {probability:.2g}, least squares {biased}"


def _listed(values: np.ndarray) -> str:
    return ", ".join(f"{v:.2g}" for v in values)
