"""Parameters of a recording, not of the arm: pre-elongation x0, delay of its forces and what its cables remember at its beginning.

A model's x0 and delay belong to the recording that it was fitted to. Those of another recording are fitted anew, and depend on the
laws: if a cable's stiffness were a little higher, its x0 would come out a little lower.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset import DataSet
from identification.fitting import fit_by_least_squares, fit_laws, segment_starts
from identification.motor_speeds import with_motor_speeds
from identification.residuals import delayed_forces, residual_rows
from identification.signals import Signals, signals_of
from identification.unknowns import Unknowns, memory_starts, unknowns
from identification.whitening import fit_whitener
from mechanism.machine import Machine

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RecordingParameters:
    """Pre-elongation beyond the description's (M,), m, and delay, s; vectors (M + 1,) hold x0, then delay."""

    x0: Array
    delay: float
    covariance: Array
    """if the laws were exact: of x0 and delay, (M + 1, M + 1), and behind them of what cables remember, where laws have it"""
    f: Array
    """forces as they act in each row of the state, (T, M), N"""
    memory_start: Mapping[str, Array]
    """what cables remember where the recording begins, by term"""
    by_law: Mapping[tuple[str, int | None], Array]
    """derivative of x0 and delay by each parameter of the laws, (M + 1,), by name and index"""


def fit_recording_parameters(data: DataSet, laws: tuple[str, ...], values: Mapping[str, Array]) -> RecordingParameters:
    """Fitted with the laws' values, by term, held. Raises Refused where the recording is too short or holds no forces."""
    signals = signals_of(data)
    m = signals.arm.M
    without_laws = unknowns(signals.arm, laws, 1, dict(values))
    first = fit_by_least_squares([signals], without_laws)
    signals = signals_of(with_motor_speeds(data, Machine(data.arm, laws, values), float(first[m])))
    with_laws = unknowns(signals.arm, laws, 1)
    noise = _noise(signals, with_laws, without_laws, first, values)
    solution = fit_laws([signals], without_laws, start=first, noise=[noise])
    p = _with_laws(with_laws, without_laws, solution.p, values)
    linear = residual_rows(signals, with_laws, p, 0)
    rows = segment_starts(signals)
    J = fit_whitener([noise], [rows])(linear.jacobian, rows).reshape(-1, len(p))
    own = [i for i, e in enumerate(with_laws.entries) if e.recording is not None]
    derivative = -np.linalg.lstsq(J[:, own] * with_laws.size[own], J, rcond=None)[0] * with_laws.size[own][:, None]
    by_law = {(e.term.name, e.index): derivative[:, i] for i, e in enumerate(with_laws.entries) if e.recording is None}
    delay = float(solution.p[m])
    starts = {term.name: without_laws.get(solution.p, term.name, 0) for term in memory_starts(laws)}
    f = delayed_forces(signals, delay).copy()
    # a mean over two periods of the command smooths, simulated forces are those in the row: undone to second order
    f[1:-1] -= (f[2:] - 2 * f[1:-1] + f[:-2]) / 6
    return RecordingParameters(
        x0=solution.p[:m], delay=delay, covariance=solution.covariance, f=f, memory_start=starts, by_law=by_law
    )


def _noise(
    signals: Signals, with_laws: Unknowns, without_laws: Unknowns, first: Array, values: Mapping[str, Array]
) -> Array:
    """What instruments leave in the rows, (C, S): the residuals with the laws fitted anew, for those of wrong laws hold more.

    Laws that remember are at times not found by such a fit: an equation in which it leaves more has what the given laws leave.
    """
    refitted = fit_by_least_squares([signals], with_laws, start=_with_laws(with_laws, without_laws, first, values))
    anew, given = residual_rows(signals, with_laws, refitted, 0), residual_rows(signals, without_laws, first, 0)
    is_less = np.mean(anew.residual**2, axis=1) < np.mean(given.residual**2, axis=1)
    return np.where(is_less[:, None], anew.residual, given.residual)


def _with_laws(with_laws: Unknowns, without_laws: Unknowns, p: Array, values: Mapping[str, Array]) -> Array:
    """Parameters of laws and recording, those of the laws by their values."""
    out = np.zeros(len(with_laws.entries))
    for (name, recording), slot in with_laws.slots.items():
        out[slot] = values[name] if recording is None else p[without_laws.slots[name, recording]]
    return out
