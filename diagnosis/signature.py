"""What is wrong with a simulation, described: in which equation, under which conditions, going round with what, and when.

A pattern counts where it takes more of a residual than chance, beyond what the base model's own numbers and a drawing's per cents
could have made of it: an error in one equation drives these, and they leave their own smooth traces in the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.drum_periodogram import DrumWave, drum_wave
from diagnosis.explained_energy import Energy, autocovariance, explained_energy, orthonormal
from diagnosis.fit_stage import FitStage
from diagnosis.judged_rows import judged
from diagnosis.linearisation import RecordingLinearisation
from diagnosis.noise_excess import ABOVE_NOISE_RATIO, NoiseExcess
from diagnosis.residual_conditions import Condition, conditions
from diagnosis.residual_episodes import Episode, RmsCourse, episode_share, episodes, rms_course

Array = NDArray[np.float64]

FALSE_ALARM = 0.01
"""probability that chance makes a pattern of a whole diagnosis: each of its patterns has its part (docs/thresholds.md)"""
CONSTANT = "always"
_CONSTANT_SHARE = 0.95
"""of what the best pattern explains: a constant that explains as much stands for it (docs/thresholds.md)"""
_MIN_EXPLAINED = 0.05
"""of what stands above noise: what a pattern explains at least to be spoken of (docs/thresholds.md)"""
_MIN_EXPLAINED_BESIDE_EPISODES = 0.25
"""of what stands above noise: what a pattern explains at least where all the rest comes in short episodes (docs/thresholds.md)"""
_MAIN_SHARE = 0.1
"""of what stands above noise in the worst arm equation: those that hold less have traces of it (docs/thresholds.md)"""


@dataclass(frozen=True)
class Pattern:
    """A channel's residual against a condition, by K bins: means and RMS before and after, and noise alone."""

    channel: int
    """counted from 0, the motors' before the joints'"""
    against: str
    unit: str
    bin_middles: Array
    """(K,), as are the next five"""
    before: Array
    after: Array
    before_rms: Array
    after_rms: Array
    noise: Array
    explains: float
    """share of what the channel has above noise, by the bins' means, less what chance would explain; 0 where all is noise"""
    explains_beyond_base: float
    """share of what the base model's numbers could not have made, less what chance would explain"""
    log_p: float
    """of chance to take as much of that"""
    drum_wave: DrumWave | None = None


@dataclass(frozen=True)
class Signature:
    """The pattern of a kind that the channels above noise have in common, all patterns, and the course in time."""

    kind: str
    """periodic, drift, episodes, constant, or a condition's name; nothing where all is noise, unclear where nothing stands out"""
    shown: tuple[Pattern, ...]
    """those that show it, the clearest first"""
    episodes: tuple[Episode, ...]
    patterns: tuple[Pattern, ...]
    courses: tuple[RmsCourse, ...]
    channels: tuple[int, ...]
    """where it shows"""
    best: Pattern
    """the one that proves most"""

    @property
    def clear(self) -> tuple[Pattern, ...]:
        """Patterns that chance does not make, in channels above noise."""
        return _clear(self.patterns)


def signature(first: FitStage, last: FitStage) -> Signature:
    """Of what the base model leaves (first), beside what is left with the causes (last)."""
    base, excess = first.comparison, first.excess
    before, after = first.judged_residuals, last.judged_residuals
    recordings = base.linearisation.recordings
    courses = tuple(
        rms_course(recording.signals.kept_time, old, new, draws)
        for recording, old, new, draws in zip(recordings, before, after, first.judged_noise, strict=True)
    )
    grid_rows = [_grid_rows(r.signals.low_pass.kept, r.signals.low_pass.factor) for r in recordings]
    base_end = base.base_count + base.nuisance_count
    base_columns = [
        judged(m[..., :base_end].swapaxes(1, 2), r.signals) for m, r in zip(base.matrices, recordings, strict=True)
    ]
    patterns: list[Pattern] = []
    for c in range(len(excess.rms)):
        above = excess.ratio[c] > ABOVE_NOISE_RATIO
        variance = float(excess.rms[c] ** 2 - excess.floor[c] ** 2) if above else np.inf
        channel = _Channel(
            number=c,
            before=[r[c] for r in before],
            after=[r[c] for r in after],
            noise=[[d[c] for d in draws] for draws in first.judged_noise],
            basis=_basis(np.concatenate([m[c].T for m in base_columns])),
            grid_rows=grid_rows,
            excess_energy=variance * sum(r.shape[1] for r in before),
        )
        patterns += [channel.pattern(condition) for condition in conditions(recordings, c)]
        always = Condition(CONSTANT, "", tuple(np.zeros(r.shape[1]) for r in before), is_cyclic=True)
        patterns.append(channel.pattern(always))
        if c < recordings[0].signals.arm.M:
            wave = drum_wave(channel.remainder, recordings, c, channel.basis, channel.remainder_covariance)
            patterns += [channel.wave_pattern(wave, recordings)] if wave is not None else []
    return _signature(tuple(patterns), courses, excess, recordings[0].signals.arm.M)


