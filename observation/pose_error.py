"""How uncertain the pose is to which the model's cables pull the arm, over all poses: from the covariance of the model's numbers.

A small change of the numbers moves each angle by the arm's compliance times the change of its torque. Over the range of poses that
the camera saw, such movements are quadratic in the angles and linear in the tensions' level; where the arm moves they are linear
in its speeds and in the rates of the cables' elongations besides, by friction of joints and damping of cables. Their covariance is
kept as a factor A, (N, R), with A A^T the covariance of the angles, which is linear in the features of pose and motion.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from identification.model_file import (
    Model,
    PoseModel,
    PoseNumber,
    PoseResidual,
    covariance_of,
    marker_offsets,
    pose_machine,
)
from identification.pose_numbers import is_shape
from identification.unknowns import terms_of
from mechanism.arm import Arm
from mechanism.cable_lengths import geometry_of_poses
from mechanism.description import Neck
from mechanism.dynamics import gravity_and_springs
from mechanism.machine import Machine
from mechanism.toleranced_numbers import toleranced_numbers
from mechanism.typical_load import typical_load
from observation.resting_arm import cables_at_rest, compliance, missing_torque, pull_at_rest, sides_in_motion

Array = NDArray[np.float64]

_POSES = 160
"""that are drawn within the range"""
_TENSION_LEVELS, _LEAST_TENSION, _LEAST_SPREAD = (1.0, 12.0), 0.1, 0.1
"""of the arm's typical load: what a cable's tension is drawn from, its least, and the least half range of the mean tension"""
_STEP = 0.05
"""sigmas of a number: of the differences"""
_X0_STEP_M = 1e-7
SPEED_RAD_S, ELONGATION_D_M_S = 1.0, 0.02
"""units of speeds of joints and of rates of elongation: lively motion, of which poses are drawn, goes about as fast"""
_RANK = 16
"""columns of the factor"""
UNSEEN_RANGE_RAD = 0.6
"""of joint angles around straight, where no camera saw another"""
UNSEEN_FRICTION_SHARE = 0.4
"""of the arm's typical load: sigma of what a motor's laws do not say, where no recording told (docs/thresholds.md)"""
UNSEEN_X0_SIGMA_M = 5e-3
"""of a pre-elongation that no recording told: motors may have started anywhere (docs/thresholds.md)"""


@dataclass(frozen=True)
class PoseError:
    """The pose's error: features are 1, N scaled angles, their N (N + 1) / 2 products, the scaled mean tension, N speeds of joints
    and M rates of elongation, both scaled, and where there is play the M sides at which drums lie."""

    middle: Array
    """of the angles' range, (N,), rad"""
    half_range: Array
    """(N,), rad"""
    tension: tuple[float, float]
    """N: middle and half range of the cables' mean tension"""
    factor: Array
    """(features, N, R), rad"""
    by_x0: Array
    """of the angles by the pre-elongations, rms over the poses, (N, M), rad/m"""

    def at(self, alpha: Array, tension: float, alpha_d: Array, x_d: Array, sides: Array) -> Array:
        """A at angles (N,), rad, a mean tension, N, speeds (N,), rad/s, and rates of elongation (M,), m/s: (N, R), rad.

        sides: of the drums within their play, -1 ... 1, (M,), or (0,) where they have none."""
        return (self.features(alpha, tension, alpha_d, x_d, sides) @ self._flat_factor).reshape(self.factor.shape[1:])

    def features(self, alpha: Array, tension: float, alpha_d: Array, x_d: Array, sides: Array) -> Array:
        """Features, (features,), of the arguments of `at`."""
        u = (alpha - self.middle) / self.half_range
        first, second = self._pairs
        scaled = (tension - self.tension[0]) / self.tension[1]
        motion = (alpha_d / SPEED_RAD_S, x_d / ELONGATION_D_M_S, sides)
        return np.concatenate([[1.0], u, u[first] * u[second], [scaled], *motion])

    def rate(self, alpha: Array, alpha_d: Array) -> Array:
        """How fast A changes as the pose does, at angles (N,), rad, and speeds (N,), rad/s: (N, R), rad/s."""
        u, u_d = (alpha - self.middle) / self.half_range, alpha_d / self.half_range
        first, second = self._pairs
        n = len(u)
        by_pose = np.concatenate([u_d, u_d[first] * u[second] + u[first] * u_d[second]])
        return (by_pose @ self._flat_factor[1 : 1 + len(by_pose)]).reshape(n, -1)

    @property
    def middle_sigma(self) -> Array:
        """Sigma of the angles in the middle of their range, (N,), rad."""
        return np.sqrt(np.sum(self.factor[0] ** 2, axis=1))

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
            motor_N=(UNSEEN_FRICTION_SHARE * typical_load(machine.arm),) * m,
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
    middle, half = (low + high) / 2 - marker_offsets(pose, n), np.maximum((high - low) / 2, 0.05)
    rng = np.random.default_rng(0)
    alpha = middle + half * rng.uniform(-1, 1, (_POSES, n))
    unit = typical_load(base.arm)
    level = unit * rng.uniform(*_TENSION_LEVELS, (_POSES, 1)) * np.ones(m)
    tension = np.maximum(_balanced(base.arm, alpha, level), _LEAST_TENSION * unit)
    theta = _motor_angles(base, alpha, tension)
    alpha_d = SPEED_RAD_S * rng.uniform(-1, 1, (_POSES, n))
    x_d = ELONGATION_D_M_S * rng.uniform(-1, 1, (_POSES, m))
    torque, mean = missing_torque(base, alpha, theta, alpha_d, x_d)
    gives_way = compliance(base, alpha, theta)
    columns = []
    for place, number in enumerate(pose.numbers):
        step = _STEP * number.sigma
        if step == 0:
            columns.append(np.zeros((_POSES, n)))
            continue
        if number.kind == "markers":  # they are seen with the joint, wherever it stands
            columns.append(np.broadcast_to(np.eye(n)[(number.index or 1) - 1], (_POSES, n)))
            continue
        moved_torque, _ = missing_torque(pose_machine(model, neck, {place: step}), alpha, theta, alpha_d, x_d)
        columns.append(np.einsum("pij,pj->pi", gives_way, (moved_torque - torque) / step))
    root = _root(np.array(pose.covariance))
    moves = np.stack(columns, axis=-1) @ root  # (poses, N, P): by each independent error
    tension_scale = (float(np.mean(mean)), float(max(np.std(mean), _LEAST_SPREAD * unit)))
    by_x0 = np.stack([_by_x0(base, alpha, theta, gives_way, j) for j in range(m)], axis=-1)
    empty = PoseError(middle, half, tension_scale, np.zeros((1, n, 1)), np.sqrt(np.mean(by_x0**2, axis=0)))
    sides = sides_in_motion(base, alpha, theta, alpha_d, x_d)
    features = np.stack([empty.features(*each) for each in zip(alpha, mean, alpha_d, x_d, sides, strict=True)])
    fitted = np.linalg.lstsq(features, moves.reshape(_POSES, -1), rcond=None)[0].reshape(-1, n, moves.shape[2])
    u, size, _ = np.linalg.svd(fitted.reshape(-1, moves.shape[2]), full_matrices=False)
    rank = min(_RANK, len(size))
    return replace(empty, factor=(u[:, :rank] * size[:rank]).reshape(-1, n, rank))


