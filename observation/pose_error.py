"""How uncertain the pose is to which the model's cables pull the arm, over all poses: from the covariance of the model's numbers.

A small change of the numbers moves each angle by the arm's compliance times the change of its torque, in a pose at rest. Over the
range of poses that the camera saw, such movements are quadratic in the angles and linear in the tensions' level. Their covariance
is kept as a factor A(pose), (N, R), with A A^T the covariance of the angles, which is linear in the features of the pose.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from identification.model_file import Model, PoseModel, PoseNumber, PoseResidual, covariance_of, pose_machine
from identification.pose_numbers import is_shape
from identification.unknowns import terms_of
from mechanism.arm import Arm
from mechanism.cable_lengths import geometry_of_poses
from mechanism.description import Neck
from mechanism.dynamics import gravity_and_springs
from mechanism.machine import Machine
from mechanism.toleranced_numbers import toleranced_numbers
from observation.resting_arm import cables_at_rest, compliance, missing_torque, pull_at_rest

Array = NDArray[np.float64]

_POSES = 160
"""that are drawn within the range"""
_TENSION_N = (10.0, 120.0)
"""of a cable, what levels are drawn from"""
_STEP = 0.05
"""sigmas of a number: of the differences"""
_RANK = 10
"""columns of the factor"""
UNSEEN_RANGE_RAD = 0.6
"""of joint angles around straight, where no camera saw another"""
WIDENED = 1.5
"""by how much the sigmas of numbers are widened: residuals of a fit say nothing of what all frames share (docs/thresholds.md)"""
UNSEEN_FRICTION_SIGMA_N = 4.0
"""of what a motor's laws do not say, where no recording told (docs/thresholds.md)"""
UNSEEN_X0_SIGMA_M = 5e-3
"""of a pre-elongation that no recording told: motors may have started anywhere (docs/thresholds.md)"""


