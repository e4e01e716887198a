"""Estimates that hold, as text."""

import numpy as np

from identification.estimates import Estimates
from identification.identifiability import durbin_wu_hausman


def as_text(found: Estimates) -> str:
    """A parameter a row, with its sigma, or why it is not identified and what would tell it."""
    lines = [f"Estimates that hold: {', '.join(name.replace('_', ' ') for name in found.laws)}"]
    for p, verdict in found.judged:
        label = p.name if p.index is None else f"{p.name}({p.index})"
        sigma = f"{p.sigma:.2g}" if np.isfinite(p.sigma) else "unknown"
        words = "" if verdict.identified else f"  not identified: {verdict.why}; {verdict.record}"
        lines.append(f"{label:7}{p.unit:9}{p.value:>12.5g} +- {sigma:8}{words}".rstrip())
    motor, arm = found.rms()
    lines.append(f"left of the motor equations {_listed(motor)} N, of the arm's {_listed(arm)} N m (rms)")
    _, chance = durbin_wu_hausman(found.solution)
    lines.append(
        f"Durbin-Wu-Hausman: p = {chance:.2g}, least squares "
        + ("would be biased by vision's noise" if chance < 0.05 else "would do as well")
    )
    return "\n".join(lines)


def _listed(values: np.ndarray) -> str:
    return ", ".join(f"{v:.2g}" for v in values)
