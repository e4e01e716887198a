"""The arm, its cables, motors and laws as one system of first order, and its linearisation for an implicit step.

State (rows, B): alpha, alpha', theta, theta', bend of the bristles, memory of the laws.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from samples.forward_arms.cables import lengths, levers, wraps, wraps_before_spans, wraps_in_halves
from samples.forward_arms.dynamics import Equations, equations
from samples.forward_arms.friction import Friction, friction
from samples.forward_arms.joints import Fold, folded, placed
from samples.forward_arms.laws import Gathered, Law, Snapshot
from samples.forward_arms.plant import Array, Plant
from samples.forward_arms.symmetric import factor, solve


@dataclass(frozen=True)
class Rates:
    """Rate of the state, and what it was made of."""

    state_d: Array
    alpha_dd: Array
    tension: Array
    equations: Equations
    Z: Array
    friction: Friction
    taut: Array
    joint_damping: Array
    """(N, N, B), of the laws, N m s/rad; zero where slopes were not asked for"""


class _Whole(dict[str, Array]):
    """What laws may look at; how cables lie on their pulleys follows where one does."""

    def __init__(self, plant: Plant, fold: Fold) -> None:
        self._plant, self._fold = plant, fold

    def __missing__(self, name: str) -> Array:
        made = {"wrap": wraps, "wraps": wraps_before_spans, "wraps_in_halves": wraps_in_halves}[name]
        self[name] = value = made(self._plant, self._fold, self["alpha"])
        return value


class System:
    """Many arms with as many mechanisms and cables each."""

    def __init__(self, plant: Plant, laws: Sequence[Gathered] = (), *, slack: bool = True) -> None:
        """`slack`: cables do not push."""
        self.plant, self.laws, self.slack = plant, laws, slack
        n, m = plant.N, plant.M
        self.alpha, self.alpha_d = slice(0, n), slice(n, 2 * n)
        self.theta, self.theta_d = slice(2 * n, 2 * n + m), slice(2 * n + m, 2 * n + 2 * m)
        self.bend = slice(2 * n + 2 * m, 2 * n + 3 * m)
        self.memory = slice(2 * n + 3 * m, None)
        self.size = 2 * n + 3 * m + sum(g.rows.stop - g.rows.start for g in laws)
        acts = ("tension", "memory_d", "motor", "joint")
        self._that_have = {
            name: [g for g in laws if getattr(type(g.law), name) is not getattr(Law, name)] for name in acts
        }
        self.straight = lengths(plant, folded(plant, np.zeros_like(plant.L)), np.zeros_like(plant.L))

    def rates(self, time: float, y: Array, f: Array, slopes: bool = True) -> Rates:
        """At state y (rows, B) under motor forces f (M, B), N at the cable.

        `slopes`: whether laws are asked how they fall with speeds, which only the linearisation takes.
        """
        plant = self.plant
        alpha, alpha_d, theta, theta_d = y[self.alpha], y[self.alpha_d], y[self.theta], y[self.theta_d]
        fold = folded(plant, alpha)
        place = placed(fold)
        eq = equations(plant, fold, place, alpha_d)
        Z = levers(plant, fold)
        x = lengths(plant, fold, alpha) - self.straight + plant.travel * theta + plant.x0
        x_d = plant.travel * theta_d - np.einsum("imb,ib->mb", Z, alpha_d)
        tension = plant.stiffness * x + plant.damping * x_d
        rub = friction(plant, theta_d, y[self.bend])
        resistance = rub.force
        state_d = np.empty_like(y)
        joint: Array | float = 0.0
        damping = np.zeros((len(alpha), *alpha.shape))
        if self.laws:
            added, resisting, driving = np.zeros_like(tension), np.zeros_like(tension), np.zeros_like(alpha)
            memory, memory_d = y[self.memory], state_d[self.memory]
            whole: dict[str, Array] = _Whole(plant, fold)
            whole |= {
                "alpha": alpha,
                "alpha_d": alpha_d,
                "theta": theta,
                "theta_d": theta_d,
                "x": x,
                "x_d": x_d,
                "tension": tension,
                "Z": Z,
                "memory": memory,
                "f": f,
                "gear": plant.gear,
                "stiffness": plant.stiffness,
                "drum": plant.drum,
            }
            memory_d[:] = 0.0
            for g in self._that_have["tension"]:
                added[:, g.columns] += g.law.tension(Snapshot(time, whole, g.columns, g.rows))
            for g in self._that_have["memory_d"]:
                memory_d[g.rows, g.columns] = g.law.memory_d(Snapshot(time, whole, g.columns, g.rows))
            # what rubs by the tension rubs by all of it, whichever law it is of
            whole["tension"] = tension + added
            for g in self._that_have["motor"]:
                resisting[:, g.columns] += g.law.motor(Snapshot(time, whole, g.columns, g.rows))
            for g in self._that_have["joint"]:
                s = Snapshot(time, whole, g.columns, g.rows)
                driving[:, g.columns] += g.law.joint(s)
                if slopes:
                    damping[..., g.columns] += g.law.joint_damping(s)
            tension, resistance, joint = tension + added, resistance + resisting, driving
        taut = tension > 0
        if self.slack:
            tension = np.where(taut, tension, 0.0)
        drive = np.einsum("imb,mb->ib", Z, tension) - eq.rest + joint
        alpha_dd = solve(factor(eq.mass), drive)
        state_d[self.alpha], state_d[self.alpha_d] = alpha_d, alpha_dd
        state_d[self.theta] = theta_d
        state_d[self.theta_d] = plant.travel / plant.motor_inertia * (f - resistance - tension)
        state_d[self.bend] = rub.bend_d
        return Rates(
            state_d=state_d,
            alpha_dd=alpha_dd,
            tension=tension,
            equations=eq,
            Z=Z,
            friction=rub,
            taut=taut if self.slack else np.ones_like(taut),
            joint_damping=damping,
        )

    def encoder(self, time: float, y: Array) -> Array:
        """What the log has of the motors' angles, (M, B), rad: whole counts."""
        theta = y[self.theta]
        for g in self.laws:
            theta = theta.copy()
            theta[:, g.columns] = g.law.encoder(time, theta[:, g.columns])
        count = 2 * np.pi / self.plant.counts
        return np.round(theta / count) * count

    def energy(self, y: Array) -> Array:
        """Kinetic, of gravity, springs, cables and motors, (B,), J; of the base laws with taut cables."""
        plant = self.plant
        fold = folded(plant, y[self.alpha])
        place = placed(fold)
        mass = equations(plant, fold, place, y[self.alpha_d]).mass
        kinetic = np.einsum("ib,ijb,jb->b", y[self.alpha_d], mass, y[self.alpha_d]) / 2
        kinetic += np.sum(plant.motor_inertia * y[self.theta_d] ** 2, axis=0) / 2
        weighed = plant.bar_mass * (place.middle[1:] + plant.bar_com * place.along[1:])
        weighed = weighed + plant.diagonal_mass * (place.middle[1:] + place.middle[:-1])
        height = -np.sum((np.conj(plant.gravity) * weighed).real, axis=0)
        x = lengths(plant, fold, y[self.alpha]) - self.straight + plant.travel * y[self.theta] + plant.x0
        springs = plant.spring_left * (fold.left - plant.free_left) ** 2
        springs = springs + plant.spring_right * (fold.right - plant.free_right) ** 2
        return kinetic + height + np.sum(springs, axis=0) / 2 + np.sum(plant.stiffness * x**2, axis=0) / 2

    def implicit(self, at: Rates, g: float) -> "Implicit":
        """1 - g A for the part A of the linearisation at a state that is of cables, motors and the joints' friction."""
        return Implicit(self, at, g)


