"""The motion that determines given parameters best: D-optimal within limits. What else it is to show may count beside them.

Random shapes at first; then the best one is changed, one tone or one signal's reach at a time, and improvements are kept.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.design.fourier import FourierShape, random_shape, tone_frequencies
from identification.design.information import (
    AngleNoise,
    covariance_from,
    fisher_information,
    noise_free_signals,
    predicted_sigma,
)
from identification.design.repetition import likeness_to_itself
from identification.design.trajectory import MotionLimits, Trajectory, tension_levels, trajectory
from identification.unknowns import Unknowns, terms_of, unknowns
from mechanism.laws import LAWS
from mechanism.machine import Machine
from xneck_foundation.errors import Refused
from xneck_foundation.one_blas_thread import one_blas_thread
from xneck_foundation.spelling import quoted, valid_words

Array = NDArray[np.float64]

CONTROLLER_HZ = 500.0
"""Hz: rate of the table that a controller plays"""
_SEARCH_HZ = 50.0
"""Hz: rate during the search, 25 rows a period of the fastest tones"""
_MAX_LIKENESS, _REPETITION = 0.7, 200.0
"""correlation of joints' speeds with themselves later on, beyond which a motion counts as worse, and by how much of the log det:
`sync` warns of 0.85, and refuses 0.9 (docs/thresholds.md)"""
DEFAULT_TARGETS = ("fs", "k", "ca")


@dataclass(frozen=True)
class DesignTarget:
    """The parameters that a motion is designed for."""

    unknowns: Unknowns
    p: Array
    """parameter vector (P,) at which the motion is judged"""
    chosen: NDArray[np.intp]
    """places of the target parameters in the vector"""


@dataclass(frozen=True)
class SearchOptions:
    """How long the motion is, and how it is searched for."""

    seconds: float
    draws: int = 40
    """random shapes at first"""
    changes: int = 80
    """trials to improve the best of them"""
    seed: int = 0
    """of the random numbers"""
    band_hz: tuple[float, float] = (0.1, 2.0)
    """lowest and highest tone, Hz"""


@dataclass(frozen=True)
class DesignedMotion:
    """The motion, and the standard deviations that an identification from it is expected to report."""

    motion: Trajectory
    target: DesignTarget
    sigma: Array
    """of the parameter vector, (P,)"""
    drawn: tuple[float, ...]
    """criterion of each random shape: log det of the target's covariance, and what else counts; less is better"""
    criterion: float
    """the same of the motion"""


def design_target(machine: Machine, names: Sequence[str] = DEFAULT_TARGETS) -> DesignTarget:
    """Parameters by name (`k`), beside those that are fitted in any case.

    A parameter of a law that the machine does not follow is judged with the law's terms at their size. Raises Refused for unknown
    names.
    """
    machine_terms = {term.name for term in terms_of(machine.names)}
    law_of = {term.name: law for law in LAWS.values() for term in law.terms}
    laws = list(machine.names)
    for name in names:
        if name not in law_of:
            raise Refused("design --for", f"unknown parameter {quoted(name)}", valid_words(name, law_of))
        if name not in machine_terms:
            laws += [law_of[name].name] * (law_of[name].name not in laws)
    u = unknowns(machine.arm, laws, 1)
    p = np.zeros(len(u.entries))
    for i, e in enumerate(u.entries):
        if e.recording is None:
            values = machine.values.get(e.term.name)
            count = e.term.count(machine.arm)
            p[i] = e.term.size if values is None else np.broadcast_to(values, (count,))[(e.index or 1) - 1]
    chosen = [i for i, e in enumerate(u.entries) if e.recording is None and e.term.name in names]
    return DesignTarget(u, p, np.array(chosen, dtype=int))


def logdet(motion: Trajectory, target: DesignTarget, noise: AngleNoise) -> float:
    """log det of the target's covariance, in sizes of the terms: the lower, the better the motion determines it."""
    u = target.unknowns
    if not len(target.chosen):
        return 0.0
    covariance = covariance_from(fisher_information(noise_free_signals(motion), u, target.p, noise))
    size = u.size[target.chosen]
    return float(np.linalg.slogdet(covariance[np.ix_(target.chosen, target.chosen)] / np.outer(size, size))[1])


@one_blas_thread
def design_motion(
    machine: Machine,
    target: DesignTarget,
    limits: MotionLimits,
    noise: AngleNoise,
    options: SearchOptions,
    progress: Callable[[int], object] = lambda tried: None,
    also: Callable[[Trajectory], float] = lambda motion: 0.0,
) -> DesignedMotion:
    """The best of random shapes, improved by changing one coordinate after the other; `progress` is called with 1 for each trial.

    also: what else is to be small, added to the log det of the target's covariance. Raises Refused where nothing moves within the
    limits.
    """
    rng = np.random.default_rng(options.seed)
    signals = machine.arm.N + tension_levels(machine.arm).shape[1]
    hertz = tone_frequencies(signals, options.seconds, options.band_hz)

    def judged(shape: FourierShape) -> float:
        motion = trajectory(machine, shape, limits, options.seconds, _SEARCH_HZ)
        likeness = likeness_to_itself(np.gradient(motion.alpha, axis=0))
        value = logdet(motion, target, noise) + also(motion) + _REPETITION * max(0.0, likeness - _MAX_LIKENESS)
        progress(1)
        return value

    shapes = [random_shape(hertz, rng) for _ in range(options.draws)]
    values = [judged(shape) for shape in shapes]
    best, lowest = shapes[int(np.argmin(values))], min(values)
    for trial in range(options.changes):
        changed = _changed(best, trial, rng)
        value = judged(changed)
        if value < lowest:
            best, lowest = changed, value
    motion = trajectory(machine, best, limits, options.seconds, CONTROLLER_HZ)
    information = fisher_information(noise_free_signals(motion), target.unknowns, target.p, noise)
    return DesignedMotion(
        motion=motion,
        target=target,
        sigma=predicted_sigma(information),
        drawn=tuple(values),
        criterion=logdet(motion, target, noise) + also(motion),
    )


def _changed(shape: FourierShape, trial: int, rng: np.random.Generator) -> FourierShape:
    """The shape with one coordinate changed at random, each in its turn: a tone's amplitude or phase, or a signal's reach."""
    signals, tones = shape.hertz.shape
    place = divmod(trial // 2 % (signals * tones), tones)
    if trial % (2 * tones) == 0:
        reach = shape.reach.copy()
        reach[place[0]] = rng.uniform(0.4, 1.0)
        return replace(shape, reach=reach)
    if trial % 2:
        phase = shape.phase.copy()
        phase[place] = rng.uniform(0, 2 * np.pi)
        return replace(shape, phase=phase)
    amplitude = shape.amplitude.copy()
    amplitude[place] *= rng.choice([0.0, 0.4, 2.5])
    return replace(shape, amplitude=amplitude)
