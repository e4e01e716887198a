"""Estimates that hold: the laws of an arm from recordings of it, each number with its uncertainty and whether to believe it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset import DataSet
from identification.fitting import FitSolution, fit_laws
from identification.identifiability import Identifiability, durbin_wu_hausman, judge_identifiability, term_label
from identification.signals import Signals, signals_of
from identification.unknowns import Unknowns, unknowns
from mechanism.arm import Arm
from mechanism.elasticity import ElasticModel
from mechanism.laws import Turning
from mechanism.machine import Machine
from xneck_foundation.errors import Refused
from xneck_foundation.parameter import Parameter

Array = NDArray[np.float64]

LAWS_BY_ELASTIC_MODEL: dict[ElasticModel, tuple[str, ...]] = {
    1: ("dry_friction", "viscous_friction", "linear_cable"),
    2: ("dry_friction", "viscous_friction", "youngs_modulus"),
    3: ("dry_friction", "viscous_friction", "youngs_modulus_in_pose"),
}
"""what is fitted beside each of Fasquelle's elastic models"""
DEFAULT_LAWS = LAWS_BY_ELASTIC_MODEL[1]
_MOVES = 1.0
"""rad/s: a motor slower than this all the time is at rest"""
_OPPOSED = 5.0
"""sigmas by which a negative friction says that signs are wrong"""
_PUSHES_N, _NEARLY_ALL = 1.0, 0.95
"""a slack cable shows a force around zero for part of the time: one that pushes by more, in this share of rows, is none"""
_CHANCE = 0.05
"""below this probability least squares is said to be biased"""


@dataclass(frozen=True)
class Estimates:
    """What was fitted to which recordings."""

    laws: tuple[str, ...]
    unknowns: Unknowns
    solution: FitSolution
    verdicts: tuple[Identifiability, ...]
    x0: Array
    """pre-elongations of the description, (M,), m"""
    seconds: tuple[float, ...]
    """used of each recording"""

    @property
    def sigma(self) -> Array:
        """(P,)"""
        return np.sqrt(np.diag(self.solution.covariance))

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Of the laws; and x0 of the cables, whole, where all comes from one recording."""
        return tuple(p for p, _ in self.judged)

    @property
    def judged(self) -> tuple[tuple[Parameter, Identifiability], ...]:
        """`parameters` with what is to be said of each."""
        return tuple((self._parameter(place), self.verdicts[place]) for place in self._told)

    @property
    def covariance(self) -> Array:
        """Of `parameters`, (P', P')."""
        place = self._told
        return self.solution.covariance[np.ix_(place, place)]

    @property
    def _told(self) -> list[int]:
        """Places of the parameters that are spoken of."""
        one = len(self.seconds) == 1
        entries = enumerate(self.unknowns.entries)
        return [i for i, e in entries if e.recording is None or (one and e.term.name == "x0")]

    def _parameter(self, place: int) -> Parameter:
        e, value = self.unknowns.entries[place], float(self.solution.p[place])
        if e.term.name == "x0" and e.index is not None:
            value += float(self.x0[e.index - 1])
        sigma = float(self.sigma[place]) or float("inf")
        return Parameter(e.term.name, e.index, value, e.term.unit, sigma, self.verdicts[place].identified)

    def values(self, name: str) -> Array:
        """Of a term, in the order of cables or joints, fitted or held."""
        return self.unknowns.get(self.solution.p, name)

    def rms(self) -> tuple[Array, Array]:
        """What is left of the motor equations (M,), N, and of the arm's (N,), N m."""
        every = np.concatenate(self.solution.residuals, axis=1)
        out = np.sqrt(np.mean(every**2, axis=1))
        return out[: len(self.x0)], out[len(self.x0) :]

    def as_json(self) -> dict[str, Any]:
        """The contract's parameters, and the fit behind them."""
        u, p, sigma = self.unknowns, self.solution.p, self.sigma
        statistic, chance = durbin_wu_hausman(self.solution)
        motor, arm = self.rms()
        recordings = [
            {"seconds": seconds}
            | {
                e.term.name + ("" if e.index is None else str(e.index)): [float(p[i]), float(sigma[i])]
                for i, e in enumerate(u.entries)
                if e.recording == r
            }
            for r, seconds in enumerate(self.seconds)
        ]
        return {
            "parameters": [found.as_json() | _words(verdict) for found, verdict in self.judged],
            "fit": {
                "laws": list(self.laws),
                "method": "instrumental variables at the log's rate",
                "blocks": self.solution.blocks,
                "rms_motor_N": motor.tolist(),
                "rms_arm_Nm": arm.tolist(),
                "least_squares": [
                    {"name": term_label(e), "value": float(v), "sigma": float(s)}
                    for e, v, s in zip(
                        u.entries,
                        self.solution.least_squares,
                        np.sqrt(np.diag(self.solution.least_squares_covariance)),
                        strict=True,
                    )
                    if e.recording is None
                ],
                "durbin_wu_hausman": {
                    "statistic": statistic,
                    "probability": chance,
                    "least_squares_biased": chance < _CHANCE,
                },
                "recordings": recordings,
                "recordings_unit": "value and sigma, m and s; x0 beyond the description's",
            },
        }


