"""Friction and elasticity as Fasquelle identifies them: linear least squares on the arm and motor equations.

    motor   k x + ca x' + dry(theta') fs = f - Ia (R/rd) theta''                         (56)
    arm     Z dry(theta') fs [+ Z theta' fv] = Z (f - Ia (R/rd) theta'') - M alpha'' - c - g      (51)

stacked with the arm equations weighted by W = 100 (61). Friction alone is identified from the arm equations: Fasquelle
prints (62), (63), which are motor equations without the tension, but the sigmas of its table 1 are in the ratio sqrt(3)
between cables 1-3 and 4 that only the columns of Z give.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset import DataSet
from identification.dataset.series import Series
from mechanism.arm import Arm
from mechanism.cable_lengths import Z
from mechanism.dynamics import terms
from mechanism.elasticity import ELASTIC_MODELS, ElasticModel, strain_scale
from mechanism.friction import dry
from xneck_foundation.errors import Refused
from xneck_foundation.least_squares import Estimate, linear_least_squares
from xneck_foundation.one_blas_thread import one_blas_thread
from xneck_foundation.parameter import Parameter

Array = NDArray[np.float64]

ARM_EQUATION_WEIGHT = 100.0
"""1/m, W of (60), (61): scales the arm equations (N m) to the motor equations (N)"""
MAX_RELATIVE_SIGMA_PERCENT = 10.0
"""%: a parameter with a larger relative sigma counts as not identified, as in Fasquelle's tables (docs/thresholds.md)"""


@dataclass(frozen=True)
class FasquelleRegressors:
    """Terms of both equations at S samples, of all recordings together."""

    Z: Array
    """(S, N, M), m"""
    dry: Array
    """(S, M)"""
    theta_d: Array
    """(S, M), rad/s"""
    x: Array
    """(S, M), m"""
    x_d: Array
    """(S, M), m/s"""
    pull: Array
    """f - Ia (R/rd) theta'': what friction and tension share, (S, M), N"""
    arm_load: Array
    """M alpha'' + c + g, (S, N), N m"""
    strain: dict[ElasticModel, Array]
    """x and x' are multiplied by it in each elastic model, (S, M)"""


@dataclass(frozen=True)
class FasquelleFit:
    """A table of Fasquelle: parameters, the estimate behind them, and what was fitted."""

    title: str
    parameters: tuple[Parameter, ...]
    estimate: Estimate

    def values(self, name: str) -> Array:
        """Values of the parameters of a name, in the order of their cables."""
        return np.array([p.value for p in self.parameters if p.name == name])


@dataclass(frozen=True)
class FasquelleIdentification:
    """All tables of Fasquelle's method for one arm."""

    dry_only: FasquelleFit
    dry_and_viscous: FasquelleFit
    elastic: dict[ElasticModel, FasquelleFit]
    tension_from_force: Array
    """f - friction - Ia (R/rd) theta'' with the friction identified alone, (S, M), N"""
    tension_error: dict[ElasticModel, Array]
    """tension of each elastic model less that from the forces, (S, M), N"""

    def mean_error(self, model: ElasticModel) -> float:
        """Fasquelle's mean tension reconstruction error, N."""
        return float(np.mean(np.abs(self.tension_error[model])))


@one_blas_thread
def fasquelle_identification(recordings: Sequence[DataSet]) -> FasquelleIdentification:
    """Tables 1 and 2 for recordings of one arm. Raises Refused where the recordings are of different arms or at rest."""
    first = recordings[0]
    for other in recordings[1:]:
        if other.neck.model_dump(exclude={"markers"}) != first.neck.model_dump(exclude={"markers"}):
            raise Refused("identify", "the recordings are of different arms", "give recordings made with one neck.yaml")
    arm = first.arm
    if not all("f1" in data.fasquelle.columns for data in recordings):
        raise Refused("identify", "the log holds no forces f", "log the force command of every motor")
    parts = [fasquelle_regressors(arm, data.fasquelle) for data in recordings]
    names = ("Z", "dry", "theta_d", "x", "x_d", "pull", "arm_load")
    r = FasquelleRegressors(
        **{name: np.concatenate([getattr(p, name) for p in parts]) for name in names},
        strain={m: np.concatenate([p.strain[m] for p in parts]) for m in ELASTIC_MODELS},
    )
    at_rest = np.max(np.abs(r.theta_d), axis=0) < 1.0
    if np.any(at_rest):
        names = ", ".join(str(j + 1) for j in np.flatnonzero(at_rest))
        raise Refused("identify", f"motor {names} hardly moves (under 1 rad/s)", "record a motion of every motor")
    dry_only, viscous = friction_alone(r, viscous=False), friction_alone(r, viscous=True)
    from_force = r.pull - r.dry * dry_only.values("fs")
    elastic = {model: elastic_system(r, model) for model in ELASTIC_MODELS}
    errors = {model: elastic_tension(r, model, fit) - from_force for model, fit in elastic.items()}
    return FasquelleIdentification(dry_only, viscous, elastic, from_force, errors)


