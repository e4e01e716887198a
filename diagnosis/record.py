"""A diagnosis as the contract's record, and in words."""

from typing import Any

import numpy as np

from diagnosis import signature_record
from diagnosis.advice import advice
from diagnosis.cause import Cause
from diagnosis.detectability import Detectability
from diagnosis.diagnose import Diagnosis
from diagnosis.look_alikes import NamedCause
from diagnosis.worth_naming import tie_tolerance
from xneck_foundation.one_line import indexed
from xneck_foundation.parameter import Parameter
from xneck_foundation.unit_text import with_unit

_MAX_ALIKE_WORDS = 3
_MAX_DRAWING_WORDS = 4
"""numbers of the drawing that are said in words, those that are off by more than their tolerance"""
_LOOK_ALIKE_SHARE = 0.9
"""of what an effect does: another one that may feign as much is listed (docs/thresholds.md)"""


def as_json(d: Diagnosis) -> dict[str, Any]:
    """The contract's record.

    >>> import xneck
    >>> found = xneck.diagnose([xneck.read_dataset("monday.mcap")], [xneck.read_dataset("tuesday.mcap")])
    >>> (cause,) = xneck.as_record(found)["causes"]
    >>> (mass,) = cause["parameters"]
    >>> cause["where"], mass["name"], mass["unit"], round(mass["value"], 2)
    ('all', 'm', 'kg', 0.1)
    """
    arm, search = d.extended.arm, d.search
    gain = max(d.gains, key=lambda g: g.before / g.noise_floor, default=None)
    visible, names = d.detectability, signature_record.channel_names(arm.M, arm.N)
    return {
        "verdict": d.verdict,
        "why": d.why,
        "causes": [
            _cause_json(named, cause, parameters)
            | {"share": share.as_json(), "picture": {"channel": names[p.channel], "against": p.shown_by.name}}
            for named, cause, parameters, share, p in zip(
                search.named,
                d.causes,
                d.numbers,
                d.shares,
                d.pictures[: len(d.causes)],
                strict=True,
            )
        ],
        "gain": gain and gain.as_json(),
        "gains": [g.as_json() for g in d.gains],
        "arm_error": d.arm_error and d.arm_error.as_json(),
        "remainder": [r.as_json() for r in d.remainder],
        "something_remains": d.something_remains,
        "set_aside": [
            {"recording": e.recording + 1, "held_out": held_out, "from_s": e.begin, "to_s": e.end}
            for stretches, held_out in zip(d.set_aside, (False, True), strict=True)
            for e in stretches
        ],
        "unlisted": search.unlisted and search.unlisted.as_json(),
        "found_laws": [found.as_json() for found in d.found_laws],
        "drawing": [f.as_json() for f in d.drawing],
        "explained": d.explained,
        "not_simulated": d.not_simulated or None,
        "clocks": [
            {"recording": r, "late_s": float(lag) + d.extended.frame_lag}
            for r, lag in enumerate(d.extended_stage.comparison.linearisation.frame_lags, start=1)
        ],
        "channels": [
            {
                "channel": name,
                "unit": "N" if j < arm.M else "N m",
                "before": float(d.before.rms[j]),
                "after": float(d.after.rms[j]),
                "noise_floor": float(d.after.floor[j]),
            }
            for j, name in enumerate(names)
        ],
        "considered": [
            {"effect": c.effect.name, "where": c.where.label, "explains": search.share_taken(c)} for c in search.ranking
        ],
        "signature": signature_record.as_json(d.signature, arm.M),
        "next": [step.as_json() for step in advice(d)],
        "could_not_show": list(visible.invisible),
        "could_not_show_in": [{"effect": name, "where": where} for name, where in visible.invisible_places],
        "isolability": {
            "effects": list(visible.effects),
            "feigned": [[round(float(share), 3) for share in row] for row in visible.imitated],
        },
        "look_alikes": look_alikes(visible),
    }