@dataclass(frozen=True)
class PoseError:
    """The pose's error: features of a pose are 1, N scaled angles, their N (N + 1) / 2 products, and the scaled mean tension."""

    middle: Array
    """of the angles' range, (N,), rad"""
    half_range: Array
    """(N,), rad"""
    tension: tuple[float, float]
    """N: middle and half range of the cables' mean tension"""
    factor: Array
    """(features, N, R), rad"""

    def at(self, alpha: Array, tension: float) -> Array:
        """A of the pose at angles (N,), rad, and a mean tension, N: (N, R), rad."""
        return (self.features(alpha, tension) @ self._flat_factor).reshape(self.factor.shape[1:])

    def features(self, alpha: Array, tension: float) -> Array:
        """Features of the pose at angles (N,), rad, and a mean tension, N, (features,)."""
        u = (alpha - self.middle) / self.half_range
        first, second = self._pairs
        scaled = (tension - self.tension[0]) / self.tension[1]
        return np.concatenate([[1.0], u, u[first] * u[second], [scaled]])

    @property
    def middle_sigma(self) -> Array:
        """Sigma of the angles in the middle of their range, (N,), rad."""
        return np.sqrt(np.sum(self.at(self.middle, self.tension[0]) ** 2, axis=1))

    # each row of a log asks for these
    @cached_property
    def _flat_factor(self) -> Array:
        return self.factor.reshape(len(self.factor), -1)

    @cached_property
    def _pairs(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Indices of the angles that are multiplied by each other."""
        return np.triu_indices(len(self.middle))


def pose_model(model: Model, neck: Neck) -> PoseModel:
    """The model's numbers by which motors tell joints; where no camera found any, those of identification and drawing."""
    if model.pose is not None:
        return model.pose
    machine = pose_machine(model, neck)
    numbers = [
        PoseNumber(name=n.name, index=None, kind="drawing", value=0.0, sigma=n.sigma)
        for n in toleranced_numbers(neck)
        if n.sigma > 0
    ]
    covariance = [np.diag([n.sigma**2 for n in numbers])]
    known = covariance_of(model)
    places = []
    for place, p in enumerate(model.parameters):
        is_term = any(t.name == p.name and not is_shape(t) for t in terms_of(model.laws))
        if (is_term or p.name == "x0") and np.isfinite(known[place, place]):
            places.append(place)
            values = machine.arm.x0 if p.name == "x0" else machine.values[p.name]
            kind = "x0" if p.name == "x0" else "law"
            value = float(values[(p.index or 1) - 1])
            numbers.append(
                PoseNumber(name=p.name, index=p.index, kind=kind, value=value, sigma=float(known[place, place] ** 0.5))
            )
    covariance.append(known[np.ix_(places, places)])
    whole = np.zeros((len(numbers), len(numbers)))
    first = len(covariance[0])
    whole[:first, :first], whole[first:, first:] = covariance
    n, m = neck.N, neck.M
    return PoseModel(
        numbers=tuple(numbers),
        covariance=tuple(tuple(float(v) for v in row) for row in whole),
        residual=PoseResidual(
            angle_rad=(0.0,) * n,
            motor_N=(UNSEEN_FRICTION_SIGMA_N,) * m,
            low_alpha=(-UNSEEN_RANGE_RAD,) * n,
            high_alpha=(UNSEEN_RANGE_RAD,) * n,
        ),
    )


def pose_error(model: Model, neck: Neck) -> PoseError:
    """The pose's error of a model whose `pose` is known."""
    assert model.pose is not None
    pose, base = model.pose, pose_machine(model, neck)
    n, m = neck.N, neck.M
    low, high = np.array(pose.residual.low_alpha), np.array(pose.residual.high_alpha)
    middle, half = (low + high) / 2, np.maximum((high - low) / 2, 0.05)
    rng = np.random.default_rng(0)
    alpha = middle + half * rng.uniform(-1, 1, (_POSES, n))
    level = rng.uniform(*_TENSION_N, (_POSES, 1)) * np.ones(m)
    tension = _balanced(base.arm, alpha, level)
    theta = _motor_angles(base, alpha, tension)
    torque, mean = missing_torque(base, alpha, theta)
    gives_way = compliance(base, alpha, theta)
    columns = []
    for place, number in enumerate(pose.numbers):
        step = _STEP * number.sigma
        if step == 0:
            columns.append(np.zeros((_POSES, n)))
            continue
        moved_torque, _ = missing_torque(pose_machine(model, neck, {place: step}), alpha, theta)
        columns.append(np.einsum("pij,pj->pi", gives_way, (moved_torque - torque) / step))
    root = _root(np.array(pose.covariance)) * WIDENED
    moves = np.stack(columns, axis=-1) @ root  # (poses, N, P): by each independent error
    tension_scale = (float(np.mean(mean)), float(max(np.std(mean), 1.0)))
    empty = PoseError(middle, half, tension_scale, np.zeros((1, n, 1)))
    features = np.stack([empty.features(a, t) for a, t in zip(alpha, mean, strict=True)])
    fitted = np.linalg.lstsq(features, moves.reshape(_POSES, -1), rcond=None)[0].reshape(-1, n, moves.shape[2])
    u, size, _ = np.linalg.svd(fitted.reshape(-1, moves.shape[2]), full_matrices=False)
    rank = min(_RANK, len(size))
    return replace(empty, factor=(u[:, :rank] * size[:rank]).reshape(-1, n, rank))


def _root(covariance: Array) -> Array:
    """R (P, P) with R R^T the covariance, which may be singular."""
    sigma = np.sqrt(np.diag(covariance))
    scale = np.where(sigma > 0, sigma, 1.0)
    size, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    return scale[:, None] * vectors * np.sqrt(np.maximum(size, 0.0))


def _balanced(arm: Arm, alpha: Array, about: Array) -> Array:
    """Tensions near `about` that hold the arm where the cables can, none below a newton, (poses, M)."""
    Z, g = geometry_of_poses(arm, alpha).Z, gravity_and_springs(arm, alpha)
    missing = g - np.einsum("pij,pj->pi", Z, about)
    return np.maximum(about + np.einsum("pji,pj->pi", np.linalg.pinv(Z).transpose(0, 2, 1), missing), 1.0)


def _motor_angles(machine: Machine, alpha: Array, tension: Array) -> Array:
    """At which cables at rest have tensions, by bisection, (poses, M), rad."""
    arm = machine.arm
    straight, _ = cables_at_rest(machine, alpha, np.zeros((len(alpha), arm.M)))
    low, high = (np.broadcast_to((x - straight.x) / arm.drum, tension.shape) for x in (-0.001, 0.05))
    for _ in range(50):
        theta = (low + high) / 2
        short = pull_at_rest(machine, cables_at_rest(machine, alpha, theta)[0]) < tension
        low, high = np.where(short, theta, low), np.where(short, high, theta)
    return (low + high) / 2
