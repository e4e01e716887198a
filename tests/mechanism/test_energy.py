"""Power is balanced: what the motors put in is stored, or lost to friction and damping (model conventions (41)-(45)).

The balance holds only for one consistent choice of signs of Z, theta, x and f, so it pins them.
"""

import numpy as np
import pytest

from mechanism.arm import Arm, arm_of
from mechanism.cable_lengths import Z
from mechanism.description import read_neck
from mechanism.dynamics import coriolis, gravity_and_springs, mass_matrix, potential_energy
from mechanism.elasticity import elongation, elongation_rate
from mechanism.laws import LAWS, MotorMotion
from mechanism.machine import Machine
from mechanism.simulation import Motion, State, simulate

K = np.array([10000.0, 9000.0, 8000.0, 5500.0])
FRICTION, CABLE = ("dry_friction", "viscous_friction"), ("linear_cable",)


def values(ca: float, fs: float, fv: float) -> dict[str, np.ndarray]:
    return {"k": K, "ca": np.full(4, ca), "fs": np.full(4, fs), "fv": np.full(4, fv), "cm": np.array([0.5])}


@pytest.fixture(scope="module")
def arm() -> Arm:
    return arm_of(read_neck("samples/recording/neck.yaml"))


def stored(arm: Arm, motion: Motion) -> np.ndarray:
    """Energy of arm, cables (none when slack) and motors, shape (T,), J."""
    alpha_d = motion.alpha_d
    x = np.maximum(elongation(arm, motion.alpha, motion.theta), 0.0)
    return (
        np.einsum("ti,tij,tj->t", alpha_d, mass_matrix(arm, motion.alpha), alpha_d) / 2
        + potential_energy(arm, motion.alpha)
        + np.sum(K * x**2, axis=-1) / 2
        + np.sum(arm.motor_inertia * motion.theta_d**2, axis=-1) / 2
    )


def moved(arm: Arm, ca: float, fs: float, fv: float, step: float, sample: float = 1e-3) -> tuple[Motion, np.ndarray]:
    """0.25 s from a bent pose under changing forces, held over every sample, shape (T, M), N."""
    time = np.linspace(0, 0.25, round(0.25 / sample) + 1)
    f = 45 + 25 * np.sin(2 * np.pi * time[:, None] * np.array([1.1, 1.7, 1.4, 0.9]))
    alpha = np.array([0.2, -0.15, 0.1])
    theta = (0.006 - elongation(arm, alpha, np.zeros(4))) / arm.drum  # every cable taut at first
    start = State(alpha, np.array([0.5, -1.0, 2.0]), theta, np.zeros(4))
    return simulate(Machine(arm, FRICTION + CABLE, values(ca, fs, fv)), start, time, f, max_step=step), f


def work_of_motors(arm: Arm, motion: Motion, f: np.ndarray) -> np.ndarray:
    """Work put in up to each sample, shape (T,), J: exact, as f is held while theta moves on."""
    travel = arm.drum * np.diff(motion.theta, axis=0)
    return np.concatenate([[0.0], np.cumsum(np.sum(f[:-1] * travel, axis=-1))])


def test_without_losses_the_motors_work_is_stored(arm: Arm) -> None:
    """d/dt (kinetic + potential + elastic + motor) = f (rd/R) theta': what is left is the integrator's, at least of second order.

    Undamped, cables ring at 450 rad/s: an implicit method takes a part of that away, the less the smaller its steps.
    """
    left = []
    for step in (2e-4, 1e-4):
        motion, f = moved(arm, ca=0.0, fs=0.0, fv=0.0, step=step)
        work, energy = work_of_motors(arm, motion, f), stored(arm, motion)
        assert np.ptp(work) > 0.1, "the motors did work"
        left.append(np.abs(energy - energy[0] - work).max())
    # a wrong sign or factor would leave a part of the work, 0.1 J and more
    assert left[1] < 1e-4
    assert left[1] < left[0] / 4


