"""Effects that no catalogue of causes holds, of every family: what an estimator must call unknown.

None has the form of a law that an estimator knows, and none shares code with one.
"""

from dataclasses import dataclass

import numpy as np

from samples.forward_arms.friction import turning
from samples.forward_arms.laws import Law, Snapshot
from samples.forward_arms.plant import Array, Plant


@dataclass(frozen=True)
class Cogging(Law):
    """Poles that hold every motor, `force` (N) by `poles` to a turn."""

    force: float
    poles: float

    def motor(self, s: Snapshot) -> Array:
        return self.force * np.sin(self.poles * s.theta)


@dataclass(frozen=True)
class TightPlace(Law):
    """Friction of every motor that is higher by `force` (N) over `width` (rad) at one place of its turn."""

    force: float
    width: float

    def motor(self, s: Snapshot) -> Array:
        away = np.abs(np.exp(1j * s.theta) - 1)
        return self.force * np.exp(-((away / self.width) ** 2)) * turning(s.theta_d)


@dataclass(frozen=True)
class EccentricDrum(Law):
    """Drums whose middle is off by `share` of their radius: cables run in and out once a turn, and pull at another lever."""

    share: float

    def tension(self, s: Snapshot) -> Array:
        return s.stiffness * s.drum * self.share * np.sin(s.theta / s.gear)

    def motor(self, s: Snapshot) -> Array:
        return np.maximum(s.tension, 0.0) * self.share * np.cos(s.theta / s.gear)


@dataclass(frozen=True)
class GearFriction(Law):
    """A gear that rubs by a share of the cable's tension, whichever way the cable lies."""

    share: float

    def motor(self, s: Snapshot) -> Array:
        return self.share * np.maximum(s.tension, 0.0) ** 1.5 / 8.0 * turning(s.theta_d)


@dataclass(frozen=True)
class Saturation(Law):
    """Motors whose force levels off: a command of `at` (N) is short by 24 %."""

    at: float

    def motor(self, s: Snapshot) -> Array:
        return s.f - self.at * np.tanh(s.f / self.at)


@dataclass(frozen=True)
class Loom(Law):
    """A loom of leads that bends with the first joint and holds it beyond `slack` (rad), N m/rad."""

    stiffness: float
    slack: float

    def joint(self, s: Snapshot) -> Array:
        out = np.zeros_like(s.alpha)
        out[0] = -self.stiffness * np.maximum(s.alpha[0] - self.slack, 0.0)
        return out


@dataclass(frozen=True)
class AirDrag(Law):
    """Joints that are held by the square of their speed, N m s^2/rad^2."""

    by_square: float

    def joint(self, s: Snapshot) -> Array:
        return -self.by_square * s.alpha_d * np.abs(s.alpha_d)

    def joint_damping(self, s: Snapshot) -> Array:
        return np.eye(len(s.alpha_d))[..., None] * 2 * self.by_square * np.abs(s.alpha_d)


@dataclass(frozen=True)
class WarmingFriction(Law):
    """Dry friction of the motors that falls by `force` (N) as they warm up, in `time` (s)."""

    force: float
    time: float

    def motor(self, s: Snapshot) -> Array:
        return self.force * np.exp(-max(s.time, 0.0) / self.time) * turning(s.theta_d)


@dataclass(frozen=True)
class TorqueRipple(Law):
    """Motors that give a `share` of what they are told more or less, `poles` to a turn."""

    share: float
    poles: float

    def motor(self, s: Snapshot) -> Array:
        return self.share * s.f * np.sin(self.poles * s.theta)


@dataclass(frozen=True)
class FadingGain(Law):
    """Motors that give a `share` less of what they are told as they warm up, in `time` (s)."""

    share: float
    time: float

    def motor(self, s: Snapshot) -> Array:
        return self.share * s.f * (1 - np.exp(-max(s.time, 0.0) / self.time))


@dataclass(frozen=True)
class StiffGrease(Law):
    """Viscous friction of the motors by cold grease, `by_speed` (N s/rad), that falls as it warms up, in `time` (s)."""

    by_speed: float
    time: float

    def motor(self, s: Snapshot) -> Array:
        return self.by_speed * np.exp(-max(s.time, 0.0) / self.time) * s.theta_d


@dataclass(frozen=True)
class TightJoint(Law):
    """The last joint rubs by `torque` (N m) more at an angle `at` (rad), over `width` (rad) about it."""

    torque: float
    at: float
    width: float

    def joint(self, s: Snapshot) -> Array:
        out = np.zeros_like(s.alpha)
        out[-1] = -self._torque(s) * np.tanh(s.alpha_d[-1] / 0.1)
        return out

    def joint_damping(self, s: Snapshot) -> Array:
        out = np.zeros((len(s.alpha), *s.alpha.shape))
        out[-1, -1] = self._torque(s) / 0.1 * (1 - np.tanh(s.alpha_d[-1] / 0.1) ** 2)
        return out

    def _torque(self, s: Snapshot) -> Array:
        return self.torque / (1 + ((s.alpha[-1] - self.at) / self.width) ** 2)


@dataclass(frozen=True)
class Crosstalk(Law):
    """Every motor pulls a share of what its neighbour is told as well."""

    share: float

    def motor(self, s: Snapshot) -> Array:
        return -self.share * np.roll(s.f, 1, axis=0)


@dataclass(frozen=True)
class Pushes(Law):
    """A hand that pushes the last joint for a second every ten, N m."""

    torque: float

    def joint(self, s: Snapshot) -> Array:
        out = np.zeros_like(s.alpha)
        phase = s.time % 10.0
        out[-1] = self.torque * (np.sin(np.pi * (phase - 4.0)) ** 2 if 4.0 < phase < 5.0 else 0.0)
        return out


@dataclass(frozen=True)
class AgeingFriction(Law):
    """Dry friction of the motors that grows by `force` (N) with the time since they last turned fast, in `time` (s)."""

    force: float
    time: float

    def memory_rows(self, plant: Plant) -> int:
        return plant.M

    def motor(self, s: Snapshot) -> Array:
        return self.force * s.memory * turning(s.theta_d)

    def memory_d(self, s: Snapshot) -> Array:
        return (1.0 - s.memory * (1.0 + np.abs(s.theta_d))) / self.time


@dataclass(frozen=True)
class WrongEncoder(Law):
    """Encoders whose discs sit off their shafts: angles are off by `angle` (rad) once a turn."""

    angle: float

    def encoder(self, time: float, theta: Array) -> Array:
        return theta + self.angle * np.sin(theta)
