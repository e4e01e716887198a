"""The equations of motion of one machine as expressions, with their derivatives by the state: traced from mechanism's own formulas.

    arm      M(alpha) alpha'' = Z t - c - g - joint friction                                   (44)
    motors   theta'' = (rd/R) / Ia (f - friction - t - friction error)                         (43)
    cables   rate of each memory variable

The pre-elongation x0 and the friction error are part of the state. Derivatives of the arm's equation leave out those of M and c,
which are small beside the cables'.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mechanism.batch_layout import arm_batch_last, to_batch_last
from mechanism.cable_lengths import cable_geometry
from mechanism.dynamics import terms_batch_last
from mechanism.laws import CableMotion, JointMotion, MotorMotion, Sliding
from mechanism.machine import Machine
from observation.expression import Derivatives, Expression, constant, variable
from observation.state_layout import StateLayout, layout_of
from observation.tracing import Untraceable, elements_of, symbols
from xneck_foundation.errors import Refused


@dataclass(frozen=True)
class Equations:
    """Expressions of the inputs `state`, `force` and `time`."""

    layout: StateLayout
    state: tuple[Expression, ...]
    force: tuple[Expression, ...]
    """that acts, M, N"""
    time: Expression
    """since the recording began, s"""
    mass: tuple[Expression, ...]
    """M(alpha), N N entries row by row"""
    rates: tuple[Expression, ...]
    """torques on the joints (N), theta'' (M), rates of the memory variables (M S)"""
    places: tuple[tuple[int, int], ...]
    """row of `rates` and column of the state of each derivative"""
    derivatives: tuple[Expression, ...]
    """of the rates by the state, where they are not zero"""
    tension: tuple[Expression, ...]
    """M, N"""
    elongation_d: tuple[Expression, ...]
    """rates of the cables' elongations, M, m/s"""
    held: tuple[Expression, ...]
    """square of the torque by which dry friction may hold each joint otherwise than its law says, N, N^2 m^2"""

    @property
    def outputs(self) -> tuple[Expression, ...]:
        """All expressions: mass, rates, derivatives, tension, elongation_d, held."""
        return (*self.mass, *self.rates, *self.derivatives, *self.tension, *self.elongation_d, *self.held)


def traced_equations(machine: Machine) -> Equations:
    """The equations of a machine as expressions. Raises Refused where a law cannot be traced, with its name."""
    layout = layout_of(machine)
    arm = arm_batch_last(machine.arm, ())
    # pre-elongations are in the state; an arm's own would be counted twice
    arm = replace(arm, x0=np.zeros_like(arm.x0))
    values = {name: to_batch_last(value, ()) for name, value in machine.values.items()}
    traced = replace(machine, arm=arm, values=values)
    _check_laws(traced)
    state = tuple(variable(f"s{i}") for i in range(layout.size))
    force = tuple(variable(f"f{j}") for j in range(layout.M))
    time = variable("time")
    mass, coriolis, torque, theta_dd, memory_d, tension, x_d, held = _formed(traced, layout, state, force, time)
    rates = (*(t - c for t, c in zip(torque, coriolis, strict=True)), *theta_dd, *memory_d)
    places, derivatives = [], []
    for column in range(layout.friction_error.stop):
        by = Derivatives(state[column])
        for row, rate in enumerate((*torque, *theta_dd, *memory_d)):
            derivative = by.of(rate)
            if derivative.value != 0:
                places.append((row, column))
                derivatives.append(derivative)
    return Equations(
        layout=layout,
        state=state,
        force=force,
        time=time,
        mass=tuple(mass),
        rates=rates,
        places=tuple(places),
        derivatives=tuple(derivatives),
        tension=tuple(tension),
        elongation_d=tuple(x_d),
        held=tuple(held),
    )