def _number_words(p: Parameter) -> str:
    """Its value and sigma; that it is not told, where it ended at the end of its range."""
    number = f"{indexed(p.name, p.index)} = {p.value:.4g}"
    if not np.isfinite(p.sigma):
        return f"{with_unit(number, p.unit)}, not told"
    return with_unit(f"{number} +- {p.sigma:.2g}", p.unit)


def _cause_json(named: NamedCause, cause: Cause, parameters: tuple[Parameter, ...]) -> dict[str, Any]:
    return {
        "effect": cause.effect.name,
        "where": cause.where.label,
        "words": cause.effect.words,
        "parameters": [p.as_json() for p in parameters],
        "probability": probability(named),
        "indistinguishable_from": [c.effect.name for c in named.tied if c.effect is not cause.effect],
        "explains": named.gain / named.loss_before,
    }


def look_alikes(d: Detectability) -> list[dict[str, Any]]:
    """Pairs of effects of which one could feign the other in these recordings, or all but a small part of it."""
    return [
        {"effect": a, "feigned_by": b, "share": float(d.imitated[i, j])}
        for i, a in enumerate(d.effects)
        for j, b in enumerate(d.effects)
        if i != j and d.imitated[i, j] > _LOOK_ALIKE_SHARE
    ]


def probability(named: NamedCause) -> float:
    """Of a cause among all that were considered beside it.

    Half of what causes may differ by that explain alike is one step of e: laws have forms that nobody knows better.
    """
    left = np.array([rival.surplus for rival in named.tied])
    weight = np.exp((left[0] - left) / (tie_tolerance(named.loss, named.gain) / 2))
    return float(1 / weight.sum())


def as_text(d: Diagnosis) -> str:
    """The verdict, the causes, and the gain, for a person.

    >>> import xneck
    >>> found = xneck.diagnose([xneck.read_dataset("monday.mcap")], [xneck.read_dataset("tuesday.mcap")])
    >>> print(xneck.in_words(found))  # doctest: +ELLIPSIS
    cause
      tip_payload (all): the arm carries something at its tip
        m = 0.0... +- 0.00... kg
        xm = ... m
        ym = ... m
      motor equations, not fitted: ...
    """
    lines = [d.verdict + (f": {d.why}" if d.why else "")]
    if d.verdict == "unknown" and not d.found_laws:
        lines.append(f"  {signature_record.words(d.signature, d.extended.arm.M)}")
    for named, cause, parameters in zip(d.search.named, d.causes, d.numbers, strict=True):
        lines.append(f"  {cause.effect.name} ({cause.where.label}): {cause.effect.words}")
        lines += [f"    {_number_words(p)}" for p in parameters]
        others = [c.effect.name for c in named.tied if c.effect is not cause.effect]
        if others:
            lines.append(f"    explains the data as well: {', '.join(others)}")
    for found in d.found_laws:
        lines += [f"  {found.law.words}: {found.law.equation}", f"    {found.numbers_in_words}"]
        if g := found.gain:
            lines.append(
                f"    {g.measure}, not fitted: {g.before:.4g} -> {g.after:.4g} {g.unit} (noise {g.noise_floor:.4g})"
            )
        others = [law.words for law in found.law.alike[:_MAX_ALIKE_WORDS]]
        if others:
            lines.append(f"    explains the data as well: {'; '.join(others)}")
    for g in d.gains:
        lines.append(
            f"  {g.measure}, not fitted: {g.before:.4g} -> {g.after:.4g} {g.unit} (noise {g.noise_floor:.4g}, "
            f"gain {g.before - g.after:.2g} +- {g.sigma:.1g})"
        )
    beyond = [f for f in d.drawing if abs(f.value) > f.tolerance][:_MAX_DRAWING_WORDS]
    if beyond:
        lines.append(f"  against the drawing: {'; '.join(f.words for f in beyond)}")
    visible = d.detectability
    invisible = [*visible.invisible, *(f"{name} ({where})" for name, where in visible.invisible_places)]
    if invisible:
        lines.append(f"  these recordings would not show: {', '.join(invisible)}")
    return "\n".join(lines)