def _by_x0(machine: Machine, alpha: Array, theta: Array, gives_way: Array, j: int) -> Array:
    """Derivative of the angles at rest by a cable's pre-elongation, (poses, N), rad/m."""
    x0 = np.where(np.arange(machine.arm.M) == j, _X0_STEP_M, 0.0)
    longer, shorter = (replace(machine, arm=replace(machine.arm, x0=machine.arm.x0 + s * x0)) for s in (1, -1))
    change = missing_torque(longer, alpha, theta)[0] - missing_torque(shorter, alpha, theta)[0]
    return np.einsum("pij,pj->pi", gives_way, change / (2 * _X0_STEP_M))


def _root(covariance: Array) -> Array:
    """R (P, P) with R R^T the covariance, which may be singular."""
    sigma = np.sqrt(np.diag(covariance))
    scale = np.where(sigma > 0, sigma, 1.0)
    size, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    return scale[:, None] * vectors * np.sqrt(np.maximum(size, 0.0))


def _balanced(arm: Arm, alpha: Array, about: Array) -> Array:
    """Tensions near `about` that hold the arm where the cables can, (poses, M); some may push."""
    Z, g = geometry_of_poses(arm, alpha).Z, gravity_and_springs(arm, alpha)
    missing = g - np.einsum("pij,pj->pi", Z, about)
    return about + np.einsum("pji,pj->pi", np.linalg.pinv(Z).transpose(0, 2, 1), missing)


def _motor_angles(machine: Machine, alpha: Array, tension: Array) -> Array:
    """At which cables at rest have tensions, by bisection, (poses, M), rad."""
    arm = machine.arm
    straight = cables_at_rest(machine, alpha, np.zeros((len(alpha), arm.M)))
    low, high = (np.broadcast_to((x - straight.x) / arm.drum, tension.shape) for x in (-0.001, 0.05))
    for _ in range(50):
        theta = (low + high) / 2
        short = pull_at_rest(machine, cables_at_rest(machine, alpha, theta)) < tension
        low, high = np.where(short, theta, low), np.where(short, high, theta)
    return (low + high) / 2
