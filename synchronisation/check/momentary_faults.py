"""Faults with a memory: a winch that slips, counts that get lost, a cable that goes slack for a moment."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mechanism.typical_load import typical_load
from synchronisation.check.observation import ElongationObservation
from synchronisation.check.signatures import FaultCandidate

Array = NDArray[np.float64]

SLIP_INTERVAL_S = 1.0
"""s between the times at which a slip is tried (docs/thresholds.md)"""
MAX_TIMES = 60
"""times that are tried at most, so that the cost grows no faster than the recording (docs/thresholds.md)"""
REFINED_TIMES = 41
"""times that are tried around a slip (docs/thresholds.md)"""
EDGE_S = 1.0
"""s at both ends within which a step could not be told from the end (docs/thresholds.md)"""
SLACK_S = 1.0
"""s that a slack cable's bump lasts (docs/thresholds.md)"""
MIN_WOUND_M = 1e-6
"""m: a cable that winds less has no counts to miss"""
MAX_SLACK_SHARE = 0.5
"""of the arm's typical load: a cable can only have been slack where its tension fell below this (docs/thresholds.md)"""


def missed_counts(observation: ElongationObservation) -> Iterator[FaultCandidate]:
    """A share of the counts is lost while winding in, or while paying out: the measured travel drifts with the distance wound.

    It is a slip in small pieces. What the law leaves of a healthy cable passes for as much rope as at once: by that, and not by the
    share, an arm counts as healthy."""
    travel = np.diff(observation.theta, axis=0, prepend=observation.theta[:1]) * observation.arm.drum
    for wound in (np.maximum(travel, 0.0), np.minimum(travel, 0.0)):
        for j, cable in enumerate(np.eye(observation.arm.M)):
            # counts lost one way look like counts gained the other and a drum within its tolerance: none are gained
            signature = -np.cumsum(wound, axis=0) * cable
            rope = max(float(np.abs(signature[-1]).sum()), MIN_WOUND_M)
            yield FaultCandidate("missed_counts", f"cable {j + 1}", "1", signature, smallest=0.0, healthy_unit=1 / rope)


def slips(observation: ElongationObservation, cable: int) -> Iterator[FaultCandidate]:
    """Steps of one cable's elongation: the rope moves on its drum, so that less rope is wound in than counts say."""
    first, last = observation.time[0] + EDGE_S, observation.time[-1] - EDGE_S
    count = int(np.clip((last - first) / SLIP_INTERVAL_S, 1, MAX_TIMES))
    yield from _slips_at(observation, cable, np.linspace(first, last, count))


def slips_near(observation: ElongationObservation, candidate: FaultCandidate) -> Iterator[FaultCandidate]:
    """The same slip at times between those that were tried; nothing for other faults."""
    if candidate.fault == "winch_slip" and candidate.when is not None:
        interval = max(SLIP_INTERVAL_S, float(np.ptp(observation.time)) / MAX_TIMES)
        times = np.linspace(candidate.when - interval, candidate.when + interval, REFINED_TIMES)
        yield from _slips_at(observation, int(candidate.where.split()[1]) - 1, times)


def _slips_at(observation: ElongationObservation, cable: int, times: Array) -> Iterator[FaultCandidate]:
    of_cable = np.eye(observation.arm.M)[cable]
    for when in times:
        after = (observation.time >= when).astype(float)[:, None]
        yield FaultCandidate("winch_slip", f"cable {cable + 1}", "m", after * of_cable, float(when))


def slacks(observation: ElongationObservation, cable: int) -> Iterator[FaultCandidate]:
    """Bumps where the motor hardly pulls: the rope hangs, and the elongation that the law expects is absent."""
    time, tension = observation.time, observation.law.tension[:, cable]
    of_cable = np.eye(observation.arm.M)[cable]
    most = MAX_SLACK_SHARE * typical_load(observation.arm)
    edges = np.linspace(time[0], time[-1], int(np.clip(np.ptp(time) / SLACK_S, 1, MAX_TIMES)) + 1)
    for begin, end in pairwise(edges):
        inside = (time >= begin) & (time < end)
        if not inside.any() or tension[inside].min() > most:
            continue
        when = float(time[inside][np.argmin(tension[inside])])
        bump = np.where(np.abs(time - when) < SLACK_S / 2, np.cos(np.pi * (time - when) / SLACK_S) ** 2, 0.0)
        yield FaultCandidate("cable_slack", f"cable {cable + 1}", "m", -bump[:, None] * of_cable, when)
