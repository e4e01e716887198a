"""One step of arm, cables and motors in one pose: a Rosenbrock method, stable however stiff, damped or rubbing they are.

In a pose that stands still (Z, M, c + g do not change) elongations go with joints and motors, x' = -Z^T alpha' + (rd/R) theta',
and all that is not linear are the laws. A step linearises them once; each of its stages then solves (1/(gamma h) - J) U = rate
plus what earlier stages found (Hairer and Wanner, Solving Ordinary Differential Equations II, IV.7). Cables and motors are
eliminated one by one, so that a symmetric system in the N joints is left.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mechanism.arm import Array
from mechanism.cable_lengths import Strung
from mechanism.dynamics import Terms
from mechanism.law_slopes import Slopes, slopes
from mechanism.laws import Stretching, Turning
from mechanism.machine import Machine
from mechanism.small_systems import factored, solved

GAMMA = 0.43586652150845899941601945119356
C = ((), (-1.0156171083877702091975600115545,), (4.0759956452537699824805835358067, 9.2076794298330791242156818474003))
WEIGHTS = (1.0, 6.1697947043828245592553615689730, -0.42772256543218573326238373806514)
"""Ros3 of order 3, L-stable, with rates at the beginning and after the first stage only (Sandu et al., Atmos. Environ. 31, 1997)"""


@dataclass(frozen=True)
class Pose:
    """What does not change during a step, in lanes: alpha there (N, lanes), cables, and the arm's terms."""

    alpha: Array
    cables: Strung
    terms: Terms


@dataclass(frozen=True)
class Lanes:
    """A state in lanes: alpha, alpha_d (N, lanes), theta, theta_d (M, lanes), what cables remember (M, lanes, states)."""

    alpha: Array
    alpha_d: Array
    theta: Array
    theta_d: Array
    memory: Array


@dataclass(frozen=True)
class Drive:
    """Of the motors, (M, lanes): the force that they give, N; or, where they are `led`, the acceleration they have, rad/s^2."""

    push: Array
    led: bool


@dataclass(frozen=True)
class _Rates:
    """What moves a state: torque on the joints (N, lanes), motors' acceleration, memories' rate."""

    torque: Array
    theta_dd: Array
    memory: Array


def step_in_pose(machine: Machine, pose: Pose, rest_length: Array, start: Lanes, drive: Drive, h: float) -> Lanes:
    """The state h seconds later; machine in lanes, rest_length l(0) (M, lanes), m."""
    arm, strung, M = machine.arm, pose.cables, pose.terms.M
    n, m, drum = arm.N, arm.M, arm.drum
    joints, motors, cables = slice(n), slice(n, n + m), slice(n + m, None)

    x = strung.length - rest_length + arm.x0 + strung.stretch(drum, start.alpha - pose.alpha, start.theta)
    place = np.concatenate([start.alpha, start.theta, x])
    speed = np.concatenate([start.alpha_d, start.theta_d, strung.stretch(drum, start.alpha_d, start.theta_d)])
    memory = start.memory
    lightness = np.zeros_like(drum) if drive.led else drum / arm.motor_inertia  # rad/s^2 by N at the cable

    def rates(place: Array, speed: Array, memory: Array) -> _Rates:
        at = Stretching(place[cables], speed[cables], strung.length, arm, drum * speed[motors])
        t = machine.tension(at, memory)
        torque = strung.torque(t) - pose.terms.c - pose.terms.g - machine.resistance(speed[joints])
        if drive.led:
            turning = drive.push
        else:
            turning = lightness * (drive.push - machine.friction(Turning(speed[motors], t, strung.wrap)) - t)
        return _Rates(torque, turning, machine.drift(at, memory) if machine.states else memory)

    at = Stretching(x, speed[cables], strung.length, arm, drum * start.theta_d)
    k = slopes(machine, at, memory, start.theta_d, strung.wrap, start.alpha_d)
    w = 1 / (GAMMA * h)
    # what a change of x' does by the end: to memories, to tensions, and by those to motors and joints
    remembers = (k.drift_by_x / w + k.drift_by_x_d) / (w - k.drift_by_memory)
    pull = k.pull_by_x / w + k.pull_by_x_d + _of_memory(k, remembers)
    held = w + lightness * k.rub_by_speed
    yields = lightness * (1 + k.rub_by_tension) / held
    share = 1 / (1 + drum * yields * pull)
    A = w * M + np.einsum("ikb,jkb->ijb", strung.Z * (pull * share), strung.Z)
    diagonal = np.arange(n)
    A[diagonal, diagonal] += k.resist_by_speed
    factors = factored(A)

    by_place: list[Array] = []
    by_speed: list[Array] = []
    by_memory: list[Array] = []
    now = rates(place, speed, memory)
    going = speed
    for stage, c in enumerate(C):
        if stage == 1:  # the third stage takes the same rates
            now = rates(place + by_place[0], speed + by_speed[0], memory + by_memory[0])
            going = speed + by_speed[0]
        of_place, of_memory = going, now.memory
        torque, turning = now.torque, now.theta_dd
        if stage:
            before = _combined([weight / h for weight in c], by_speed)
            of_place = going + _combined([weight / h for weight in c], by_place)
            of_memory = now.memory + _combined([weight / h for weight in c], by_memory)
            torque, turning = torque + np.einsum("ijb,jb->ib", M, before[joints]), turning + before[motors]
        stretch = of_place[cables] / w
        kept = (of_memory + k.drift_by_x * stretch[..., None]) / (w - k.drift_by_memory)
        tension = k.pull_by_x * stretch + _of_memory(k, kept)
        free = turning / held - yields * tension
        of_joints = solved(factors, torque + strung.torque(tension + pull * share * drum * free))
        of_cables = share * strung.stretch(drum, of_joints, free)
        moved = np.concatenate([of_joints, free - yields * pull * of_cables, of_cables])
        by_place.append((of_place + moved) / w)
        by_speed.append(moved)
        by_memory.append(kept + remembers * of_cables[..., None])
    place, speed = place + _combined(WEIGHTS, by_place), speed + _combined(WEIGHTS, by_speed)
    memory = np.clip(memory + _combined(WEIGHTS, by_memory), *machine.bounds)
    return Lanes(place[joints], speed[joints], place[motors], speed[motors], memory)


def _of_memory(k: Slopes, remembered: Array) -> Array:
    """Tension (M, lanes) of changed memories (M, lanes, states)."""
    return np.sum(k.pull_by_memory * remembered, axis=-1) if remembered.shape[-1] else np.zeros(())


def _combined(weights: Sequence[float], parts: Sequence[Array]) -> Array:
    total = weights[0] * parts[0]
    for weight, part in zip(weights[1:], parts[1:], strict=True):
        total = total + weight * part
    return total
