"""What a recording has of its own: where its motors started and how late they act, found with the laws held.

A model's x0 and delay belong to the recording that it was fitted to. Those of another one are fitted anew, and go with the laws:
were a cable's stiffness a little higher, its x0 would come out a little lower.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset import DataSet
from identification.fitting import fit_laws, segment_starts
from identification.residuals import delayed_forces, residual_rows
from identification.signals import signals_of
from identification.unknowns import unknowns
from identification.whitening import fit_whitener

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RecordingParameters:
    """Pre-elongation beyond the description's (M,), m, and delay, s; in vectors (M + 1,): x0, then delay."""

    x0: Array
    delay: float
    covariance: Array
    """(M + 1, M + 1), were the laws exact"""
    f: Array
    """forces as they act in the middle of what is held around each row of the state, (T, M), N"""
    by_law: Mapping[tuple[str, int | None], Array]
    """how the vector would answer to a change of each number of the laws, (M + 1,)"""


def fit_recording_parameters(data: DataSet, laws: tuple[str, ...], values: Mapping[str, Array]) -> RecordingParameters:
    """With the laws' numbers by term held. Raises Refused where the recording is too short or holds no forces."""
    signals = signals_of(data)
    m = signals.arm.M
    alone = unknowns(signals.arm, laws, 1, dict(values))
    found = fit_laws([signals], alone)
    both = unknowns(signals.arm, laws, 1)
    p = np.zeros(len(both.entries))
    for (name, recording), slot in both.slots.items():
        p[slot] = values[name] if recording is None else found.p[alone.slots[name, recording]]
    linear = residual_rows(signals, both, p, 0)
    starts = segment_starts(signals)
    J = fit_whitener([linear.residual], [starts])(linear.jacobian, starts).reshape(-1, len(p))
    ours = [i for i, e in enumerate(both.entries) if e.recording is not None]
    answer = -np.linalg.lstsq(J[:, ours] * both.size[ours], J, rcond=None)[0] * both.size[ours][:, None]
    by_law = {(e.term.name, e.index): answer[:, i] for i, e in enumerate(both.entries) if e.recording is None}
    delay = float(found.p[m])
    return RecordingParameters(found.p[:m], delay, found.covariance, delayed_forces(signals, delay), by_law)
