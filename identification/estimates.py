"""The laws of an arm estimated from recordings of it: each parameter with its uncertainty, and whether it is identified."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset import DataSet
from identification.fitting import FitSolution, fit_by_least_squares, fit_laws
from identification.identifiability import Identifiability, durbin_wu_hausman, judge_identifiability, term_label
from identification.model_file import Model, model_of
from identification.motor_speeds import with_motor_speeds
from identification.recorded_check import inconsistency, recorded_check
from identification.residuals import mean_friction
from identification.signals import Signals, signals_of
from identification.unknowns import Unknowns, terms_of, unknowns
from mechanism.arm import Arm
from mechanism.dynamics import terms
from mechanism.elasticity import ElasticModel
from mechanism.machine import Machine
from xneck_foundation.errors import Refused
from xneck_foundation.one_blas_thread import one_blas_thread
from xneck_foundation.parameter import Parameter
from xneck_foundation.provenance import versions

Array = NDArray[np.float64]

LAWS_BY_ELASTIC_MODEL: dict[ElasticModel, tuple[str, ...]] = {
    1: ("dry_friction", "viscous_friction", "linear_cable"),
    2: ("dry_friction", "viscous_friction", "youngs_modulus"),
    3: ("dry_friction", "viscous_friction", "youngs_modulus_in_pose"),
}
"""laws that are fitted with each of Fasquelle's elastic models"""
DEFAULT_LAWS = LAWS_BY_ELASTIC_MODEL[1]
BENDING_FRICTION = "presliding_friction"
"""law that is fitted too where forces and motion do not fit without it: motors' friction bends before it slides, more or less"""
MAX_BENDING_SHARE, MAX_UNBENT_SHARE = 0.5, 0.1
"""of what is left of each motor's equation without that law, and of the motor's dry friction: what it may leave and be kept
(docs/thresholds.md)"""
MIN_MOTOR_SPEED_RAD_S = 1.0
"""rad/s: a motor that is slower all the time is at rest, and the recordings are refused (docs/thresholds.md)"""
_OPPOSED_SIGMAS = 5.0
"""sigmas by which friction is below zero where signs are said to be opposed (docs/thresholds.md)"""
PUSH_N, PUSH_SHARE = 1.0, 0.95
"""N, and share of rows: a motor that pushes on its cable by more, in more of the rows, is turned; a slack cable shows about zero
(docs/thresholds.md)"""
_OPEN_NOISE_RATIO = 10.0
"""times the noise of the torque that the arm's motion needs: where more is left, equations do not close (docs/thresholds.md)"""
MIN_UNBIASED_PROBABILITY = 0.05
"""of the Durbin-Wu-Hausman test: below it least squares is said to be biased (docs/thresholds.md)"""


@dataclass(frozen=True)
class Estimates:
    """Laws fitted to recordings of one arm."""

    laws: tuple[str, ...]
    unknowns: Unknowns
    solution: FitSolution
    identifiability: tuple[Identifiability, ...]
    """of each entry of the parameter vector"""
    x0: Array
    """pre-elongations of the description, (M,), m"""
    seconds: tuple[float, ...]
    """s of each recording that are used"""
    checks: tuple[Mapping[str, Any], ...]
    """what the check found of each recording (recorded_check.py)"""

    @property
    def tells_any(self) -> bool:
        """Whether any number of the laws is identified."""
        entries = zip(self.identifiability, self.unknowns.entries, strict=True)
        return any(verdict.identified for verdict, e in entries if e.recording is None)

    @property
    def sigma(self) -> Array:
        """Standard deviations of the parameter vector, (P,)."""
        return np.sqrt(np.diag(self.solution.covariance))

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the laws; and the whole x0 of the cables where there is one recording."""
        return tuple(p for p, _ in self.with_identifiability)

    @property
    def with_identifiability(self) -> tuple[tuple[Parameter, Identifiability], ...]:
        """`parameters`, each with whether it is identified."""
        return tuple((self._parameter(place), self.identifiability[place]) for place in self._reported)

    @property
    def model(self) -> Model:
        """The model with these numbers, as `xneck identify` writes it, and those that were held."""
        terms = {term.name for term in terms_of(self.laws)}
        held = {name: value for name, value in self.unknowns.held.items() if name in terms}
        return model_of(self.parameters, self.laws, versions(), self.covariance, held)

    @property
    def covariance(self) -> Array:
        """Covariance of `parameters`, (P', P')."""
        place = self._reported
        return self.solution.covariance[np.ix_(place, place)]

    @property
    def _reported(self) -> list[int]:
        """Places in the parameter vector of the parameters that are reported."""
        one_recording = len(self.seconds) == 1
        entries = enumerate(self.unknowns.entries)
        return [i for i, e in entries if e.recording is None or (one_recording and e.term.name == "x0")]

    def _parameter(self, place: int) -> Parameter:
        e, value = self.unknowns.entries[place], float(self.solution.p[place])
        if e.term.name == "x0" and e.index is not None:
            value += float(self.x0[e.index - 1])
        sigma = float(self.sigma[place]) or float("inf")
        return Parameter(
            name=e.term.name,
            index=e.index,
            value=value,
            unit=e.term.unit,
            sigma=sigma,
            identified=self.identifiability[place].identified,
        )

    def values(self, name: str) -> Array:
        """Values of a term, in the order of cables or joints, fitted or held."""
        return self.unknowns.get(self.solution.p, name)

    def rms(self) -> tuple[Array, Array]:
        """RMS residual of the motor equations (M,), N, and of the arm's (N,), N m."""
        residuals = np.concatenate(self.solution.residuals, axis=1)
        out = np.sqrt(np.mean(residuals**2, axis=1))
        return out[: len(self.x0)], out[len(self.x0) :]

    def as_json(self) -> dict[str, Any]:
        """The contract's parameters, and the fit behind them."""
        u, p, sigma = self.unknowns, self.solution.p, self.sigma
        statistic, probability = durbin_wu_hausman(self.solution)
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
            "parameters": [p.as_json() | _reasons(verdict) for p, verdict in self.with_identifiability],
            "checks": list(self.checks),
            "fit": {
                "laws": list(self.laws),
                "method": f"{'least squares' if self.solution.is_least_squares else 'instrumental variables'} at the log's rate",
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
                    "probability": probability,
                    "least_squares_biased": probability < MIN_UNBIASED_PROBABILITY,
                },
                "recordings": recordings,
                "recordings_unit": "value and sigma, m and s; x0 beyond the description's",
            },
        }


