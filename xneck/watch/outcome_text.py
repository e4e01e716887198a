"""What a watched recording will give, in words."""

from collections.abc import Mapping
from typing import Any


def outcome_text(outcome: Mapping[str, Any]) -> str:
    """The outcome, as `Outcome.as_json` has it, in lines."""
    lines = []
    part, clock = f"by its newest {outcome['seconds']:.0f} s", outcome["clock"]
    if clock is None:
        return f"no clock {part}: {outcome['refused']}"
    sigma_ms = 1e3 * clock["offset_sigma_s"]
    lines.append(f"clock {part}: offset {clock['offset_s']:.4f} s +- {sigma_ms:.2f} ms; {outcome['check']}")
    lines += [f"  {warning}" for warning in clock["warnings"]]
    if outcome["refused"]:
        return "\n".join([*lines, f"nothing will be identified: {outcome['refused']}"])
    good = [_label(p) for p in outcome["parameters"] if p["identified"]]
    lines.append(f"will identify {', '.join(good)}" if good else "will identify nothing")
    reasons: dict[str, list[str]] = {}
    for parameter in outcome["parameters"]:
        if not parameter["identified"]:
            reasons.setdefault(parameter["why"], []).append(_label(parameter))
    return "\n".join([*lines, *(f"  not {', '.join(labels)}: {why}" for why, labels in reasons.items())])


def _label(parameter: Mapping[str, Any]) -> str:
    return parameter["name"] if parameter["index"] is None else f"{parameter['name']}({parameter['index']})"
