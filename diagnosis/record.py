"""A diagnosis as the contract's record, and in words."""

from typing import Any

import numpy as np

from diagnosis import signature_record
from diagnosis.advice import advice
from diagnosis.cause_parameters import parameters_of
from diagnosis.cause_search import MATERIAL, NamedCause
from diagnosis.diagnose import Diagnosis

_ALIKE = 0.9
"""share of what an effect does that another one may feign"""


def as_json(d: Diagnosis) -> dict[str, Any]:
    """The contract's record.

    >>> import xneck
    >>> found = xneck.diagnose([xneck.read_dataset("monday.mcap")], [xneck.read_dataset("tuesday.mcap")])
    >>> (cause,) = xneck.as_record(found)["causes"]
    >>> (mass,) = cause["parameters"]
    >>> cause["where"], mass["name"], mass["unit"], round(mass["value"], 2)
    ('all', 'm', 'kg', 0.1)
    """
    parameters = parameters_of(d.search.last)
    causes = []
    for named, cause, own in zip(d.search.named, d.causes, parameters, strict=True):
        causes.append(
            {
                "effect": cause.effect.name,
                "where": cause.where.label,
                "words": cause.effect.words,
                "parameters": [p.as_json() for p in own],
                "probability": probability(named),
                "indistinguishable_from": [c.effect.name for c in named.tied if c.effect is not cause.effect],
                "explains": named.best.gain / named.loss_before,
            }
        )
    arm = d.extended.arm
    before, after = d.before, d.after
    gain = max(d.gains, key=lambda g: g.before / g.noise_floor, default=None)
    return {
        "verdict": d.verdict,
        "why": d.why,
        "causes": causes,
        "gain": gain and gain.as_json(),
        "gains": [g.as_json() for g in d.gains],
        "explained": d.explained,
        "not_simulated": d.not_simulated or None,
        "clocks": [
            {"recording": r + 1, "late_s": float(late) + d.extended.late}
            for r, late in enumerate(d.search.last.end.point.late)
        ],
        "channels": [
            {
                "channel": name,
                "unit": "N" if j < arm.M else "N m",
                "before": float(before.rms[j]),
                "after": float(after.rms[j]),
                "noise_floor": float(after.floor[j]),
            }
            for j, name in enumerate(signature_record.channels(arm.M, arm.N))
        ],
        "considered": [
            {"effect": c.effect.name, "where": c.where.label, "explains": c.gain / d.search.first.loss}
            for c in d.search.rankings[0]
        ],
        "signature": signature_record.as_json(d.signature, arm.M),
        "next": [step.as_json() for step in advice(d)],
        "could_not_show": list(d.sight.blind),
        "could_not_show_in": [{"effect": name, "where": where} for name, where in d.sight.unseen],
        "isolability": {
            "effects": list(d.sight.effects),
            "feigned": [[round(float(share), 3) for share in row] for row in d.sight.alike],
        },
        "look_alikes": [
            {"effect": a, "feigned_by": b, "share": float(d.sight.alike[i, j])}
            for i, a in enumerate(d.sight.effects)
            for j, b in enumerate(d.sight.effects)
            if i != j and d.sight.alike[i, j] > _ALIKE
        ],
    }


def probability(named: NamedCause) -> float:
    """Of a cause among all that were considered beside it, laws' unknown forms allowed for: half of MATERIAL is one step of e."""
    losses = np.array([rival.loss for rival in named.tied])
    weight = np.exp((losses[0] - losses) / (MATERIAL / 2 * losses[0]))
    return float(1 / weight.sum())


def as_text(d: Diagnosis) -> str:
    """The verdict, the causes, and the gain, for a person.

    >>> import xneck
    >>> found = xneck.diagnose([xneck.read_dataset("monday.mcap")], [xneck.read_dataset("tuesday.mcap")])
    >>> print(xneck.in_words(found))  # doctest: +ELLIPSIS
    cause
      tip_payload (all): the arm carries something at its tip
        m = 0.0... +- 0.00... kg
      motor equations, not fitted: ...
    """
    lines = [d.verdict + (f": {d.why}" if d.why else "")]
    if d.verdict == "unknown":
        lines.append(f"  {signature_record.words(d.signature, d.extended.arm.M)}")
    for named, cause, own in zip(d.search.named, d.causes, parameters_of(d.search.last), strict=True):
        lines.append(f"  {cause.effect.name} ({cause.where.label}): {cause.effect.words}")
        lines += [
            f"    {p.name}{'' if p.index is None else f'({p.index})'} = {p.value:.4g} +- {p.sigma:.2g} {p.unit}"
            for p in own
        ]
        others = [c.effect.name for c in named.tied if c.effect is not cause.effect]
        if others:
            lines.append(f"    explains the data as well: {', '.join(others)}")
    for g in d.gains:
        lines.append(
            f"  {g.measure}, not fitted: {g.before:.4g} -> {g.after:.4g} {g.unit} (noise {g.noise_floor:.4g}, "
            f"gain {g.before - g.after:.2g} +- {g.sigma:.1g})"
        )
    unseen = [*d.sight.blind, *(f"{name} ({where})" for name, where in d.sight.unseen)]
    if unseen:
        lines.append(f"  these recordings would not show: {', '.join(unseen)}")
    return "\n".join(lines)
