"""Recordings at one hypothesis and one set of the base model's numbers: residuals, and what they depend on."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diagnosis.hypothesis import BASE, Hypothesis
from diagnosis.input_variance import unsure
from identification.dataset.dataset import DataSet
from identification.instruments import driven
from identification.residual_sensitivity import Slow
from identification.residuals import Forces, ResidualRows, forces_at, left, rows
from identification.signals import Signals, signals_of
from identification.unknowns import Unknowns, unknowns

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RecordingLinearisation:
    """One recording at a point."""

    hypothesis: Hypothesis
    signals: Signals
    told: Signals
    """with the elongations that the motors tell: columns of vision's own would share its noise"""
    forces: Forces
    """by the laws"""
    told_forces: Forces
    tension: Array
    """(T, M), N, under which motors rub"""
    unsure: Array
    """(C, S), variance of rows beyond noise"""
    slow: Slow
    rows: ResidualRows
    laws: tuple[str, ...]
    values: dict[str, Array]
    x0: Array
    delay: float


@dataclass(frozen=True)
class Linearisation:
    """All recordings at one."""

    hypothesis: Hypothesis
    unknowns: Unknowns
    p: Array
    late: Array
    """s, (R,): by how much each recording's frames show what was done later than its clock says"""
    places: tuple[RecordingLinearisation, ...]


def read_all(h: Hypothesis, recordings: Sequence[DataSet], late: Array) -> list[Signals]:
    """Recordings as they read with a hypothesis, each with its clock put right."""
    return [signals_of(h.read(data, float(by))) for data, by in zip(recordings, late, strict=True)]


def sought(h: Hypothesis, recordings: int) -> Unknowns:
    """The base model's numbers and each recording's own."""
    return unknowns(h.arm, (*BASE, *h.laws), recordings, dict(h.values))


def point(h: Hypothesis, recordings: Sequence[Signals], p: Array, late: Array) -> Linearisation:
    """At the base model's numbers p; recordings as `read_all` gives them."""
    u = sought(h, len(recordings))
    return Linearisation(h, u, p, late, tuple(_place(h, s, u, p, r) for r, s in enumerate(recordings)))


def _place(h: Hypothesis, s: Signals, u: Unknowns, p: Array, recording: int) -> RecordingLinearisation:
    told = driven(s, u, p, recording)
    told_forces = forces_at(told, u, p, recording)
    # as the motors tell it: vision's noise in it would go through friction into the arm's equation
    tension = told_forces.drive - s.inertial
    own = forces_at(s, u, p, recording, tension)
    values = u.values(p)
    return RecordingLinearisation(
        h,
        s,
        told,
        own,
        told_forces,
        tension,
        unsure(h.neck, s, values["fs"], values["cm"]),
        Slow(s, u, p, recording),
        ResidualRows(left(s, own), rows(told, u, p, recording).jacobian),
        u.laws,
        values,
        u.get(p, "x0", recording),
        float(u.get(p, "delay", recording)[0]),
    )


def relaid(at: Linearisation, h: Hypothesis, p: Array) -> Linearisation:
    """Another hypothesis by which the recordings read the same, at numbers p."""
    return point(h, [one.signals for one in at.places], p, at.late)