class Implicit:
    """Solves (1 - g A) k = r: cables' stiffness and damping, the motors' and the joints' friction, the motors eliminated."""

    def __init__(self, system: System, at: Rates, g: float) -> None:
        plant, rub = system.plant, at.friction
        self.system, self.g, self.Z, self.rub = system, g, at.Z, rub
        self.mass = at.equations.mass
        self.stiffness = at.taut * plant.stiffness
        self.both = g * self.stiffness + at.taut * plant.damping  # what a speed adds to the tension
        self.bent = 1 / (1 - g * rub.bend_d_by_bend)
        drag = rub.force_by_speed + g * rub.force_by_bend * rub.bend_d_by_speed * self.bent
        self.inertia = plant.motor_inertia + g * plant.travel * (plant.travel * self.both + drag)
        series = self.both * (1 - g * plant.travel**2 * self.both / self.inertia)
        damped = self.mass + g * np.einsum("imb,mb,jmb->ijb", at.Z, series, at.Z)
        damped += g * at.joint_damping
        self.factors = factor(damped)

    def solve(self, r: Array) -> Array:
        """r, k: (rows, B)."""
        s, g, rub, Z = self.system, self.g, self.rub, self.Z
        plant = s.plant
        travel = plant.travel
        k = r.copy()
        pull = self.stiffness * (travel * r[s.theta] - np.einsum("imb,ib->mb", Z, r[s.alpha]))
        rubbed = rub.force_by_bend * self.bent * r[s.bend]
        free = (plant.motor_inertia * r[s.theta_d] - g * travel * (pull + rubbed)) / self.inertia
        torque = np.einsum("imb,mb->ib", Z, pull + travel * self.both * free)
        k[s.alpha_d] = solve(self.factors, np.einsum("ijb,jb->ib", self.mass, r[s.alpha_d]) + g * torque)
        k[s.theta_d] = free + g * travel * self.both * np.einsum("imb,ib->mb", Z, k[s.alpha_d]) / self.inertia
        k[s.alpha] = r[s.alpha] + g * k[s.alpha_d]
        k[s.theta] = r[s.theta] + g * k[s.theta_d]
        k[s.bend] = self.bent * (r[s.bend] + g * rub.bend_d_by_speed * k[s.theta_d])
        return k
