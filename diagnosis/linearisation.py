"""Recordings at one hypothesis and one set of the base model's numbers: residuals, and what they depend on."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from diagnosis.held_at_rest import NOTHING_HELD, HeldAtRest
from diagnosis.hypothesis import BASE_LAWS, Hypothesis
from diagnosis.input_variance import FrictionSlopes, input_variance
from identification.cable_memory import cables_remember, pull_memory
from identification.dataset.dataset import DataSet
from identification.instruments import instrument_signals, remembered_elongations
from identification.motor_rest import at_rest
from identification.residual_sensitivity import ResidualSensitivity
from identification.residuals import (
    LawForces,
    ResidualRows,
    joint_motion,
    law_forces_at,
    pull_with_memory,
    remembered_motion,
    residual_rows,
    residuals_of,
    under_tension,
    with_other_elongations,
)
from identification.signals import Signals, signals_of
from identification.unknowns import Unknowns, unknowns
from mechanism.machine import Machine

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RecordingLinearisation:
    """One recording at a linearisation point."""

    hypothesis: Hypothesis
    signals: Signals
    """with elongations as vision measures them"""
    motor_signals: Signals
    """with elongations that follow from the motors: columns of vision's elongations would share its noise"""
    forces: LawForces
    """the laws' forces on `signals`"""
    motor_forces: LawForces
    """the laws' forces on `motor_signals`"""
    tension: Array
    """(T, M), N, under which motors rub"""
    memory: Array
    """(T, M, states), of the cables along `motor_signals`: one along vision's elongations would forget by their noise"""
    friction_slopes: FrictionSlopes
    """by which the error of motor speeds becomes one of friction"""
    input_variance: Array
    """(C, S), variance of rows beyond noise, by that error and by what is held at rest"""
    held: HeldAtRest
    rows: ResidualRows
    laws: tuple[str, ...]
    values: dict[str, Array]
    x0: Array
    delay: float

    @cached_property
    def sensitivity(self) -> ResidualSensitivity:
        """To the arm's description and to the angles: few fits ask for it at every step."""
        return ResidualSensitivity(self.signals, self.laws, self.values, self.x0, self.delay, self.memory)


@dataclass(frozen=True)
class Linearisation:
    """All recordings at one hypothesis and one vector p of the base model's numbers."""

    hypothesis: Hypothesis
    unknowns: Unknowns
    p: Array
    frame_lags: Array
    """(R,), s, by which each recording's frames show what was done later than its clock says"""
    recordings: tuple[RecordingLinearisation, ...]

    @property
    def machine(self) -> Machine:
        """The arm with the laws' numbers."""
        return Machine(self.hypothesis.arm, self.unknowns.laws, self.unknowns.values(self.p))


def corrected_signals(h: Hypothesis, recordings: Sequence[DataSet], frame_lags: Array) -> list[Signals]:
    """Recordings as they read with a hypothesis, each with its clock put right by its lag (R,), s."""
    return [
        signals_of(h.corrected(data, float(lag)), load_by_frames=True)
        for data, lag in zip(recordings, frame_lags, strict=True)
    ]


def base_unknowns(h: Hypothesis, recordings: int) -> Unknowns:
    """What is fitted of the base model and of each recording; numbers of the hypothesis's laws are held."""
    return unknowns(h.arm, (*BASE_LAWS, *h.laws), recordings, dict(h.values))


def linearise(h: Hypothesis, recordings: Sequence[Signals], p: Array, frame_lags: Array) -> Linearisation:
    """At the base model's numbers p; recordings as `corrected_signals` gives them."""
    u = base_unknowns(h, len(recordings))
    return Linearisation(h, u, p, frame_lags, tuple(_recording(h, s, u, p, r) for r, s in enumerate(recordings)))


def _recording(h: Hypothesis, s: Signals, u: Unknowns, p: Array, recording: int) -> RecordingLinearisation:
    values, x0 = u.values(p, recording), u.get(p, "x0", recording)
    machine = Machine(s.arm, u.laws, values)
    vision_forces = law_forces_at(s, u, p, recording)
    motor_signals = instrument_signals(s, u, p, recording, vision_forces)
    if cables_remember(machine):
        remembered = remembered_elongations(motor_signals)
        s, motor_signals = (replace(either, remembered=remembered) for either in (s, motor_signals))
    # as it follows from the motors: vision's noise in it would go through friction into the arm's equation
    motor_forces = with_other_elongations(motor_signals, vision_forces, machine, x0)
    tension = motor_forces.drive - s.inertial
    motor_forces = under_tension(s, motor_forces, machine, tension)
    memory = pull_memory(machine, remembered_motion(s, x0), s.step)
    vision_forces = replace(motor_forces, pull=pull_with_memory(s, machine, x0, memory))
    slopes = FrictionSlopes.of(machine, s, tension)
    held = HeldAtRest(
        motors=np.abs(values["fs"]) * at_rest(s.theta, 1 / s.step),
        joints=machine.held_torque(joint_motion(s), s.Z, s.wraps, tension),
    )
    variance = input_variance(s, slopes)
    if h.held != NOTHING_HELD:
        variance = variance + held.variance(h.held, s)
    return RecordingLinearisation(
        hypothesis=h,
        signals=s,
        motor_signals=motor_signals,
        forces=vision_forces,
        motor_forces=motor_forces,
        tension=tension,
        memory=memory,
        friction_slopes=slopes,
        input_variance=variance,
        held=held,
        rows=ResidualRows(
            residuals_of(s, vision_forces),
            residual_rows(motor_signals, u, p, recording, tension, motor_forces).jacobian,
        ),
        laws=u.laws,
        values=values,
        x0=x0,
        delay=float(u.get(p, "delay", recording)[0]),
    )


def with_laws_of(at: Linearisation, h: Hypothesis, p: Array) -> Linearisation:
    """Another hypothesis by which the recordings read the same, at numbers p."""
    return linearise(h, [recording.signals for recording in at.recordings], p, at.frame_lags)