class _Channel:
    """Residuals of one channel: whole, and beyond what the base model's numbers could have made."""

    def __init__(
        self,
        number: int,
        before: Sequence[Array],
        after: Sequence[Array],
        noise: Sequence[Sequence[Array]],
        basis: Array,
        grid_rows: Sequence[NDArray[np.intp]],
        excess_energy: float,
    ) -> None:
        self.number, self.before, self.after, self.noise = number, before, after, noise
        self.basis, self.excess_energy = basis, excess_energy
        flat = np.concatenate(before)
        self.remainder = np.split(flat - basis @ (basis.T @ flat), np.cumsum([len(r) for r in before])[:-1])
        self.covariance = autocovariance(before, grid_rows)
        self.remainder_covariance = autocovariance(self.remainder, grid_rows)

    def pattern(self, c: Condition) -> Pattern:
        """Against a condition."""
        (before, before_rms), (after, after_rms) = c.means(self.before), c.means(self.after)
        noise = np.sqrt(np.mean([c.means(d)[1] ** 2 for d in zip(*self.noise, strict=True)], axis=0))
        columns = c.columns()
        whole = explained_energy(self.before, columns, np.zeros((len(self.basis), 0)), self.covariance)
        beyond = explained_energy(self.remainder, columns, self.basis, self.remainder_covariance)
        middles, _ = c.bins()
        return Pattern(
            channel=self.number,
            against=c.name,
            unit=c.unit,
            bin_middles=middles,
            before=before,
            after=after,
            before_rms=before_rms,
            after_rms=after_rms,
            noise=noise,
            explains=min(1.0, max(0.0, (whole.taken - whole.expected) / self.excess_energy)),
            explains_beyond_base=self._share_of_remainder(beyond),
            log_p=beyond.log_p,
        )

    def wave_pattern(self, wave: DrumWave, recordings: Sequence[RecordingLinearisation]) -> Pattern:
        """Against the drum's angle, folded into one of so many waves a turn."""
        angles = [r.signals.theta[r.signals.low_pass.kept, self.number] / wave.gear for r in recordings]
        phase = tuple(wave.order * a / (2 * np.pi) % 1 for a in angles)
        folded = self.pattern(Condition("drum's wave", "wave", phase, is_cyclic=True))
        share = self._share_of_remainder(wave.energy)
        return replace(folded, drum_wave=wave, explains_beyond_base=share, log_p=wave.log_p)

    def _share_of_remainder(self, energy: Energy) -> float:
        return max(0.0, energy.taken - energy.expected) / sum(float(r @ r) for r in self.remainder)


def _signature(
    patterns: tuple[Pattern, ...], courses: tuple[RmsCourse, ...], excess: NoiseExcess, motors: int
) -> Signature:
    """What the patterns and courses of all channels, the motors' first, have in common."""
    above = [k for k in range(len(excess.rms)) if excess.ratio[k] > ABOVE_NOISE_RATIO]
    clear = _clear(patterns)
    worst = int(np.argmax(excess.ratio))
    best = max(clear or tuple(p for p in patterns if p.channel == worst), key=lambda p: (p.explains, -p.log_p))
    best = _or_constant(best, clear)

    def of_kind(
        kind: str, channels: Sequence[int], shown: tuple[Pattern, ...] = (), listed: tuple[Episode, ...] = ()
    ) -> Signature:
        return Signature(
            kind=kind,
            shown=shown,
            episodes=listed,
            patterns=patterns,
            courses=courses,
            channels=tuple(channels),
            best=best,
        )

    if not above:
        return of_kind("nothing", ())
    episodic = [k for k in above if episode_share(courses, k)]
    votes: dict[str, list[Pattern]] = {}
    for channel in above:
        of_channel = [p for p in clear if p.channel == channel]
        if of_channel:
            most = _or_constant(max(of_channel, key=lambda p: p.explains_beyond_base), of_channel)
            votes.setdefault(kind_of(most), []).append(most)
    # what follows a condition may come and go with it; traces of what is brief may follow one a little
    if episodic and max((p.explains for p in clear), default=0.0) < _MIN_EXPLAINED_BESIDE_EPISODES:
        return of_kind("episodes", episodic, listed=episodes(courses, episodic))
    if not votes:
        return of_kind("unclear", above)
    weight = {kind: sum(p.explains_beyond_base for p in voted) for kind, voted in votes.items()}
    kind = max(weight, key=lambda k: weight[k])
    shown = tuple(sorted(votes[kind], key=lambda p: -p.explains_beyond_base))
    main = _main_joints(excess, above, motors)
    if main and not any(p.channel < motors or p.channel in main for p in shown):
        return of_kind("unclear", main)  # traces that what is wrong at other joints leaves in these
    return of_kind(kind, sorted(p.channel for p in shown), shown)


def _main_joints(excess: NoiseExcess, above: Sequence[int], motors: int) -> list[int]:
    """Of the channels above noise the arm equations that hold most of what stands above it in these.

    What is wrong at a motor shows in arm equations by many times more noise: the motor's own is not compared with them."""
    energy = {k: float(excess.ratio[k]) ** 2 - 1 for k in above if k >= motors}
    return [k for k in energy if energy[k] > _MAIN_SHARE * max(energy.values())]


def _clear(patterns: Sequence[Pattern]) -> tuple[Pattern, ...]:
    max_log_p = np.log(FALSE_ALARM / len(patterns))
    return tuple(p for p in patterns if p.log_p < max_log_p and p.explains > _MIN_EXPLAINED)


def kind_of(p: Pattern) -> str:
    """What a pattern says."""
    if p.drum_wave is not None:
        return "periodic"
    if p.against.startswith("time"):
        return "drift"
    return "constant" if p.against == CONSTANT else p.against


def _or_constant(best: Pattern, clear: Sequence[Pattern]) -> Pattern:
    """The best pattern, or a constant in its place where that explains as much."""
    constants = (p for p in clear if p.against == CONSTANT and p.channel == best.channel)
    return next((p for p in constants if p.explains >= _CONSTANT_SHARE * best.explains), best)


def _basis(columns: Array) -> Array:
    size = np.linalg.norm(columns, axis=0)
    return orthonormal(columns[:, size > 0] / size[size > 0])


def _grid_rows(kept: NDArray[np.intp], factor: int) -> NDArray[np.intp]:
    """Rows of the filter's grid from the first one that is kept, (S,)."""
    return (kept - kept[0]) // factor
