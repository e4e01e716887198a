"""A hypothesis of an arm, its laws, and how it was recorded: the one that causes are added to."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from diagnosis.held_at_rest import NOTHING_HELD, HeldShares
from identification.dataset.dataset import DataSet
from identification.dataset.series import Series
from mechanism.arm import Arm, arm_of
from mechanism.description import Neck
from mechanism.laws import law_named

Array = NDArray[np.float64]

BASE_LAWS = ("dry_friction", "linear_cable")
"""the laws of the simulation that is put to the test"""


@dataclass(frozen=True)
class Hypothesis:
    """A description, laws beyond the base with their numbers, and errors of what was read."""

    neck: Neck
    laws: tuple[str, ...]
    values: Mapping[str, Array]
    """of these laws' terms, by name: (M,), (N,) or (1,)"""
    angle_error: Array
    """(N,), rad, by which joint angles were read too large"""
    frame_lag: float = 0.0
    """s, by which frames show what was done later than their stamps say"""
    motor_angle_lag: float = 0.0
    """s, by which a row's motor angles are older than its forces; frames were put on the clock by the angles"""
    departures: tuple[float, ...] = ()
    """tolerances by which numbers that have one already are where recordings put them, as `Nuisances` has them; none unless said"""
    held: HeldShares = NOTHING_HELD
    """what is seen of dry friction that holds motors and joints at rest otherwise than the laws say"""
    forces_as_drums: bool = False
    """whether a drum that is off takes the log's forces with it: they are torques over the described drums"""

    @property
    def arm(self) -> Arm:
        """The description's numbers."""
        return arm_of(self.neck)

    @property
    def reading(self) -> tuple[object, ...]:
        """All that `corrected` depends on."""
        return (self.neck, self.frame_lag, self.motor_angle_lag, *self.angle_error.tolist())

    def with_forces_as_drums(self) -> "Hypothesis":
        """The same where a drum that is off takes the log's forces with it."""
        return replace(self, forces_as_drums=True)

    def with_law(self, name: str, values: Mapping[str, Array]) -> "Hypothesis":
        """The same with a law's numbers set."""
        laws = self.laws if name in self.laws else (*self.laws, name)
        return replace(self, laws=laws, values={**self.values, **values})

    def corrected(self, data: DataSet, frame_lag: float = 0.0) -> DataSet:
        """A recording with the errors of its reading put right; frame_lag: of its own clock, s, beyond the hypothesis's."""
        s, columns = data.state, dict(data.state.columns)
        joints = range(1, len(self.angle_error) + 1)
        seen = [f"{name}{i}{suffix}" for name in ("alpha", "vision") for i in joints for suffix in ("", "_d", "_dd")]
        seen = [key for key in seen if key in columns]
        if lag := self.frame_lag + frame_lag:
            advanced = _advanced(s.time, np.stack([columns[key] for key in seen]).T, lag)
            columns |= dict(zip(seen, advanced.T, strict=True))
        for i, error in enumerate(self.angle_error, start=1):
            columns |= {key: columns[key] - error for key in (f"alpha{i}", f"vision{i}") if key in columns}
        if self.motor_angle_lag:
            for key in (key for key in s.columns if key[0] == "f" and key[1:].isdigit()):
                columns[key] = np.interp(s.time - self.motor_angle_lag, s.time, s.columns[key])
        frames = dict(data.angles.columns)
        for i, error in enumerate(self.angle_error, start=1):
            if f"alpha{i}" in frames:
                frames[f"alpha{i}"] = frames[f"alpha{i}"] - error
        clock = dict(data.clock)
        if "offset_s" in clock:
            clock["offset_s"] = float(clock["offset_s"]) - self.frame_lag - frame_lag
        angles = Series(data.angles.time, frames)
        return replace(data, neck=self.neck, state=Series(s.time, columns), angles=angles, clock=clock)


def _advanced(time: Array, values: Array, lag: float) -> Array:
    """Values (T, K) as they are `lag` s later, at each row; beyond the ends the last ones stay."""
    return make_interp_spline(time, values, k=3)(np.clip(time + lag, time[0], time[-1]))


def as_described(neck: Neck) -> Hypothesis:
    """Nothing beyond the base model."""
    return Hypothesis(neck, (), {}, np.zeros(neck.N))


def inactive_values(arm: Arm, law: str) -> dict[str, Array]:
    """Values at which a law does nothing: amounts zero, shapes at their size; without terms that base laws share with it."""
    terms = [term for term in law_named(law).terms if term.name not in base_terms()]
    return {t.name: np.full(t.count(arm), t.size if t.low > 0 else 0.0) for t in terms}


def base_terms() -> set[str]:
    return {term.name for name in BASE_LAWS for term in law_named(name).terms}
