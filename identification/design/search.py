"""The motion of which an identification will learn most: D-optimal for the parameters named, within limits.

Shapes at random first; then the best one is changed, one tone or one joint's reach after the other, and what is better is kept.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.design.fourier import FourierShape, random_shape, tone_frequencies
from identification.design.information import AngleNoise, covariance_from, fisher_information, predicted_sigma, noise_free_signals
from identification.design.trajectory import MotionLimits, Trajectory, tension_levels, trajectory
from identification.unknowns import Unknowns, terms_of, unknowns
from mechanism.laws import LAWS
from mechanism.machine import Machine
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

CONTROLLER_HZ = 500.0
"""of the controller"""
_COARSE_HZ = 50.0
"""while searching: the fastest tones have 25 rows"""
DEFAULT_TARGETS = ("fs", "k", "ca")


@dataclass(frozen=True)
class DesignTarget:
    """What is to be told."""

    unknowns: Unknowns
    p: Array
    """(P,), where it is judged"""
    chosen: NDArray[np.intp]
    """places of what was named"""


@dataclass(frozen=True)
class DesignedMotion:
    """The motion, the standard deviations that an identification of it will have (P,), and how the search went."""

    motion: Trajectory
    design_target: DesignTarget
    sigma: Array
    drawn_logdet: tuple[float, ...]
    """log det of the covariance of what was named, of each random shape"""
    logdet: float


def design_target(machine: Machine, names: Sequence[str] = DEFAULT_TARGETS) -> DesignTarget:
    """Parameters by name (`k`), or all of a law by its name (`cable_hardening`), beside what is fitted in any case.

    A law that the machine does not follow is judged where its terms have their size. Raises Refused for unknown names.
    """
    own = {term.name for term in terms_of(machine.names)}
    holder = {term.name: law for law in LAWS.values() for term in law.terms}
    laws, terms = list(machine.names), []
    for name in names:
        if name not in LAWS and name not in holder:
            raise Refused("design --for", f"unknown parameter {name!r}", f"valid: {', '.join([*holder, *LAWS])}")
        law = LAWS.get(name) or holder[name]
        if name in LAWS or name not in own:
            laws += [law.name] * (law.name not in laws)
        terms += [term.name for term in law.terms] if name in LAWS else [name]
    u = unknowns(machine.arm, laws, 1)
    p = u.start()
    for i, e in enumerate(u.entries):
        if e.recording is None:
            given = machine.values.get(e.term.name)
            p[i] = (
                e.term.size
                if given is None
                else np.broadcast_to(given, (_count(machine, e.term.of),))[(e.index or 1) - 1]
            )
        else:
            p[i] = 0.0
    chosen = [i for i, e in enumerate(u.entries) if e.recording is None and e.term.name in terms]
    return DesignTarget(u, p, np.array(chosen))


def _count(machine: Machine, of: str) -> int:
    return {"cable": machine.arm.M, "joint": machine.arm.N, "arm": 1}[of]


def logdet(motion: Trajectory, w: DesignTarget, noise: AngleNoise) -> float:
    """Of the covariance of what was named, in sizes of the terms: the lower, the more is told."""
    found = covariance_from(fisher_information(noise_free_signals(motion), w.unknowns, w.p, noise))
    size = w.unknowns.size[w.chosen]
    return float(np.linalg.slogdet(found[np.ix_(w.chosen, w.chosen)] / np.outer(size, size))[1])


def design_motion(
    machine: Machine,
    w: DesignTarget,
    limits: MotionLimits,
    noise: AngleNoise,
    seconds: float,
    band: tuple[float, float] = (0.1, 2.0),
    draws: int = 40,
    changes: int = 80,
    seed: int = 0,
    progress: Callable[[int], object] = lambda tried: None,
) -> DesignedMotion:
    """The best of `draws` random shapes, made better by up to `changes` trials; `progress` is told of each.

    Raises Refused where nothing moves within the limits.
    """
    rng = np.random.default_rng(seed)
    hertz = tone_frequencies(machine.arm.N + tension_levels(machine.arm).shape[1], seconds, band)

    def judged(shape: FourierShape) -> float:
        value = logdet(trajectory(machine, shape, limits, seconds, _COARSE_HZ), w, noise)
        progress(1)
        return value

    shapes = [random_shape(hertz, rng) for _ in range(draws)]
    values = [judged(shape) for shape in shapes]
    best, least = shapes[int(np.argmin(values))], min(values)
    for trial in range(changes):
        other = _changed(best, trial, rng)
        value = judged(other)
        if value < least:
            best, least = other, value
    motion = trajectory(machine, best, limits, seconds, CONTROLLER_HZ)
    found = fisher_information(noise_free_signals(motion), w.unknowns, w.p, noise)
    return DesignedMotion(motion, w, predicted_sigma(found), tuple(values), logdet(motion, w, noise))


def _changed(shape: FourierShape, trial: int, rng: np.random.Generator) -> FourierShape:
    """One coordinate in its turn: a tone's amplitude, its phase, or a signal's reach."""
    signals, each = shape.hertz.shape
    place = divmod(trial // 2 % (signals * each), each)
    if trial % (2 * each) == 0:
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
