"""What a person should know of a recording before anything else: one sentence, and the numbers behind it."""

from dataclasses import dataclass

import numpy as np

from mechanism.elasticity import MODELS
from xneck.recording.pipeline import Result
from xneck.report.wording import listed, number
from xneck_foundation.least_squares import Parameter

_MEANING = {"fs": "dry friction fs", "fv": "viscous friction fv", "k": "stiffness k", "ca": "damping ca"}


@dataclass(frozen=True)
class Figure:
    """A number with what it counts, as the head of the page shows it."""

    label: str
    value: str
    note: str


def sentence(result: Result) -> str:
    """The check's verdict, how much was used, the clock, and what could be identified."""
    clock, check = result.data.clock, result.data.check
    if check["verdict"] == "consistent":
        head = "Vision and the pulley model's cable lengths are consistent"
    else:
        faults = listed(sorted({f"{_spoken(fault['fault'])} at {fault['where']}" for fault in check["faults"]}))
        head = f"Vision and the pulley model's cable lengths are inconsistent ({faults})"
    parts = [
        f"{head} over {clock['frames_used']} of {clock['frames']} frames",
        f"the camera's clock is set to the log's within ±{number(1e3 * clock['offset_sigma_s'], 2)} ms (1 σ)",
        identified_in_words(tuple(p for p in result.estimates.parameters if p.name in _MEANING and p.name != "cm")),
    ]
    return "; ".join(parts) + "."


def identified_in_words(parameters: tuple[Parameter, ...]) -> str:
    """`... is identified for every cable, ... for none`."""
    names = list(dict.fromkeys(p.name for p in parameters))
    groups: dict[str, list[str]] = {}
    for name in sorted(names, key=lambda n: list(_MEANING).index(n) if n in _MEANING else len(_MEANING)):
        own = [p for p in parameters if p.name == name]
        good = [str(p.index) for p in own if p.identified]
        if len(good) == len(own):
            where = "for every cable"
        elif good:
            where = f"for {'cable' if len(good) == 1 else 'cables'} {listed(good)} only"
        else:
            where = "for no cable"
        groups.setdefault(where, []).append(_MEANING.get(name, name))
    return ", ".join(
        f"{listed(what)} {'is' if len(what) == 1 else 'are'} identified {where}" for where, what in groups.items()
    )


def figures(result: Result) -> list[Figure]:
    """The head's numbers."""
    clock, found = result.data.clock, result.identification
    sigma = np.degrees(np.sqrt(np.mean(result.data.state.matrix("sigma_alpha") ** 2)))
    dropped = clock["frames_dropped"]
    out = [
        Figure("check", result.data.check["verdict"], "vision against cable lengths"),
        Figure("frames used", f"{clock['frames_used']} of {clock['frames']}", f"{dropped} more dropped by the camera"),
        Figure(
            "clock offset",
            f"{number(clock['offset_s'], 5)} s",
            f"± {number(1e3 * clock['offset_sigma_s'], 2)} ms; skew {number(clock['skew_ppm'], 3)} "
            f"± {number(clock['skew_sigma_ppm'], 2)} ppm",
        ),
        Figure("angles", f"± {number(sigma, 2)} deg", "1 σ of the smoothed state"),
        Figure(
            "tension error",
            f"{number(found.mean_error(1), 3)} N",
            "mean of elastic model 1; models "
            + listed([f"{m}: {number(found.mean_error(m), 3)} N" for m in MODELS if m != 1]),
        ),
    ]
    if result.simulated is not None:
        worst = max(value for name, value in result.simulated.rms.items() if name.startswith("alpha"))
        out.append(
            Figure(
                "simulated angle error",
                f"{number(float(np.degrees(worst)), 3)} deg",
                f"RMS of the worst joint, restarted every {result.simulated.window_s:g} s",
            )
        )
    return out


def _spoken(name: str) -> str:
    return name.replace("_", " ")