def fasquelle_regressors(arm: Arm, series: Series) -> FasquelleRegressors:
    """The terms of (51) and (56) from a series with alpha, theta and their derivatives, f, x and x_d."""
    alpha, theta_d = series.matrix("alpha"), series.matrix("theta", "_d")
    jacobian = Z(arm, alpha)
    k = terms(arm, alpha, series.matrix("alpha", "_d"))
    load = np.einsum("sij,sj->si", k.M, series.matrix("alpha", "_dd")) + k.c + k.g
    pull = series.matrix("f") - arm.motor_inertia / arm.drum * series.matrix("theta", "_dd")
    shape = theta_d.shape
    strain = {m: np.broadcast_to(strain_scale(arm, alpha, m), shape) for m in ELASTIC_MODELS}
    return FasquelleRegressors(
        Z=jacobian,
        dry=dry(theta_d),
        theta_d=theta_d,
        x=series.matrix("x"),
        x_d=series.matrix("x", "_d"),
        pull=pull,
        arm_load=load,
        strain=strain,
    )


def friction_alone(r: FasquelleRegressors, viscous: bool) -> FasquelleFit:
    """Table 1: fs, and fv if `viscous`, from the arm equations (51)."""
    columns = [_per_cable_on_arm(r, r.dry)]
    names = [("fs", "N")]
    if viscous:
        columns.append(_per_cable_on_arm(r, r.theta_d))
        names.append(("fv", "N s/rad"))
    estimate = linear_least_squares(np.concatenate(columns, axis=1), _arm_side(r))
    cables = r.dry.shape[1]
    labels = [(name, j + 1, unit) for name, unit in names for j in range(cables)]
    return FasquelleFit(
        "Dry and viscous friction" if viscous else "Dry friction only", _parameters(labels, estimate), estimate
    )


def elastic_system(r: FasquelleRegressors, model: ElasticModel) -> FasquelleFit:
    """Table 2: stiffness, damping and fs together from (61); k, ca of each cable (model 1), or E, c of all (models 2, 3)."""
    samples, cables = r.dry.shape
    n = r.Z.shape[1]
    eye = np.eye(cables)
    scale = r.strain[model]

    def on_motors(values: Array) -> Array:
        """One column a cable, or one for all cables where a single parameter serves them."""
        spread = (values[:, :, None] * eye).reshape(samples * cables, cables)
        return spread if model == 1 else spread.sum(axis=1, keepdims=True)

    elastic = np.concatenate([on_motors(scale * r.x), on_motors(scale * r.x_d)], axis=1)
    above = np.concatenate([elastic, (r.dry[:, :, None] * eye).reshape(samples * cables, cables)], axis=1)
    below = np.concatenate([np.zeros((samples * n, elastic.shape[1])), _per_cable_on_arm(r, r.dry)], axis=1)
    D = np.concatenate([above, ARM_EQUATION_WEIGHT * below])
    y = np.concatenate([r.pull.ravel(), ARM_EQUATION_WEIGHT * _arm_side(r)])
    if model == 1:
        labels = [(name, j + 1, unit) for name, unit in (("k", "N/m"), ("ca", "N s/m")) for j in range(cables)]
    else:
        labels = [("E", None, "Pa"), ("c", None, "Pa s")]
    labels += [("fs", j + 1, "N") for j in range(cables)]
    estimate = linear_least_squares(D, y)
    return FasquelleFit(f"Elastic model {model}", _parameters(labels, estimate), estimate)


def _arm_side(r: FasquelleRegressors) -> Array:
    """Right side of (51), shape (S N,), N m."""
    return (np.einsum("sij,sj->si", r.Z, r.pull) - r.arm_load).ravel()


def _per_cable_on_arm(r: FasquelleRegressors, values: Array) -> Array:
    """Columns Z(:, j) values_j of the arm equations, shape (S N, M); values (S, M)."""
    return (r.Z * values[:, None, :]).reshape(-1, values.shape[1])


def elastic_tension(r: FasquelleRegressors, model: ElasticModel, fit: FasquelleFit) -> Array:
    """Tension of an elastic model with identified parameters (53), (57), shape (S, M), N."""
    stiffness, damping = ("k", "ca") if model == 1 else ("E", "c")
    return r.strain[model] * (fit.values(stiffness) * r.x + fit.values(damping) * r.x_d)


def _parameters(labels: Sequence[tuple[str, int | None, str]], e: Estimate) -> tuple[Parameter, ...]:
    parameters = []
    for (name, index, unit), value, sigma in zip(labels, e.value, e.sigma, strict=True):
        identified = bool(100 * sigma <= MAX_RELATIVE_SIGMA_PERCENT * abs(value) and value != 0)
        parameters.append(
            Parameter(name=name, index=index, value=float(value), unit=unit, sigma=float(sigma), identified=identified)
        )
    return tuple(parameters)
