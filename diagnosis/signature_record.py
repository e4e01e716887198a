"""A signature as the contract's record, and in words."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from diagnosis.signature import Pattern, Signature

Array = NDArray[np.float64]

_DIGITS = 4
"""of binned values: more than a picture shows"""
_TIMES = 12
"""episodes that a sentence lists"""


def channels(motors: int, joints: int) -> list[str]:
    """Names, in the residuals' order."""
    return [f"motor {j + 1}" for j in range(motors)] + [f"joint {i + 1}" for i in range(joints)]


def words(s: Signature, motors: int) -> str:
    """What a person should look for, in one sentence."""
    where = _where(s.channels, motors)
    if s.kind == "nothing":
        return "nothing stands above noise"
    if s.kind == "unclear":
        return f"above noise in {where}, in no clear pattern by tension, speed, angle, turn of motor or drum, or time"
    if s.kind == "episodes":
        several = len(s.courses) > 1
        times = [f"{e.begin:.0f} s" + (f" of recording {e.recording + 1}" if several else "") for e in s.episodes]
        more = f" and {len(times) - _TIMES} more" if len(times) > _TIMES else ""
        return f"in short episodes, in {where}: from {', '.join(times[:_TIMES])} on{more}"
    if s.kind == "drift":
        along = any("along" in p.against for p in s.shown)
        what = "along the motion, as friction that changes" if along else "whatever the motion"
        return f"drifts in the course of a recording, {what}: in {where}"
    if s.kind == "periodic":
        found = sorted(s.shown, key=lambda p: p.channel)
        waves = [f"{_order(p)} at drum {p.channel + 1}" for p in found]
        return f"goes round with the drum, so many times a turn: {', '.join(waves)}; in {where}"
    return f"{'constant' if s.kind == 'constant' else f'follows the {s.kind}'}: in {where}"


def _order(p: Pattern) -> str:
    assert p.periodic is not None
    return f"{p.periodic.order:.2f} +- {p.periodic.sigma:.2f}"


def _where(found: Sequence[int], motors: int) -> str:
    """`the motor equations of 1 and 2 and the arm's equation of joint 3`."""
    parts = []
    for name, one in (
        ("motor", [c + 1 for c in found if c < motors]),
        ("joint", [c - motors + 1 for c in found if c >= motors]),
    ):
        if one:
            whose = "motor equation" if name == "motor" else "arm equation"
            parts.append(
                f"the {whose}{'s' * (len(one) > 1)} of {name}{'s' * (len(one) > 1)} {', '.join(map(str, one))}"
            )
    return " and ".join(parts)


def as_json(s: Signature, motors: int) -> dict[str, Any]:
    """The contract's record; residuals in N (motors) and N m (joints), as bins."""
    names = channels(motors, len(s.courses[0].noise) - motors)
    return {
        "kind": s.kind,
        "words": words(s, motors),
        "where": [names[c] for c in s.channels],
        "orders": [
            {
                "motor": p.channel + 1,
                "per_drum_turn": p.periodic.order,
                "sigma": p.periodic.sigma,
                "per_motor_turn": p.periodic.order / p.periodic.gear,
            }
            for p in s.shown
            if p.periodic is not None
        ],
        "episodes": [{"recording": e.recording + 1, "from_s": e.begin, "to_s": e.end} for e in s.episodes],
        "picture": {"channel": names[s.best.channel], "against": s.best.against},
        "patterns": [
            {
                "channel": names[p.channel],
                "against": p.against,
                "unit": p.unit,
                "explains": p.explains,
                "explains_beyond_base": p.own,
                "log10_p": p.log_p / float(np.log(10)),
                "at": _short(p.at),
                "before": _short(p.before),
                "after": _short(p.after),
                "before_rms": _short(p.before_rms),
                "after_rms": _short(p.after_rms),
                "noise_rms": _short(p.noise),
            }
            for p in s.patterns
        ],
        "over_time": [
            {
                "recording": r + 1,
                "window_s": c.length,
                "from_s": _short(c.begin),
                "channels": [
                    {
                        "channel": name,
                        "before_rms": _short(c.before[k]),
                        "after_rms": _short(c.after[k]),
                        "noise_rms": float(c.noise[k]),
                    }
                    for k, name in enumerate(names)
                ],
            }
            for r, c in enumerate(s.courses)
        ],
    }


def _short(values: Array) -> list[float]:
    return [float(f"{v:.{_DIGITS}g}") for v in values.tolist()]