def _formed(
    machine: Machine,
    layout: StateLayout,
    state: tuple[Expression, ...],
    force: tuple[Expression, ...],
    time: Expression,
) -> tuple[list[Expression], ...]:
    """M, c, torques without c, theta'', rates of the memory, tensions, rates of elongation, squares of what friction may hold."""
    arm = machine.arm

    def part(name: str) -> Any:
        return symbols(np.array(state[getattr(layout, name)], dtype=object)[:, None])

    alpha, alpha_d, theta, theta_d = (part(name) for name in ("alpha", "alpha_d", "theta", "theta_d"))
    z = symbols(np.array(state[layout.memory], dtype=object).reshape(layout.M, 1, layout.S))
    f, since = symbols(np.array(force, dtype=object)[:, None]), symbols([[time]])
    cables = cable_geometry(arm, alpha)
    rest = cable_geometry(arm, np.zeros((layout.N, 1))).length
    k: Any = terms_batch_last(arm, alpha, alpha_d)
    x = cables.length - rest + arm.drum * theta + part("x0")
    x_d = arm.drum * theta_d - _sum([cables.Z[i] * alpha_d[i] for i in range(layout.N)])
    at = CableMotion(
        x=x,
        x_d=x_d,
        length=cables.length,
        arm=arm,
        travel_d=arm.drum * theta_d,
        drum_angle=theta / arm.gear,
        theta=theta,
        time=since,
    )
    pull = machine.pull(at, z) + 0.0 * x
    if layout.play is not None:
        pull = pull + part("dragged") * machine.undragged(at, z)
    tension = np.maximum(pull, 0.0)
    turning = MotorMotion(
        theta_d=theta_d,
        tension=tension,
        wrap=cables.wrap,
        theta=theta,
        drum_angle=theta / arm.gear,
        force=f,
        time=since,
        arm=arm,
        memory=z,
    )
    motion = JointMotion(alpha, alpha_d, since)
    resistance, held = machine.resistance(motion), machine.held_in_joints(motion)
    torque = -k.g - resistance + _sum([cables.Z[:, j] * tension[j] for j in range(layout.M)])
    if machine.loses_on_the_way:
        losses = machine.losses(cables.Z, alpha_d[:, None], cables.wraps)
        for i, loss in enumerate(losses):
            lost = cables.Z[i] * tension * (1 - np.exp(-loss))
            torque[i] = torque[i] - _sum([lost[j] for j in range(layout.M)])
        for i, square in enumerate(machine.held_on_the_way(cables.Z, alpha_d[:, None], cables.wraps)):
            on_the_way = (cables.Z[i] * tension) ** 2 * square
            held[i] = held[i] + _sum([on_the_way[j] for j in range(layout.M)])
    lightness = arm.drum / arm.motor_inertia
    theta_dd = lightness * (f - machine.friction(turning) - tension - part("friction_error"))
    memory_d = machine.memory_rate(at, z) if layout.S else z
    return tuple(
        [_expression(e) for e in elements_of(v).ravel()]
        for v in (k.M, k.c, torque, theta_dd, memory_d, tension, x_d, held)
    )


def _check_laws(machine: Machine) -> None:
    """Refused where a law calls what cannot be traced."""
    m, n = machine.arm.M, machine.arm.N
    cable, joint = (
        symbols(np.array([variable(f"v{i}") for i in range(count)], dtype=object)[:, None]) for count in (m, n)
    )
    for law in machine.laws:
        z = symbols(np.full((m, 1, law.states), variable("z"), dtype=object))
        at = CableMotion(
            x=cable, x_d=cable, length=cable, arm=machine.arm, travel_d=cable, drum_angle=cable, theta=cable, time=cable
        )
        try:
            law.pull(machine.values, at, z)
            law.memory_rate(machine.values, at, z)
            turning = MotorMotion(
                theta_d=cable,
                tension=cable,
                wrap=cable,
                theta=cable,
                drum_angle=cable,
                force=cable,
                time=cable,
                arm=machine.arm,
                memory=z,
            )
            law.friction(machine.values, turning)
            law.resistance(machine.values, JointMotion(joint, joint, joint))
            law.loss(machine.values, Sliding(cable[None], cable[None], cable[None]))
        except Untraceable as error:
            raise Refused("observe", f"the law {law.name} cannot be written as code ({error})") from error


def _sum(parts: list[Any]) -> Any:
    total = parts[0]
    for other in parts[1:]:
        total = total + other
    return total


def _expression(e: object) -> Expression:
    return e if isinstance(e, Expression) else constant(float(e))  # type: ignore[arg-type]
