"""Slopes of the cables' equation against central differences."""

from dataclasses import replace

import numpy as np
import pytest

from samples.worlds.clock_worlds import arm, clock_recording
from synchronisation.clocks.cable_equation import CableEquation, CableTerms
from synchronisation.clocks.frame_geometry import frame_geometry
from synchronisation.clocks.gauss_newton_fit import ClockProblem, initial_unknowns
from synchronisation.clocks.signals import log_signals_of
from synchronisation.clocks.unknowns import ClockUnknowns
from synchronisation.encoder_log import uniformly_sampled

WITHOUT_CREEP = CableTerms(creep=(), damping=False)
OF_PLAY_AND_LOOPS = CableTerms(creep=(), damping=False, memory=1.0)
ALL_BUT_DAMPING = CableTerms(damping=False, drum=True)


def problem_and_unknowns(law: CableTerms) -> tuple[ClockProblem, CableEquation, ClockUnknowns]:
    """Six seconds of a recording, at unknowns of which none is zero."""
    made = clock_recording("everything", 100, 6.0)
    a, signals = made.angles, log_signals_of(arm(), uniformly_sampled(made.log))
    frames = frame_geometry(arm(), a.time, a.alpha, a.sigma, made.clocks.middle_s).part(slice(20, -20, 7))
    problem, cables = ClockProblem(signals, frames, made.fv), CableEquation(signals, law, fs=10.0)
    unknowns = initial_unknowns(problem, made.clocks.offset_s, cables)
    parameters = unknowns.cable_parameters + 1e-3
    geometry_errors = np.full(len(unknowns.geometry_errors), 2e-3)
    return problem, cables, replace(unknowns, delay=1e-3, geometry_errors=geometry_errors, cable_parameters=parameters)


@pytest.mark.parametrize("law", [WITHOUT_CREEP, OF_PLAY_AND_LOOPS, ALL_BUT_DAMPING])
def test_slopes_of_the_cables_are_those_of_central_differences(law: CableTerms) -> None:
    """The slope by the offset leaves out that of creep and drums, and damping is taken to first order: neither is compared."""
    problem, cables, unknowns = problem_and_unknowns(law)
    rows = cables.rows(problem.frames, unknowns)

    def difference(name: str, step: np.ndarray | float) -> np.ndarray:
        value = getattr(unknowns, name)
        up, down = (
            cables.rows(problem.frames, replace(unknowns, **{name: value + sign * step})).residual for sign in (1, -1)
        )
        return up - down

    def agree(slope: np.ndarray, expected: np.ndarray) -> None:
        np.testing.assert_allclose(slope, expected, rtol=1e-4, atol=1e-5 * np.abs(expected).max())

    agree(rows.by_delay, difference("delay", 1e-5) / 2e-5)
    agree(rows.by_fv, difference("fv", 1e-4) / 2e-4)
    for p, one in enumerate(np.eye(len(unknowns.geometry_errors))):
        agree(rows.by_geometry[..., p], difference("geometry_errors", 1e-4 * one) / 2e-4)
    for k, one in enumerate(np.eye(len(law.names))):
        agree(rows.by_parameter[..., k], difference("cable_parameters", 1e-5 * one) / 2e-5)
    if law is not ALL_BUT_DAMPING:
        agree(rows.by_offset, difference("offset", 1e-5) / 2e-5)