def _words(v: Identifiability) -> dict[str, str]:
    return {} if v.identified else {"why": v.why, "would_tell": v.record}


def estimate(
    recordings: Sequence[DataSet],
    laws: Sequence[str] = DEFAULT_LAWS,
    held: Mapping[str, float | Array] | None = None,
    priors: Mapping[tuple[str, int | None], tuple[float, float]] | None = None,
) -> Estimates:
    """Laws (names of mechanism.laws) fitted to recordings of one arm together; x0 and delay are each recording's own.

    held: terms, x0 or delay that keep a value. priors: mean and sigma by term and index. Raises Refused where recordings are
    of different arms, a motor stands still, forces and motor angles are counted in opposite senses, or nothing can be told.

    >>> import xneck
    >>> found = xneck.identify([xneck.read_dataset("monday.mcap")])
    >>> (found.values("k") / 1e3).round(1)  # kN/m, one a cable
    array([10. ,  9. ,  8. ,  5.5])
    >>> {p.name for p in found.parameters if not p.identified}
    {'fv'}
    """
    arm = common_arm(recordings)
    signals = [signals_of(data) for data in recordings]
    check_motion(signals)
    u = unknowns(arm, laws, len(signals), held)
    places = {(e.term.name, e.index): i for i, e in enumerate(u.entries) if e.recording is None}
    known: dict[int, tuple[float, float]] = {}
    for key, prior in (priors or {}).items():
        if key not in places:
            raise Refused(
                "identify", f"no parameter {key[0]}({key[1]}) for a prior", "give one of a law that is fitted"
            )
        known[places[key]] = prior
    found = fit_laws(signals, u, known)
    _check_signs(u, found)
    _check_pull(signals, u, found)
    verdicts = judge_identifiability(u, found)
    if not any(v.identified for v, e in zip(verdicts, u.entries, strict=True) if e.recording is None):
        raise Refused("identify", "insufficient: this motion tells none of the parameters", "move more, for longer")
    seconds = tuple(s.step * s.low_pass.factor * len(s.low_pass.kept) for s in signals)
    return Estimates(tuple(laws), u, found, verdicts, arm.x0, seconds)


def common_arm(recordings: Sequence[DataSet]) -> Arm:
    """The arm of all recordings. Raises Refused where they differ in more than markers and where the motors started."""

    def of(data: DataSet) -> dict[str, Any]:
        described = data.neck.model_dump(exclude={"markers"})
        for cable in described["cables"]:
            cable.pop("x0")
        return described

    if any(of(other) != of(recordings[0]) for other in recordings[1:]):
        raise Refused("identify", "the recordings are of different arms", "give recordings made with one neck.yaml")
    return recordings[0].arm


def check_motion(signals: Sequence[Signals]) -> None:
    """Refused where a motor stands still in all recordings."""
    still = np.max([np.abs(s.theta_d).max(axis=0) for s in signals], axis=0) < _MOVES
    if still.any():
        names = ", ".join(str(j + 1) for j in np.flatnonzero(still))
        raise Refused(
            "identify",
            f"insufficient: motor {names} hardly moves (under {_MOVES:g} rad/s)",
            "record a motion of every motor",
        )


def _check_signs(u: Unknowns, found: FitSolution) -> None:
    """Refused where friction drives: the force is counted against the motor's turning."""
    slot = u.slots.get(("fs", None))
    if slot is None:
        return
    value, sigma = found.p[slot], np.sqrt(np.diag(found.covariance))[slot]
    wrong = value < -_OPPOSED * np.maximum(sigma, 1e-3)
    if wrong.any():
        names = ", ".join(str(j + 1) for j in np.flatnonzero(wrong))
        raise Refused(
            "identify",
            f"the signs of f and theta of motor {names} are opposed: its friction would drive it",
            "turn one of them, theta_sign or the force's sign of that motor in neck.yaml",
        )


def _check_pull(signals: Sequence[Signals], u: Unknowns, found: FitSolution) -> None:
    """Refused where a motor pushes on its cable nearly all the time: turned in both f and theta, friction looks right."""
    values = u.values(found.p)
    at_rows = []
    for s in signals:
        rub = Machine(s.arm, u.laws, values).friction(Turning(s.theta_d, np.zeros_like(s.theta_d), s.wrap))
        at_rows.append((s.f - s.inertial - rub)[s.low_pass.kept])
    tension = np.concatenate(at_rows)
    wrong = np.mean(tension < -_PUSHES_N, axis=0) > _NEARLY_ALL
    if wrong.any():
        names = ", ".join(str(j + 1) for j in np.flatnonzero(wrong))
        raise Refused(
            "identify",
            f"the signs of both f and theta of motor {names} are turned: it would push on its cable "
            f"({float(tension[:, wrong].mean()):.0f} N)",
            "turn both, theta_sign and f_scale of that motor in neck.yaml",
        )