def test_losses_are_those_of_friction_and_damping(arm: Arm) -> None:
    """With losses, what is missing is their power's integral (by trapezoids).

    From 10 ms on: damping ends the first jerk in 0.4 ms, too fast for the trapezoids.
    """
    ca, fs, fv = 60.0, 15.0, 0.05
    motion, f = moved(arm, ca, fs, fv, step=2.5e-4, sample=2.5e-4)
    missing = work_of_motors(arm, motion, f) - (stored(arm, motion) - stored(arm, motion)[0])
    x_d = elongation_rate(arm, Z(arm, motion.alpha), motion.alpha_d, motion.theta_d)
    turning = MotorMotion(motion.theta_d, motion.tension, np.zeros(()))
    rubbing = sum(LAWS[name].friction(values(ca, fs, fv), turning) for name in FRICTION) * arm.drum * motion.theta_d
    damping = motion.tension - K * np.maximum(elongation(arm, motion.alpha, motion.theta), 0.0)
    power = np.sum(damping * x_d + rubbing, axis=-1)
    lost = np.concatenate([[0.0], np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(motion.time))])
    assert power.min() >= 0
    assert missing[-1] > 0.1
    begun = round(0.01 / 2.5e-4)
    np.testing.assert_allclose(
        (missing - missing[begun])[begun:], (lost - lost[begun])[begun:], rtol=0, atol=1e-4 * missing[-1]
    )


def test_g_is_the_slope_of_the_potential_energy(arm: Arm) -> None:
    """g = dV/dalpha by central differences: h^2 V''' / 6 with h = 1e-5 and rounding 1e-16 / h."""
    alpha = np.random.default_rng(2).uniform(-0.8, 0.8, (20, 3))
    moves = 1e-5 * np.eye(3)[:, None, :]
    slope = (potential_energy(arm, alpha + moves) - potential_energy(arm, alpha - moves)) / 2e-5
    np.testing.assert_allclose(gravity_and_springs(arm, alpha), slope.T, rtol=0, atol=1e-9)


def test_c_does_the_work_that_the_mass_matrix_lacks(arm: Arm) -> None:
    """alpha' c = alpha' M' alpha' / 2 (the energy's balance), and c is quadratic in alpha'."""
    rng = np.random.default_rng(3)
    alpha, alpha_d = rng.uniform(-0.8, 0.8, (20, 3)), rng.uniform(-3, 3, (20, 3))
    h = 1e-5
    M_dot = (mass_matrix(arm, alpha + h * alpha_d) - mass_matrix(arm, alpha - h * alpha_d)) / (2 * h)
    c = coriolis(arm, alpha, alpha_d)
    np.testing.assert_allclose(
        np.sum(alpha_d * c, axis=-1), np.einsum("ti,tij,tj->t", alpha_d, M_dot, alpha_d) / 2, rtol=0, atol=1e-9
    )
    np.testing.assert_allclose(coriolis(arm, alpha, -2 * alpha_d), 4 * c, rtol=1e-12, atol=1e-15)


def test_cables_do_on_the_arm_what_they_take_from_the_drums(arm: Arm) -> None:
    """Rigid cables (x' = 0): the power Z t alpha' on the arm equals t (rd/R) theta' at the drums."""
    rng = np.random.default_rng(4)
    alpha, alpha_d, t = rng.uniform(-0.8, 0.8, (20, 3)), rng.uniform(-3, 3, (20, 3)), rng.uniform(10, 90, (20, 4))
    theta_d = np.einsum("tij,ti->tj", Z(arm, alpha), alpha_d) / arm.drum
    np.testing.assert_allclose(elongation_rate(arm, Z(arm, alpha), alpha_d, theta_d), 0, atol=1e-15)
    on_arm = np.einsum("ti,tij,tj->t", alpha_d, Z(arm, alpha), t)
    np.testing.assert_allclose(on_arm, np.sum(t * arm.drum * theta_d, axis=-1), rtol=1e-12)
