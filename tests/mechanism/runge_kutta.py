"""The same equations by the classical Runge-Kutta method of order four, with everything taken anew four times a step.

Nothing is frozen, extrapolated or linearised here: what the simulation is held against.
"""

from dataclasses import replace

import numpy as np

from mechanism.cable_lengths import geometry_of_poses, lengths
from mechanism.dynamics import terms
from mechanism.elasticity import elongation_rate
from mechanism.laws import CableMotion, JointMotion, MotorMotion
from mechanism.machine import Machine
from mechanism.simulation import State


def runge_kutta(
    machine: Machine, start: State, time: np.ndarray, f: np.ndarray, step: float, began: float = 0.0
) -> list[State]:
    """States at every time, of one machine without batch axes, under forces f (T, M) held from row to row.

    began: s, when the recording began, for laws that follow the time."""
    arm = machine.arm
    l0 = lengths(arm, np.zeros(arm.N))

    def rate(y: State, force: np.ndarray, since: float) -> State:
        assert y.memory is not None
        cables = geometry_of_poses(arm, y.alpha)
        x = cables.length - l0 + arm.drum * y.theta + arm.x0
        x_d, drum_angle, since_began = (
            elongation_rate(arm, cables.Z, y.alpha_d, y.theta_d),
            y.theta / arm.gear,
            np.array(since),
        )
        at = CableMotion(x, x_d, cables.length, arm, arm.drum * y.theta_d, drum_angle, y.theta, since_began)
        t = machine.tension(at, y.memory)
        k = terms(arm, y.alpha, y.alpha_d)
        arrives = machine.arriving(cables.Z, y.alpha_d, cables.wraps)
        torque = arrives @ t - k.c - k.g - machine.resistance(JointMotion(y.alpha, y.alpha_d, since_began))
        alpha_dd = np.asarray(np.linalg.solve(k.M, torque), dtype=float)
        turning = MotorMotion(y.theta_d, t, cables.wrap, y.theta, drum_angle, force, since_began, arm)
        net = force - machine.friction(turning) - t
        return State(
            y.alpha_d, alpha_dd, y.theta_d, arm.drum * net / arm.motor_inertia, machine.memory_rate(at, y.memory)
        )

    y = replace(start, memory=np.zeros((arm.M, machine.states)) if start.memory is None else start.memory)
    out = [y]
    for row, interval in enumerate(np.diff(time)):
        count = int(np.ceil(interval / step - 1e-9))
        h = interval / count
        for step_number in range(count):
            at = float(time[row]) + step_number * h - began
            k1 = rate(y, f[row], at)
            k2 = rate(_moved(y, k1, h / 2), f[row], at + h / 2)
            k3 = rate(_moved(y, k2, h / 2), f[row], at + h / 2)
            k4 = rate(_moved(y, k3, h), f[row], at + h)
            for k, weight in ((k1, 1), (k2, 2), (k3, 2), (k4, 1)):
                y = _moved(y, k, weight * h / 6)
            y = replace(y, memory=np.clip(np.asarray(y.memory), *machine.bounds))
        out.append(y)
    return out


def _moved(y: State, rate: State, h: float) -> State:
    names = ("alpha", "alpha_d", "theta", "theta_d", "memory")
    return State(*(getattr(y, name) + h * getattr(rate, name) for name in names))
