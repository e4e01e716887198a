"""The whole in motion: convergence, batches, rest, and what may not happen."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mechanism.arm import arm_of, batch
from mechanism.cable_lengths import Z
from mechanism.description import read_neck
from mechanism.dynamics import gravity_and_springs
from mechanism.machine import Machine
from mechanism.simulation import State, fastest_rate, simulate
from xneck.errors import Refused

ARM = arm_of(read_neck(Path(__file__).parents[2] / "samples/recording/neck.yaml"))
VALUES = {
    "k": np.array([10e3, 9e3, 8e3, 5.5e3]),
    "ca": np.full(4, 60.0),
    "fs": np.array([14.0, 17, 18, 16]),
    "cm": np.array([0.5]),
    "fv": np.full(4, 0.02),
}
MACHINE = Machine(ARM, ("dry_friction", "viscous_friction", "linear_cable"), VALUES)
REST = State(np.zeros(3), np.zeros(3), np.zeros(4), np.zeros(4))
TIME = 0.002 * np.arange(100, dtype=float)


def forces(samples: int = 100) -> np.ndarray:
    t = 0.002 * np.arange(samples, dtype=float)
    return 40 + 15 * np.sin(np.outer(t, [9.0, 12.0, 7.0, 10.0]) + np.arange(4))


def test_halving_the_step_divides_the_error_by_sixteen() -> None:
    """The classical Runge-Kutta method is of order four while no cable goes slack: measured order between 3.5 and 4.5."""
    smooth = replace(MACHINE, values={**VALUES, "cm": np.array([0.02])})
    steps = [4e-4, 2e-4, 1e-4]
    fine = simulate(smooth, REST, TIME[:40], forces()[:40], max_step=2e-5).alpha[-1]
    errors = [np.max(np.abs(simulate(smooth, REST, TIME[:40], forces()[:40], h).alpha[-1] - fine)) for h in steps]
    orders = np.diff(-np.log2(errors))
    assert np.all((orders > 3.5) & (orders < 4.5))


def test_default_step_is_accurate_to_a_millionth_of_a_radian() -> None:
    coarse = simulate(MACHINE, REST, TIME, forces())
    fine = simulate(MACHINE, REST, TIME, forces(), max_step=0.2 / fastest_rate(MACHINE, REST))
    assert np.max(np.abs(coarse.alpha - fine.alpha)) < 1e-6


def test_a_batch_of_arms_and_drives_moves_as_each_alone() -> None:
    heavy = replace(ARM, top_mass=ARM.top_mass * 1.5)
    soft = {**VALUES, "k": VALUES["k"] * 0.7}
    step = 2e-4
    machines = (MACHINE, replace(MACHINE, arm=heavy, values=soft))
    alone = [simulate(machine, REST, TIME, forces(), step) for machine in machines]
    both = {name: np.stack([VALUES[name], soft[name]]) for name in VALUES}
    together = simulate(replace(MACHINE, arm=batch([ARM, heavy]), values=both), REST, TIME, forces(), step)
    for k in range(2):
        np.testing.assert_allclose(together.alpha[k], alone[k].alpha, atol=1e-12)
        np.testing.assert_allclose(together.tension[k], alone[k].tension, atol=1e-8)


def test_a_batch_of_arms_from_one_start_finds_its_own_step() -> None:
    arms = batch([ARM, replace(ARM, top_mass=ARM.top_mass * 1.2)])
    assert simulate(replace(MACHINE, arm=arms), REST, TIME[:3], forces()[:3]).alpha.shape == (2, 3, 3)


def test_windows_of_one_arm_are_a_batch_too() -> None:
    starts = State(*(np.stack([part, part + 0.01]) for part in (REST.alpha, REST.alpha_d, REST.theta, REST.theta_d)))
    f = np.stack([forces(), forces() + 1.0])
    both = simulate(MACHINE, starts, TIME, f, 2e-4)
    second = State(*(part[1] for part in (starts.alpha, starts.alpha_d, starts.theta, starts.theta_d)))
    np.testing.assert_allclose(both.alpha[1], simulate(MACHINE, second, TIME, f[1], 2e-4).alpha, atol=1e-12)


def test_in_equilibrium_nothing_moves() -> None:
    """Straight, with tensions that balance gravity and springs and forces equal to them, the arm stays to 1e-9 rad."""
    load = gravity_and_springs(ARM, np.zeros(3))
    jacobian = Z(ARM, np.zeros(3))
    balance = np.linalg.pinv(jacobian) @ load
    idle = np.linalg.svd(jacobian)[2][-1]
    tension = balance + 40 * idle / np.mean(idle) * np.sign(np.mean(idle))
    tension = tension + idle * max(0.0, 20 - tension.min()) / np.min(np.abs(idle))
    assert tension.min() > 0
    at_rest = replace(ARM, x0=tension / VALUES["k"])
    motion = simulate(replace(MACHINE, arm=at_rest), REST, TIME, np.tile(tension, (100, 1)))
    assert np.max(np.abs(motion.alpha)) < 1e-9


def test_a_cable_cannot_push() -> None:
    motion = simulate(MACHINE, REST, TIME, np.zeros((100, 4)))
    assert motion.tension.min() >= 0


def test_a_motion_out_of_range_is_refused_with_its_time() -> None:
    weightless = replace(ARM, spring_stiffness=ARM.spring_stiffness * 0)
    f = np.tile([400.0, 0, 0, 0], (400, 1))
    with pytest.raises(Refused, match=r"leaves the range.* s"):
        simulate(replace(MACHINE, arm=weightless), REST, 0.002 * np.arange(400, dtype=float), f)
