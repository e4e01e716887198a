"""The unknowns of a fit: terms of the laws, and of every recording its pre-elongations, its delay, and what cables remember."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechanism.arm import Arm
from mechanism.friction import CM
from mechanism.laws import LAWS, Term, is_law, law_named
from xneck_foundation.errors import Refused
from xneck_foundation.spelling import quoted, valid_words

Array = NDArray[np.float64]

X0 = Term("x0", "m", low=-0.05, high=0.05, size=1e-3, would_tell="vary the cable's tension by tens of newtons")
"""pre-elongation of each cable beyond the description's, one for each recording"""
DELAY = Term("delay", "s", low=-0.01, high=0.05, size=1e-3, of="arm", would_tell="reverse the motors often")
"""time by which forces act later than the log says, one for each recording; below zero only by error"""
DELAY_SIGMA_S = 1e-3
"""s: standard deviation of that delay before any fit; forces act no more than a row or two of the log later (docs/thresholds.md)"""


@dataclass(frozen=True)
class Unknown:
    """One unknown number, of a law (recording None) or of a recording; recordings count from 0, cables or joints from 1."""

    term: Term
    index: int | None
    recording: int | None = None


@dataclass(frozen=True)
class Unknowns:
    """The numbers that are fitted, in the order of the parameter vector (P,), and those that are held."""

    entries: tuple[Unknown, ...]
    slots: Mapping[tuple[str, int | None], slice]
    """places of each fitted term in the vector, by name and recording"""
    held: Mapping[str, Array]
    laws: tuple[str, ...]

    @property
    def low(self) -> Array:
        """Lower bounds (P,). A term without effect at zero may come out below zero by chance: a bound there would bias it."""
        return np.array([-e.term.high if e.term.linear and e.term.low == 0 else e.term.low for e in self.entries])

    @property
    def high(self) -> Array:
        """Upper bounds (P,)."""
        return np.array([e.term.high for e in self.entries])

    @property
    def size(self) -> Array:
        """Sizes of the terms, (P,): what a person would call a change."""
        return np.array([e.term.size for e in self.entries])

    @property
    def start_priors(self) -> dict[int, tuple[float, float]]:
        """Mean and standard deviation, by place, of what is known of the memory with which recordings begin: few rows tell it."""
        starts = memory_starts(self.laws)
        known = [i for i, e in enumerate(self.entries) if e.term in starts and np.isfinite(e.term.sigma)]
        return {i: (0.0, self.entries[i].term.sigma) for i in known}

    def get(self, p: Array, name: str, recording: int | None = None) -> Array:
        """Values of a term, fitted or held."""
        slot = self.slots.get((name, recording))
        return self.held[name] if slot is None else p[slot]

    def values(self, p: Array, recording: int | None = None) -> dict[str, Array]:
        """Values of all terms of the laws, as laws take them; of a recording, also what its cables remember at its beginning."""
        values = {term.name: self.get(p, term.name) for term in terms_of(self.laws)}
        if recording is not None:
            values |= {term.name: self.get(p, term.name, recording) for term in memory_starts(self.laws)}
        return values

    def carried(self, p: Array, to: "Unknowns") -> Array:
        """The numbers p of these unknowns as those of others, (P',): where those begin, if these have none."""
        out = to.start()
        for key, slot in to.slots.items():
            if key in self.slots:
                out[slot] = p[self.slots[key]]
        return out

    def start(self) -> Array:
        """Start of the fit, (P,): cables of medium stiffness and nothing else; transitions and time constants at their size."""
        initial = {"k": 5e3, "cm": CM, "delay": 0.0, "x0": 0.0, "E": 3e9}
        initial |= {term.name: 0.0 for term in memory_starts(self.laws)}
        values = [initial.get(e.term.name, e.term.size if e.term.low > 0 else 0.0) for e in self.entries]
        return np.array(values)


def terms_of(laws: Sequence[str]) -> tuple[Term, ...]:
    """The terms of laws, each once."""
    return tuple({term.name: term for name in laws for term in law_named(name).terms}.values())


def memory_starts(laws: Sequence[str]) -> tuple[Term, ...]:
    """What cables remember where a recording begins, by laws that do not forget it soon."""
    return tuple(start for name in laws if (start := law_named(name).memory_start))


def unknowns(
    arm: Arm, laws: Sequence[str], recordings: int, held: Mapping[str, float | Array] | None = None
) -> Unknowns:
    """The unknowns of laws by name; `held`: terms, of recordings too, that keep a value. Raises Refused for unknown names."""
    for name in laws:
        if not is_law(name):
            raise Refused("identify", f"unknown law {quoted(name)}", valid_words(name, LAWS))
    of_recording = (X0, DELAY, *memory_starts(laws))
    terms = [(term, None) for term in terms_of(laws)] + [(term, r) for r in range(recordings) for term in of_recording]
    fixed: dict[str, Array] = {}
    names = {term.name for term, _ in terms}
    for name, value in (held or {}).items():
        if name not in names:
            raise Refused("identify", f"no term {quoted(name)} to hold", valid_words(name, sorted(names)))
        count = next(term for term, _ in terms if term.name == name).count(arm)
        fixed[name] = np.broadcast_to(np.asarray(value, dtype=float), (count,)).copy()
    entries: list[Unknown] = []
    slots: dict[tuple[str, int | None], slice] = {}
    for term, recording in terms:
        if term.name in fixed:
            continue
        count = term.count(arm)
        slots[term.name, recording] = slice(len(entries), len(entries) + count)
        entries += [Unknown(term, None if term.of == "arm" else i + 1, recording) for i in range(count)]
    return Unknowns(tuple(entries), slots, fixed, tuple(laws))
