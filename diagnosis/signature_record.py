"""A signature as the contract's record, and in words."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from diagnosis.drum_periodogram import DrumWave
from diagnosis.residual_episodes import RmsCourse
from diagnosis.signature import Pattern, Signature

Array = NDArray[np.float64]

_DIGITS = 4
"""of binned values: more than a picture shows"""
_MAX_EPISODES = 12
"""that a sentence lists"""


def channel_names(motors: int, joints: int) -> list[str]:
    """Names of the channels, in the residuals' order."""
    return [f"motor {j + 1}" for j in range(motors)] + [f"joint {i + 1}" for i in range(joints)]


def words(s: Signature, motors: int) -> str:
    """What a person should look for, in one sentence."""
    where = _channel_words(s.channels, motors)
    if s.kind == "nothing":
        return "nothing stands above noise"
    if s.kind == "unclear":
        return f"above noise in {where}, in no clear pattern by tension, speed, angle, turn of motor or drum, or time"
    if s.kind == "episodes":
        several = len(s.courses) > 1
        times = [f"{e.begin:.0f} s" + (f" of recording {e.recording + 1}" if several else "") for e in s.episodes]
        rest = f" and {len(times) - _MAX_EPISODES} more" if len(times) > _MAX_EPISODES else ""
        return f"in short episodes, in {where}: from {', '.join(times[:_MAX_EPISODES])} on{rest}"
    if s.kind == "drift":
        along = any("along" in p.against for p in s.shown)
        direction = "along the motion, as friction that changes" if along else "whatever the motion"
        return f"drifts in the course of a recording, {direction}: in {where}"
    if s.kind == "periodic":
        waves = [f"{w.order:.2f} +- {w.sigma:.2f} at drum {motor + 1}" for motor, w in sorted(_drum_waves(s).items())]
        return f"goes round with the drum, so many times a turn: {', '.join(waves)}; in {where}"
    return f"{'constant' if s.kind == 'constant' else f'follows the {s.kind}'}: in {where}"


def _drum_waves(s: Signature) -> dict[int, DrumWave]:
    """By motor, counted from 0, the clearest first."""
    return {p.channel: p.drum_wave for p in s.shown if p.drum_wave is not None}


def _channel_words(channels: Sequence[int], motors: int) -> str:
    """`the motor equations of motors 1, 2 and the arm equation of joint 3`."""
    parts = []
    for name, equation, numbers in (
        ("motor", "motor equation", [c + 1 for c in channels if c < motors]),
        ("joint", "arm equation", [c - motors + 1 for c in channels if c >= motors]),
    ):
        if numbers:
            plural = "s" * (len(numbers) > 1)
            parts.append(f"the {equation}{plural} of {name}{plural} {', '.join(map(str, numbers))}")
    return " and ".join(parts)


def as_json(s: Signature, motors: int) -> dict[str, Any]:
    """The contract's record; residuals in N (motors) and N m (joints), as bins."""
    names = channel_names(motors, len(s.courses[0].noise) - motors)
    return {
        "kind": s.kind,
        "words": words(s, motors),
        "where": [names[c] for c in s.channels],
        "orders": [
            {
                "motor": motor + 1,
                "per_drum_turn": wave.order,
                "sigma": wave.sigma,
                "per_motor_turn": wave.order / wave.gear,
            }
            for motor, wave in _drum_waves(s).items()
        ],
        "episodes": [{"recording": e.recording + 1, "from_s": e.begin, "to_s": e.end} for e in s.episodes],
        "picture": {"channel": names[s.best.channel], "against": s.best.against},
        "patterns": [_pattern_json(p, names[p.channel]) for p in s.patterns],
        "over_time": [_course_json(c, recording, names) for recording, c in enumerate(s.courses, start=1)],
    }


def _pattern_json(p: Pattern, channel: str) -> dict[str, Any]:
    return {
        "channel": channel,
        "against": p.against,
        "unit": p.unit,
        "explains": p.explains,
        "explains_beyond_base": p.explains_beyond_base,
        "log10_p": p.log_p / float(np.log(10)),
        "at": _rounded(p.bin_middles),
        "before": _rounded(p.before),
        "after": _rounded(p.after),
        "before_rms": _rounded(p.before_rms),
        "after_rms": _rounded(p.after_rms),
        "noise_rms": _rounded(p.noise),
    }


def _course_json(c: RmsCourse, recording: int, names: Sequence[str]) -> dict[str, Any]:
    return {
        "recording": recording,
        "window_s": c.window_s,
        "from_s": _rounded(c.window_starts),
        "channels": [
            {
                "channel": name,
                "before_rms": _rounded(c.before[k]),
                "after_rms": _rounded(c.after[k]),
                "noise_rms": float(c.noise[k]),
            }
            for k, name in enumerate(names)
        ],
    }


def _rounded(values: Array) -> list[float]:
    return [float(f"{v:.{_DIGITS}g}") for v in values.tolist()]