def _reasons(v: Identifiability) -> dict[str, str]:
    return {} if v.identified else {"why": v.why, "would_tell": v.record}


@one_blas_thread
def estimate(
    recordings: Sequence[DataSet],
    laws: Sequence[str] = DEFAULT_LAWS,
    held: Mapping[str, float | Array] | None = None,
    priors: Mapping[tuple[str, int | None], tuple[float, float]] | None = None,
) -> Estimates:
    """Laws (names of mechanism.laws) fitted to all recordings of one arm together; x0 and delay to each recording alone.

    held: terms, x0 or delay that keep a value. priors: mean and sigma by term and index. Where forces and motion do not fit by
    these laws, BENDING_FRICTION is fitted too, and `laws` of what comes back has it. Raises Refused where recordings are
    of different arms, a motor stands still, forces and motor angles are counted in opposite senses, or nothing is identified.

    >>> import xneck
    >>> found = xneck.identify([xneck.read_dataset("monday.mcap")])
    >>> (found.values("k") / 1e3).round(1)  # kN/m, one a cable
    array([10. ,  9. ,  8. ,  5.5])
    >>> {p.name for p in found.parameters if not p.identified}
    {'fv'}
    >>> found.model.laws  # a model, as `read_model` gives it
    ('dry_friction', 'viscous_friction', 'linear_cable')
    """
    held, priors = held or {}, priors or {}
    found = _estimate(recordings, laws, held, priors)
    is_open = _open_joint(recordings, found.solution)
    if is_open and "dry_friction" in laws and BENDING_FRICTION not in laws:
        with suppress(Refused):
            bent = _estimate(recordings, (*laws, BENDING_FRICTION), held, priors)
            most = np.minimum(MAX_BENDING_SHARE * found.rms()[0], MAX_UNBENT_SHARE * bent.values("fs"))
            if bent.tells_any and np.all(bent.rms()[0] < most):
                return bent
    if not found.tells_any:
        if is_open:
            raise _not_closed(*is_open)
        raise Refused("identify", "insufficient: this motion tells none of the parameters", "move more, for longer")
    return found


def _estimate(
    recordings: Sequence[DataSet],
    laws: Sequence[str],
    held: Mapping[str, float | Array],
    priors: Mapping[tuple[str, int | None], tuple[float, float]],
) -> Estimates:
    """As `estimate`, of these laws alone, whatever they tell."""
    arm = common_arm(recordings)
    signals = [signals_of(data) for data in recordings]
    check_motion(signals)
    u = unknowns(arm, laws, len(signals), held)
    places = {(e.term.name, e.index): i for i, e in enumerate(u.entries) if e.recording is None}
    prior_at: dict[int, tuple[float, float]] = {}
    for key, prior in priors.items():
        if key not in places:
            raise Refused(
                "identify", f"no parameter {key[0]}({key[1]}) for a prior", "give one of a law that is fitted"
            )
        prior_at[places[key]] = prior
    first = fit_by_least_squares(signals, u, prior_at)
    machine = Machine(arm, u.laws, u.values(first))
    signals = [
        signals_of(with_motor_speeds(data, machine, float(u.get(first, "delay", r)[0])))
        for r, data in enumerate(recordings)
    ]
    solution = fit_laws(signals, u, prior_at, first)
    _check_signs(u, solution)
    _check_tension(signals, u, solution)
    identifiability = judge_identifiability(u, solution)
    seconds = tuple(s.step * s.low_pass.factor * len(s.low_pass.kept) for s in signals)
    return Estimates(
        laws=tuple(laws),
        unknowns=u,
        solution=solution,
        identifiability=identifiability,
        x0=arm.x0,
        seconds=seconds,
        checks=tuple(recorded_check(data) for data in recordings),
    )


