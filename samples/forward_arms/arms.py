"""From seeds to arms with their recordings, as many at once as are integrated together."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from samples.forward_arms.camera import Film, film
from samples.forward_arms.controller import planned
from samples.forward_arms.drawing import built, drawn
from samples.forward_arms.given_motion import GivenMotion
from samples.forward_arms.laws import Law
from samples.forward_arms.plant import ROW, Array, Plant
from samples.forward_arms.settings import Settings
from samples.forward_arms.simulation import Played, play, row_times


@dataclass(frozen=True)
class Truth:
    """Every step from before the log's first row to after its last, (steps, ...): SI units, log time."""

    time: Array
    alpha: Array
    alpha_d: Array
    alpha_dd: Array
    theta: Array
    theta_d: Array
    tension: Array
    per_row: int
    """steps from row to row of the log"""
    logged: slice
    """steps from the log's first row to its last"""

    def within_log(self) -> "Truth":
        """The same from the first row to the last: every `per_row`-th step is a row."""
        names = ("time", "alpha", "alpha_d", "alpha_dd", "theta", "theta_d", "tension")
        cut = {name: getattr(self, name)[self.logged] for name in names}
        return Truth(**cut, per_row=self.per_row, logged=slice(0, len(cut["time"])))

    def filmed(self, settings: Settings, seed: Sequence[int]) -> Film:
        """By the camera of `settings`: the same motion may be seen many times. Clocks, exposure and noise are those of the seed."""
        return film(settings, self.time, self.alpha, self.alpha_d, np.random.default_rng(seed))


@dataclass(frozen=True)
class Recording:
    """What the lab would have, and the truth of it."""

    time: Array
    """(rows,), s"""
    theta: Array
    """(rows, M), rad, whole counts"""
    f: Array
    """(rows, M), N, held from its row on"""
    film: Film
    truth: Truth


@dataclass(frozen=True)
class Arm:
    """An arm as drawn, as it is, and its recordings."""

    seed: int
    drawing: Plant
    plant: Plant
    laws: tuple[Law, ...]
    recordings: tuple[Recording, ...]


def make_arms(
    seeds: Sequence[int],
    settings: Settings | None = None,
    hidden: Sequence[Sequence[Law]] | None = None,
    motions: Sequence[GivenMotion | None] | None = None,
) -> Iterator[Arm]:
    """Arms in the order of their seeds; those of one batch are integrated when the first of them is asked for.

    hidden: laws of each arm, in the place of those of the settings; a seed may then come several times, with other laws.
    motions: of each arm, played in all its recordings in the place of one that is drawn, if there is one.

    The same call gives the same numbers. An arm in another batch is the same arm, and its recordings agree until rounding
    errors of the last digit have moved an encoder's count.
    """
    settings = settings or Settings()
    if hidden is None:
        hidden = [settings.laws(seed) if settings.laws else () for seed in seeds]
    each = max(1, settings.columns // settings.recordings)
    for begin in range(0, len(seeds), each):
        batch = slice(begin, begin + each)
        given = [None] * len(seeds[batch]) if motions is None else list(motions[batch])
        yield from _batch(list(seeds[batch]), settings, [tuple(own) for own in hidden[batch]], given)


def _batch(
    seeds: list[int], settings: Settings, laws: list[tuple[Law, ...]], motions: Sequence[GivenMotion | None]
) -> Iterator[Arm]:
    for motion in motions:
        if motion and motion.seconds > settings.seconds:
            raise ValueError(f"a motion of {motion.seconds:g} s does not fit into recordings of {settings.seconds:g} s")
    drawings = [drawn(settings, seed) for seed in seeds]
    plants = []
    for seed, drawing, own in zip(seeds, drawings, laws, strict=True):
        plant = built(drawing, settings, seed)
        for law in own:
            plant = law.altered(plant)
        plants.append(plant)
    numbers = range(settings.first_recording, settings.first_recording + settings.recordings)
    columns = [(a, [seeds[a], 2 + r]) for a in range(len(seeds)) for r in numbers]
    time = row_times(settings)
    plans = [planned(settings, drawings[a], np.random.default_rng(seed), time, motions[a]) for a, seed in columns]
    played = play(
        settings, [plants[a] for a, _ in columns], [laws[a] for a, _ in columns], plans, [s for _, s in columns]
    )
    for a, seed in enumerate(seeds):
        own = range(a * settings.recordings, (a + 1) * settings.recordings)
        recordings = tuple(_recorded(settings, played, c, [*columns[c][1], 1]) for c in own)
        yield Arm(seed, drawings[a], plants[a], laws[a], recordings)


def _recorded(settings: Settings, p: Played, column: int, seed: Sequence[int]) -> Recording:
    per_row = round(ROW / settings.step)
    first, count = int(np.argmin(np.abs(p.row_time))), round(settings.seconds / ROW)
    rows = slice(first, first + count)
    logged = slice(first * per_row, (first + count - 1) * per_row + 1)
    names = ("alpha", "alpha_d", "alpha_dd", "theta", "theta_d", "tension")
    series = {name: np.ascontiguousarray(getattr(p, name)[:, :, column]) for name in names}
    truth = Truth(time=p.time, **series, per_row=per_row, logged=logged)
    theta, command = p.counted[rows, :, column], p.command[rows, :, column]
    return Recording(p.row_time[rows], theta, command, truth.filmed(settings, seed), truth)
