"""An arm with the laws that its motors, cables and joints obey, and their numbers."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from mechanism.arm import Arm, Array
from mechanism.cable_lengths import CableGeometry
from mechanism.laws import CableMotion, JointMotion, Law, MotorMotion, Sliding, law_named
from mechanism.path_memory import PathMemory, PathSteps
from mechanism.running_sums import running_sums

SPEED_STEP_RAD_S, _PATH_STEP_RAD = 1e-3, 1e-6
"""of the differences for friction's slopes"""


@dataclass(frozen=True)
class Machine:
    """Arm, names of its laws, and values of their terms: (..., M) for cables, (..., N) for joints, (..., 1) where all share one."""

    arm: Arm
    names: tuple[str, ...]
    values: Mapping[str, Array]

    @cached_property
    def laws(self) -> tuple[Law, ...]:
        """The laws, in the order of `names`."""
        return tuple(law_named(name) for name in self.names)

    @cached_property
    def states(self) -> int:
        """Number of memory variables of each cable."""
        return sum(law.states for law in self.laws)

    @cached_property
    def _parts(self) -> tuple[tuple[Law, slice], ...]:
        """The laws, each with the place of its memory variables among those of all."""
        ends = np.cumsum([law.states for law in self.laws]).tolist()
        return tuple((law, slice(end - law.states, end)) for law, end in zip(self.laws, ends, strict=True))

    def memory_of(self, name: str) -> slice:
        """The place of a law's memory variables among those of all."""
        return self._parts[self.names.index(name)][1]

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds of the memory variables, (states,) each."""
        bound = np.array([law.memory_bound for law in self.laws for _ in range(law.states)])
        return -bound, bound

    @property
    def memory_start(self) -> Array:
        """Memory variables where a recording begins, (M, states): nothing where `values` do not say."""
        starts = np.zeros((self.arm.M, self.states))
        for law, part in self._parts:
            if law.memory_start and law.memory_start.name in self.values:
                starts[:, part] = np.broadcast_to(self.values[law.memory_start.name], self.arm.M)[:, None]
        return starts

    @property
    def remembers_path(self) -> bool:
        """Whether friction depends on memory variables."""
        return any(law.remembers_path for law in self.laws)

    @property
    def rubs_under_tension(self) -> bool:
        """Whether friction depends on the cables' tension and on how far they are wound around pulleys."""
        return any(law.rubs_under_tension for law in self.laws)

    @property
    def follows_force(self) -> bool:
        """Whether friction depends on what the motors are told."""
        return any(law.follows_force for law in self.laws)

    @property
    def of_motors(self) -> "Machine":
        """This machine with the laws alone by which forces act on the motors and rub there."""
        methods = ("friction", "acting_force")
        acting = [law for law in self.laws if any(getattr(type(law), m) is not getattr(Law, m) for m in methods)]
        return replace(self, names=tuple(law.name for law in acting))

    def memory_along(self, travel: Array, first: Array) -> PathMemory:
        """Memory variables on which friction depends along steps of a travel of the motors' angles, (S, M), rad.

        first: where the first step begins, (M, states). Of laws of the motors alone (`of_motors`): the memory of others follows
        the cables."""
        return PathMemory.along(travel, self._path_steps, first)

    def _path_steps(self, travel: Array) -> PathSteps:
        steps = [law.path_steps(self.values, travel) for law in self.laws if law.remembers_path]
        return PathSteps(*(np.concatenate([getattr(s, f.name) for s in steps], axis=-1) for f in fields(PathSteps)))

    @property
    def without_actuator_laws(self) -> "Machine":
        """This machine without the laws of its actuators: for forces as they act, not as they are logged."""
        return replace(self, names=tuple(law.name for law in self.laws if type(law).acting_force is Law.acting_force))

    def acting_force(self, f: Array, step: float) -> Array:
        """Forces that act where the log says f (..., T, M), N, on rows `step` s apart."""
        for law in self.laws:
            f = law.acting_force(self.values, f, step)
        return f

    def commanded_force(self, force: Array, step: float) -> Array:
        """Forces that the log says where `force` (..., T, M), N, acts, on rows `step` s apart: the inverse of `acting_force`."""
        for law in reversed(self.laws):
            force = law.commanded_force(self.values, force, step)
        return force

    def friction(self, at: MotorMotion) -> Array:
        """Force that friction takes from each motor's command, (..., M), N."""
        total = np.zeros(())
        for law, part in self._parts:
            own = replace(at, memory=at.memory[..., part]) if law.remembers_path else at
            total = total + law.friction(self.values, own)
        return total

    def memory_on_path(self, theta: Array) -> Array:
        """Means of the memory variables on which friction depends, over the steps of a path of motor angles (T, M), rad.

        Shape (T - 1, M, states), from `memory_start` on; variables of other laws are zero."""
        travel, start = np.diff(theta, axis=0), self.memory_start
        means = np.zeros((*travel.shape, self.states))
        for law, part in self._parts:
            if law.remembers_path:
                steps = law.path_steps(self.values, travel)
                means[..., part] = steps.means(steps.starts(start[..., part]))
        return means

    @property
    def path_numbers(self) -> Hashable:
        """What memory of the motors' path depends on: the laws in their order, and the numbers of those that remember it."""
        terms = [term.name for law in self.laws if law.remembers_path for term in law.terms]
        return self.names, self.memory_start.tobytes(), *(np.asarray(self.values[name]).tobytes() for name in terms)

    def memory_about_rows(self, theta: Array) -> Array:
        """`memory_on_path` from the middle before each row to the middle after it, (T, M, states); theta: at rows, (T, M), rad."""
        if not self.remembers_path:
            return np.zeros((*theta.shape, self.states))
        return self.memory_on_path(np.concatenate([theta[:1], (theta[:-1] + theta[1:]) / 2, theta[-1:]]))

    def friction_slope(self, at: MotorMotion) -> Array:
        """Change of that force with the speed, (..., M), N s/rad, by differences."""
        low, high = (
            self.friction(replace(at, theta_d=at.theta_d + step)) for step in (-SPEED_STEP_RAD_S, SPEED_STEP_RAD_S)
        )
        return np.broadcast_to((high - low) / (2 * SPEED_STEP_RAD_S), at.theta_d.shape)

    def friction_by_path(self, at: MotorMotion) -> Array:
        """Change of that force with the motor's angle by what it remembers of its path, (..., M), N/rad."""
        if not self.remembers_path:
            return np.zeros(at.theta_d.shape)
        direction, still = np.sign(at.theta_d), np.zeros_like(at.theta_d)
        turning = CableMotion(still, still, still, self.arm, self.arm.drum * direction)
        further = _PATH_STEP_RAD * direction[..., None] * self.memory_rate(turning, at.memory)
        return (self.friction(replace(at, memory=at.memory + further)) - self.friction(at)) / _PATH_STEP_RAD

    def tension(self, at: CableMotion, z: Array) -> Array:
        """Tension of each cable, (..., M), N, never below zero: a cable cannot push; z (..., M, states)."""
        return np.maximum(self.pull(at, z), 0.0)

    def pull(self, at: CableMotion, z: Array) -> Array:
        """Tension of each cable as if it could push, (..., M), N; z (..., M, states)."""
        total = np.zeros(())
        for law, part in self._parts:
            total = total + law.pull(self.values, at, z[..., part])
        return total

    @property
    def play_place(self) -> int | None:
        """Which of a cable's memory variables says where its drum lies within its play; None where drums have none."""
        return next((part.start for law, part in self._parts if type(law).undragged is not Law.undragged), None)

    def undragged(self, at: CableMotion, z: Array) -> Array:
        """Tension more, (..., M), N, if the cables' dampers felt all of the motors' speed while they cross their play."""
        return sum((law.undragged(self.values, at, z[..., part]) for law, part in self._parts), start=np.zeros(()))

    def memory_in_motion(self, at: CableMotion) -> Array:
        """Memory variables, (..., M, states), of cables that have gone on as they go: creep has ended, strands stand anywhere."""
        out = np.zeros((*at.x.shape, self.states))
        for law, part in self._parts:
            out[..., part] = law.memory_in_motion(at)
        return out

    def memory_rate(self, at: CableMotion, z: Array) -> Array:
        """Rate of the cables' memory variables, (..., M, states)."""
        out = np.empty_like(z, shape=np.broadcast_shapes(z.shape, (*at.x.shape, self.states)))
        for law, part in self._parts:
            if law.states:
                out[..., part] = law.memory_rate(self.values, at, z[..., part])
        return out

    @cached_property
    def loses_on_the_way(self) -> bool:
        """Whether less of a cable's tension arrives at the spans of its mechanisms than it has at the drum."""
        return any(law.loses(self.values) for law in self.laws)

    def losses(self, Z: Array, alpha_d: Array, wraps: Array) -> Array:
        """Logarithm of a cable's tension at the drum over what arrives at each mechanism's span, (N, ..., M).

        Z, wraps: (N, ..., M), (2 N, ..., M), m and rad, mechanisms first; alpha_d: (N, ...) to be multiplied with Z, rad/s.
        """
        at = _sliding(Z, alpha_d, wraps)
        here = [law.loss(self.values, at) for law in self.laws if law.loses(self.values)]
        return running_sums(sum(here, start=np.zeros_like(at.speed)))

    @property
    def holds_at_rest(self) -> bool:
        """Whether dry friction in joints or on pulleys may hold the arm at rest."""
        kinds = [type(law) for law in self.laws]
        return any(k.held_torque is not Law.held_torque or k.held_loss is not Law.held_loss for k in kinds)

    def held_torque(self, at: JointMotion, Z: Array, wraps: Array, tension: Array) -> Array:
        """By which dry friction may hold each joint at rest otherwise than the laws say, (T, N), N m.

        Z, wraps: (T, N, M), (T, 2 N, M), m and rad; tension: (T, M), N. What holds a cable at several pulleys of its way adds up
        in squares."""
        square = self.held_in_joints(at)
        if self.loses_on_the_way:
            mechanisms_first = (np.moveaxis(v, -2, 0) for v in (Z, at.alpha_d[..., None], wraps))
            on_the_way = np.moveaxis(self.held_on_the_way(*mechanisms_first), 0, -2)
            square = square + np.sum((Z * np.maximum(tension, 0.0)[:, None]) ** 2 * on_the_way, axis=-1)
        return np.sqrt(square)

    def held_in_joints(self, at: JointMotion) -> Array:
        """Square of the torque by which friction in the joints may hold them otherwise than the laws say, (..., N), N^2 m^2."""
        square = np.zeros_like(at.alpha_d)
        for law in self.laws:
            square = square + law.held_torque(self.values, at) ** 2
        return square

    def held_on_the_way(self, Z: Array, alpha_d: Array, wraps: Array) -> Array:
        """Square of the share of a cable's tension that pulleys may hold on the way to each mechanism, (N, ..., M).

        Arguments as in `losses`."""
        at = _sliding(Z, alpha_d, wraps)
        held = sum((law.held_loss(self.values, at) ** 2 for law in self.laws), start=np.zeros_like(at.speed))
        return running_sums(held)

    def ratios_lost(self, Z: Array, alpha_d: Array, wraps: Array) -> Array:
        """Share of a cable's tension that is lost on the way to each mechanism, (..., N, M).

        Z, wraps: (..., N, M), (..., 2 N, M), m and rad; alpha_d: (..., N), rad/s."""
        mechanisms_first = (np.moveaxis(v, -2, 0) for v in (Z, np.asarray(alpha_d)[..., None], wraps))
        return -np.expm1(-np.moveaxis(self.losses(*mechanisms_first), 0, -2))

    def arriving(self, Z: Array, alpha_d: Array, wraps: Array) -> Array:
        """Z of what arrives of each cable's tension, (..., N, M), m; arguments as in `ratios_lost`."""
        return Z * (1 - self.ratios_lost(Z, alpha_d, wraps)) if self.loses_on_the_way else Z

    def torque_lost(self, t: Array, cables: CableGeometry, alpha_d: Array) -> Array:
        """Torque that tensions t (M, B), N, lose on the way, (N, B), N m, in batch layout; alpha_d: (N, B), rad/s."""
        losses = self.losses(cables.Z, alpha_d[:, None], cables.wraps)
        return np.sum(cables.Z * t * -np.expm1(-losses), axis=1)

    def resistance(self, at: JointMotion) -> Array:
        """Torque against the joints' motion, (..., N), N m."""
        return sum((law.resistance(self.values, at) for law in self.laws), start=np.zeros(()))


def _sliding(Z: Array, alpha_d: Array, wraps: Array) -> Sliding:
    """How cables slide over the pulleys before each mechanism's span, (N, ..., M); arguments as in `Machine.losses`."""
    speeds = running_sums((Z * alpha_d)[::-1])[::-1]
    return Sliding(speeds, before=wraps[: len(speeds)], above=wraps[len(speeds) :])
