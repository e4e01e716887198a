"""Faults with a memory: a winch that slips, counts that get lost, a cable that goes slack for a moment."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from synchronisation.check.observation import Observed
from synchronisation.check.signatures import FaultCandidate

Array = NDArray[np.float64]

SLIPS_EVERY = 1.0
"""s between the times at which a slip is tried"""
MOST_TIMES = 60
"""times that are tried at most, so that a longer recording costs in proportion"""
FINER = 41
"""times that are tried around a slip"""
EDGE = 1.0
"""s at both ends where a step could not be told from an end"""
SLACK_S = 1.0
"""s that a slack cable's bump lasts"""
NEAR_SLACK_N = 5.0
"""a cable can only have been slack where its force came this near to none"""


def missed_counts(seen: Observed) -> Iterator[FaultCandidate]:
    """A share of the counts is lost while winding in, or while paying out: what is counted drifts with the way gone."""
    way = np.diff(seen.theta, axis=0, prepend=seen.theta[:1]) * seen.arm.drum
    # lost while winding in, and while paying out
    for part in (np.maximum(way, 0.0), np.minimum(way, 0.0)):
        for j, own in enumerate(np.eye(seen.arm.M)):
            yield FaultCandidate("missed_counts", f"cable {j + 1}", "1", -np.cumsum(part, axis=0) * own)


def slips(seen: Observed, cable: int) -> Iterator[FaultCandidate]:
    """Steps of one cable's elongation: the rope moves on its drum, so that counts promise more rope in than there is."""
    first, last = seen.time[0] + EDGE, seen.time[-1] - EDGE
    count = int(np.clip((last - first) / SLIPS_EVERY, 1, MOST_TIMES))
    yield from _slips_at(seen, cable, np.linspace(first, last, count))


def nearby(seen: Observed, found: FaultCandidate) -> Iterator[FaultCandidate]:
    """The same slip at times between those that were tried; nothing for other faults."""
    if found.fault == "winch_slip" and found.when is not None:
        step = max(SLIPS_EVERY, float(np.ptp(seen.time)) / MOST_TIMES)
        times = np.linspace(found.when - step, found.when + step, FINER)
        yield from _slips_at(seen, int(found.where.split()[1]) - 1, times)


def _slips_at(seen: Observed, cable: int, times: Array) -> Iterator[FaultCandidate]:
    own = np.eye(seen.arm.M)[cable]
    for when in times:
        after = (seen.time >= when).astype(float)[:, None]
        yield FaultCandidate("winch_slip", f"cable {cable + 1}", "m", after * own, float(when))


def slacks(seen: Observed, cable: int) -> Iterator[FaultCandidate]:
    """Bumps where the motor force hardly pulls: the rope hangs, and the law's elongation is not there."""
    force = seen.law.force[:, cable]
    own = np.eye(seen.arm.M)[cable]
    edges = np.linspace(seen.time[0], seen.time[-1], int(np.clip(np.ptp(seen.time) / SLACK_S, 1, MOST_TIMES)) + 1)
    for begin, end in pairwise(edges):
        inside = (seen.time >= begin) & (seen.time < end)
        if not inside.any() or force[inside].min() > NEAR_SLACK_N:
            continue
        when = float(seen.time[inside][np.argmin(force[inside])])
        bump = np.where(np.abs(seen.time - when) < SLACK_S / 2, np.cos(np.pi * (seen.time - when) / SLACK_S) ** 2, 0.0)
        yield FaultCandidate("cable_slack", f"cable {cable + 1}", "m", -bump[:, None] * own, when)
