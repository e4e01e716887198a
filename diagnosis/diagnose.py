"""What the simulation gets wrong, its cause, and what the model gains by it: the whole diagnosis of recordings of one arm."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause import Cause, believed
from diagnosis.cause_search import EXPLAINED, Search, search
from diagnosis.detectability import Detectability, sight
from diagnosis.excess import Excess
from diagnosis.gain import EQUATIONS, Gain, excess_of, gains, held
from diagnosis.hypothesis import Hypothesis, as_described
from diagnosis.noise_ensemble import read
from diagnosis.signature import Signature, signature
from diagnosis.simulated_gain import Side, simulated_gains
from identification.dataset.dataset import DataSet
from identification.dataset.frames import seen_in
from identification.estimates import one_arm
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

TOO_MANY = 4
"""causes that explain alike: then the data cannot decide"""
_SURELY = 3.0
"""standard deviations by which a gain is none"""
BLIND = 0.5
"""share of the effects that recordings may not show at most, to say that there is none"""


@dataclass(frozen=True)
class Diagnosis:
    """A verdict with what it rests on."""

    verdict: str
    """consistent, cause, ambiguous, unknown or insufficient"""
    why: str
    search: Search
    sight: Detectability
    """what these recordings could have shown"""
    signature: Signature
    """where, when and against what the base model errs"""
    gains: tuple[Gain, ...]
    """on recordings that were not fitted"""
    extended: Hypothesis
    """the description with what was found in it"""
    not_simulated: str = ""
    """why, where one of both models is none that moves"""

    @property
    def before(self) -> Excess:
        """What the base model leaves where it was fitted."""
        return self.search.first.beyond

    @property
    def after(self) -> Excess:
        """What is left with the causes."""
        return self.search.last.beyond

    @property
    def causes(self) -> tuple[Cause, ...]:
        """As named, with numbers."""
        return self.search.last.causes

    @property
    def explained(self) -> float:
        """Share of what stood above noise that the causes take away."""
        return 1 - self.after.energy / self.before.energy if self.before.energy else 0.0


def diagnose(
    recordings: Sequence[DataSet],
    held_out: Sequence[DataSet] = (),
    seed: int = 0,
    progress: Callable[[str], object] = lambda step: None,
) -> Diagnosis:
    """Recordings of one arm, fitted together, and others of it on which the gain is measured.

    Raises Refused where they are of different arms, one is both fitted and held out, a motor stands still, or forces are missing.

    >>> import xneck
    >>> found = xneck.diagnose([xneck.read_dataset("monday.mcap")], [xneck.read_dataset("tuesday.mcap")])
    >>> found.verdict, [cause.effect.name for cause in found.causes]
    ('cause', ['tip_payload'])
    >>> all(gain.after < gain.before / 2 for gain in found.gains)  # on tuesday's, which nothing was fitted to
    True
    """
    for data in (*recordings, *held_out):
        if "f1" not in data.state.columns:
            raise Refused("diagnose", "a data set holds no forces f", "log the force command of every motor")
    if any(_same(one, other) for one in recordings for other in held_out):
        raise Refused("diagnose", "a recording is fitted and held out at once", "hold out another one of the same arm")
    one_arm([*recordings, *held_out])
    h = as_described(recordings[0].neck)
    progress("noise")
    fitted = [read(data, seen_in(data), seed + i) for i, data in enumerate(recordings)]
    others = [read(data, seen_in(data), seed + 100 + i) for i, data in enumerate(held_out)]
    progress("causes")
    found = search(h, fitted, seed)
    first, last = found.first, found.last
    could = sight(found)
    progress("gain")
    extended = believed(h, last.causes)
    gained: tuple[Gain, ...] = ()
    holds, not_simulated = True, ""
    if others:
        was = held(first.end, first.fit, h, others, found.whiten, bool(last.causes))
        now = held(last.end, last.fit, extended, others, found.whiten, bool(last.causes))
        gained = gains(was, now, h.arm.M)
        # causes must take from other recordings as much of what stands plainly above noise as where they were fitted
        holds = excess_of(now, now).plain_energy <= (1 - EXPLAINED) * excess_of(was, now).plain_energy
        progress("simulation")
        try:
            gained += simulated_gains(Side(first, h, was), Side(last, extended, now), others)
        except Refused as refused:  # a model that cannot be simulated is a result, not the end of the diagnosis
            not_simulated = str(refused)
    verdict, why = _verdict(found, could, gained, holds)
    worse = [g.measure for g in gained if g.after - g.before > _SURELY * g.sigma]
    if last.causes and worse and verdict != "insufficient":
        why = "; ".join(
            filter(None, [why, f"where it was not fitted the extended model does worse in {', '.join(worse)}"])
        )
    return Diagnosis(verdict, why, found, could, signature(first, last), gained, extended, not_simulated)


def _same(a: DataSet, b: DataSet) -> bool:
    return len(a.state) == len(b.state) and np.array_equal(a.state.matrix("theta"), b.state.matrix("theta"))


def _verdict(found: Search, could: Detectability, gained: Sequence[Gain], holds: bool) -> tuple[str, str]:
    """holds: whether causes explain the recordings that were not fitted too, if there are any."""
    if not found.named:
        if found.first.beyond.plain:
            return "unknown", "the data differ from the model, and no cause that is known explains it"
        if len(could.blind) > BLIND * len(could.effects):
            return "insufficient", f"these recordings could not show {', '.join(could.blind)}"
        return "consistent", "nothing stands above noise"
    if not holds:
        worst = max(g.after / g.noise_floor for g in gained if g.measure in EQUATIONS)
        why = f"what explains the fitted recordings leaves {worst:.1f} times noise on those that were not fitted"
        return "insufficient", why
    if max(len(named.tied) for named in found.named) >= TOO_MANY:
        return "insufficient", "too many causes explain the data alike"
    if any(len(named.tied) > 1 for named in found.named):
        return "ambiguous", "several causes explain the data alike"
    return "cause", ""
