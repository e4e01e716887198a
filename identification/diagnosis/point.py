"""Recordings at one hypothesis and one set of the base model's numbers: residuals, and what they depend on."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset import DataSet
from identification.diagnosis.hypothesis import BASE, Hypothesis
from identification.instruments import driven
from identification.residuals import Rows, rows
from identification.signals import Signals, signals_of
from identification.slow import Slow
from identification.unknowns import Unknowns, unknowns

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Place:
    """One recording at a point."""

    hypothesis: Hypothesis
    signals: Signals
    told: Signals
    """with the elongations that the motors tell: columns of vision's own would share its noise"""
    slow: Slow
    rows: Rows
    laws: tuple[str, ...]
    values: dict[str, Array]
    x0: Array
    delay: float


@dataclass(frozen=True)
class Point:
    """All recordings at one."""

    hypothesis: Hypothesis
    unknowns: Unknowns
    p: Array
    places: tuple[Place, ...]


def point(h: Hypothesis, recordings: Sequence[DataSet], p: Array | None = None) -> Point:
    """At the base model's numbers p, or where a fit would begin. recordings: as they were read."""
    u = unknowns(h.arm, (*BASE, *h.laws), len(recordings), dict(h.values))
    p = u.start() if p is None else p
    return Point(h, u, p, tuple(_place(h, signals_of(h.read(d)), u, p, r) for r, d in enumerate(recordings)))


def _place(h: Hypothesis, s: Signals, u: Unknowns, p: Array, recording: int) -> Place:
    told = driven(s, u, p, recording)
    return Place(
        h,
        s,
        told,
        Slow(s, u, p, recording),
        Rows(rows(s, u, p, recording).residual, rows(told, u, p, recording).jacobian),
        u.laws,
        u.values(p),
        u.get(p, "x0", recording),
        float(u.get(p, "delay", recording)[0]),
    )


def relaid(at: Point, h: Hypothesis, p: Array) -> Point:
    """Another hypothesis by which the recordings read the same, at numbers p."""
    u = unknowns(h.arm, (*BASE, *h.laws), len(at.places), dict(h.values))
    return Point(h, u, p, tuple(_place(h, one.signals, u, p, r) for r, one in enumerate(at.places)))


def moved(at: Point, p: Array) -> Point:
    """The same hypothesis at other numbers of the base model."""
    return relaid(at, at.hypothesis, p)