def _not_closed(data: DataSet, joint: int, left: float, noise: float) -> Refused:
    """The refusal of what `_open_joint` found: another motion would not tell its parameters."""
    found = inconsistency(recorded_check(data))
    return Refused(
        "identify",
        f"forces and motion do not fit: of the torque at joint {joint + 1} {left:.2g} N m are left (rms), where "
        f"noise makes {noise:.2g}",
        "are unit, order, signs and time of f right, and the zero of the angles?"
        + (f" check: {found}" if found else ""),
    )


def _open_joint(recordings: Sequence[DataSet], solution: FitSolution) -> tuple[DataSet, int, float, float] | None:
    """The first recording of whose arm's equations far more than noise is left, the worst joint, what is left there (rms), and what
    noise makes, N m; None where there is none."""
    for data, residuals in zip(recordings, solution.residuals, strict=True):
        alpha, sigma = data.state.matrix("alpha"), data.state.matrix("sigma_alpha", "_dd")
        if sigma.shape != alpha.shape:
            continue
        inertia = terms(data.arm, alpha, data.state.matrix("alpha", "_d")).M
        noise = np.sqrt(np.mean(np.einsum("tij,tj->ti", inertia**2, sigma**2), axis=0))
        left = np.sqrt(np.mean(residuals[-data.arm.N :] ** 2, axis=1))
        worst = int(np.argmax(left / noise))
        if left[worst] > _OPEN_NOISE_RATIO * noise[worst]:
            return data, worst, float(left[worst]), float(noise[worst])
    return None


def common_arm(recordings: Sequence[DataSet]) -> Arm:
    """The arm of all recordings. Raises Refused where they differ in more than markers and where the motors started."""

    def description(data: DataSet) -> dict[str, Any]:
        described = data.neck.model_dump(exclude={"markers"})
        for cable in described["cables"]:
            cable.pop("x0")
        return described

    if any(description(other) != description(recordings[0]) for other in recordings[1:]):
        raise Refused("identify", "the recordings are of different arms", "give recordings made with one neck.yaml")
    return recordings[0].arm


def check_motion(signals: Sequence[Signals]) -> None:
    """Raises Refused where a motor stands still in all recordings."""
    still = np.max([np.abs(s.theta_d).max(axis=0) for s in signals], axis=0) < MIN_MOTOR_SPEED_RAD_S
    if still.any():
        names = ", ".join(str(j + 1) for j in np.flatnonzero(still))
        raise Refused(
            "identify",
            f"insufficient: motor {names} hardly moves (under {MIN_MOTOR_SPEED_RAD_S:g} rad/s)",
            "record a motion of every motor",
        )


def _check_signs(u: Unknowns, solution: FitSolution) -> None:
    """Raises Refused where friction would drive a motor: its force is counted against its angle."""
    slot = u.slots.get(("fs", None))
    if slot is None:
        return
    value, sigma = solution.p[slot], np.sqrt(np.diag(solution.covariance))[slot]
    wrong = value < -_OPPOSED_SIGMAS * np.maximum(sigma, 1e-3)
    if wrong.any():
        names = ", ".join(str(j + 1) for j in np.flatnonzero(wrong))
        raise Refused(
            "identify",
            f"the signs of f and theta of motor {names} are opposed: its friction would drive it",
            "turn one of them, theta_sign or the force's sign of that motor in neck.yaml",
        )


def _check_tension(signals: Sequence[Signals], u: Unknowns, solution: FitSolution) -> None:
    """Raises Refused where a motor pushes on its cable nearly all the time: with both f and theta turned, friction looks right."""
    values = u.values(solution.p)
    tensions = []
    for s in signals:
        friction = mean_friction(s, Machine(s.arm, u.laws, values), np.zeros_like(s.theta_d))
        tensions.append((s.f - s.inertial - friction)[s.low_pass.kept])
    tension = np.concatenate(tensions)
    wrong = np.mean(tension < -PUSH_N, axis=0) > PUSH_SHARE
    if wrong.any():
        names = ", ".join(str(j + 1) for j in np.flatnonzero(wrong))
        raise Refused(
            "identify",
            f"the signs of both f and theta of motor {names} are turned: it would push on its cable "
            f"({float(tension[:, wrong].mean()):.0f} N)",
            "turn both, theta_sign and f_scale of that motor in neck.yaml",
        )
