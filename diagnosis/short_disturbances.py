"""Stretches of recordings that are set aside: something short and strong acts there, as a hand does, and outweighs all causes.

What acts in a few stretches is no law of any variable. Beside it a fit names nothing, or gives a law the numbers of a hand.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from diagnosis.fit_stage import FitStage
from diagnosis.held_out_gain import HeldOutResiduals
from diagnosis.noise_ensemble import NoiseEnsemble
from diagnosis.noise_excess import NoiseExcess
from diagnosis.remainder import MAX_REMAINDER
from diagnosis.residual_episodes import MAX_TIME_SHARE, Episode, episode_share, episodes, rms_course

Array = NDArray[np.float64]

_EBB = 2.0
"""times the usual residual of a channel, down to which a stretch reaches beyond its episode (docs/thresholds.md)"""
_MAX_IN_WORDS = 6
"""that a sentence lists"""


def short_disturbances(stage: FitStage) -> tuple[Episode, ...]:
    """Of the fitted recordings, by what a stage leaves; none where that is not short."""
    times = [at.signals.kept_time for at in stage.comparison.linearisation.recordings]
    return _stretches(times, stage.judged_residuals, stage.judged_noise, stage.excess)


def short_disturbances_held_out(left: HeldOutResiduals, excess: NoiseExcess) -> tuple[Episode, ...]:
    """Of recordings that were not fitted; excess: of what is left there."""
    return _stretches(left.times, left.residuals, left.noise, excess)


def set_aside(ensembles: Sequence[NoiseEnsemble], stretches: Sequence[Episode]) -> list[NoiseEnsemble]:
    """Recordings whose rows in their stretches tell nothing."""
    return [
        ensemble.without([(e.begin, e.end) for e in stretches if e.recording == recording])
        for recording, ensemble in enumerate(ensembles)
    ]


def stretches_in_words(stretches: Sequence[Episode], recordings: int) -> str:
    """`34.3 to 35.3 s of recording 1, ...`; nothing where there are none. recordings: of how many."""
    times = [
        f"{e.begin:.1f} to {e.end:.1f} s" + (f" of recording {e.recording + 1}" if recordings > 1 else "")
        for e in stretches
    ]
    rest = f" and {len(times) - _MAX_IN_WORDS} more" if len(times) > _MAX_IN_WORDS else ""
    return ", ".join(times[:_MAX_IN_WORDS]) + rest


def _stretches(
    times: Sequence[Array], residuals: Sequence[Array], noise: Sequence[Sequence[Array]], excess: NoiseExcess
) -> tuple[Episode, ...]:
    """Episodes of channels that are plainly above noise, with the windows beside them in which these have not ebbed away.

    times: of each recording's rows, (S,), s; residuals: what is left of it, (C, S); noise: draws of noise alone, (C, S)."""
    courses = [rms_course(t, left, left, draws) for t, left, draws in zip(times, residuals, noise, strict=True)]
    channels = [k for k, ratio in enumerate(excess.ratio) if ratio > MAX_REMAINDER and episode_share(courses, k)]
    if not channels:
        return ()
    usual = np.median(np.concatenate([c.before[channels] for c in courses], axis=1), axis=1)
    out = []
    for episode in episodes(courses, channels):
        c = courses[episode.recording]
        is_high: NDArray[np.bool_] = np.any(c.before[channels] > _EBB * usual[:, None], axis=0)
        first, last = np.searchsorted(c.window_starts, [episode.begin, episode.end - c.window_s / 2], side="right") - 1
        while first > 0 and is_high[first - 1]:
            first -= 1
        while last < len(is_high) - 1 and is_high[last + 1]:
            last += 1
        out.append(Episode(episode.recording, float(c.window_starts[first]), float(c.window_starts[last] + c.window_s)))
    stretches = _joined(out)
    time = sum(len(c.window_starts) * c.window_s for c in courses)
    return stretches if sum(e.end - e.begin for e in stretches) <= MAX_TIME_SHARE * time else ()


def _joined(stretches: Sequence[Episode]) -> tuple[Episode, ...]:
    """Those that touch are one."""
    out: list[Episode] = []
    for e in stretches:
        if out and out[-1].recording == e.recording and e.begin <= out[-1].end:
            e = Episode(e.recording, out.pop().begin, e.end)
        out.append(e)
    return tuple(out)
