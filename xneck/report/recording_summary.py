"""The head of a recording's page: one sentence, and the numbers behind it."""

import numpy as np

from mechanism.elasticity import ELASTIC_MODELS
from xneck.recording.recording_result import RecordingResult
from xneck.report.key_number import KeyNumber
from xneck.report.number_text import number_text
from xneck.report.words import join_words, with_spaces
from xneck_foundation.parameter import Parameter

_MEANING = {"fs": "dry friction fs", "fv": "viscous friction fv", "k": "stiffness k", "ca": "damping ca"}


def summary_sentence(result: RecordingResult) -> str:
    """The check's verdict, the frames used, the clock's sigma, and the parameters that are identified, in one sentence."""
    clock, check = result.data.clock, result.data.check
    if check["verdict"] == "consistent":
        head = "Vision and the pulley model's cable lengths are consistent"
    else:
        faults = join_words(sorted({f"{with_spaces(fault['fault'])} at {fault['where']}" for fault in check["faults"]}))
        head = f"Vision and the pulley model's cable lengths are inconsistent ({faults})"
    parts = [
        f"{head} over {clock['frames_used']} of {clock['frames']} frames",
        f"the camera's clock is set to the log's within ±{number_text(1e3 * clock['offset_sigma_s'], 2)} ms (1 σ)",
        identified_in_words(tuple(p for p in result.estimates.parameters if p.name in _MEANING and p.name != "cm")),
    ]
    return "; ".join(parts) + "."


def identified_in_words(parameters: tuple[Parameter, ...]) -> str:
    """Such as `dry friction fs is identified for every cable, stiffness k for cables 1 and 2 only`."""
    names = list(dict.fromkeys(p.name for p in parameters))
    groups: dict[str, list[str]] = {}
    for name in sorted(names, key=lambda n: list(_MEANING).index(n) if n in _MEANING else len(_MEANING)):
        of_name = [p for p in parameters if p.name == name]
        identified = [str(p.index) for p in of_name if p.identified]
        if len(identified) == len(of_name):
            where = "for every cable"
        elif identified:
            where = f"for {'cable' if len(identified) == 1 else 'cables'} {join_words(identified)} only"
        else:
            where = "for no cable"
        groups.setdefault(where, []).append(_MEANING.get(name, name))
    return ", ".join(
        f"{join_words(what)} {'is' if len(what) == 1 else 'are'} identified {where}" for where, what in groups.items()
    )


def key_numbers(result: RecordingResult) -> list[KeyNumber]:
    """The numbers below the sentence."""
    clock, fasquelle = result.data.clock, result.fasquelle
    sigma = np.degrees(np.sqrt(np.mean(result.data.state.matrix("sigma_alpha") ** 2)))
    dropped = clock["frames_dropped"]
    numbers = [
        KeyNumber("check", result.data.check["verdict"], "vision against cable lengths"),
        KeyNumber(
            "frames used", f"{clock['frames_used']} of {clock['frames']}", f"{dropped} more dropped by the camera"
        ),
        KeyNumber(
            "clock offset",
            f"{number_text(clock['offset_s'], 5)} s",
            f"± {number_text(1e3 * clock['offset_sigma_s'], 2)} ms; skew {number_text(clock['skew_ppm'], 3)} "
            f"± {number_text(clock['skew_sigma_ppm'], 2)} ppm",
        ),
        KeyNumber("angles", f"± {number_text(sigma, 2)} deg", "1 σ of the smoothed state"),
        KeyNumber(
            "tension error",
            f"{number_text(fasquelle.mean_error(1), 3)} N",
            "mean of elastic model 1; models "
            + join_words([f"{m}: {number_text(fasquelle.mean_error(m), 3)} N" for m in ELASTIC_MODELS if m != 1]),
        ),
    ]
    if result.simulated is not None:
        worst = max(value for name, value in result.simulated.rms.items() if name.startswith("alpha"))
        numbers.append(
            KeyNumber(
                "simulated angle error",
                f"{number_text(float(np.degrees(worst)), 3)} deg",
                f"RMS of the worst joint, restarted every {result.simulated.window_s:g} s",
            )
        )
    return numbers
