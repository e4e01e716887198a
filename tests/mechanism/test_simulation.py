"""The whole in motion: convergence, batches, rest, and what may not happen."""

from dataclasses import replace

import numpy as np
import pytest

from mechanism.arm import arm_of, batch
from mechanism.cable_lengths import Z
from mechanism.description import read_neck
from mechanism.dynamics import gravity_and_springs
from mechanism.machine import Machine
from mechanism.simulation import MAX_STEP_S, State, simulate, simulate_given_angles
from tests.mechanism.runge_kutta import runge_kutta
from tests.paths import NECK_FILE
from xneck_foundation.errors import Refused

ARM = arm_of(read_neck(NECK_FILE))
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


def moving(samples: int = 100) -> tuple[State, np.ndarray]:
    """A state in the midst of a motion, taut and turning, and the forces from there on, of all samples."""
    t = 0.002 * np.arange(300 + samples, dtype=float)
    f = 45 + 30 * np.sin(2 * np.pi * np.outer(t, [1.1, 1.7, 1.4, 0.9]))
    motion = simulate(MACHINE, REST, t[:300], f)
    return State(*(getattr(motion, name)[-1] for name in ("alpha", "alpha_d", "theta", "theta_d"))), f[299:]


@pytest.fixture(scope="module")
def exact() -> np.ndarray:
    """By Runge and Kutta at a tenth of the step, which errs by 4e-11 rad: alpha and the cables' travel, (T, N + M)."""
    start, f = moving()
    return np.array([np.append(y.alpha, y.theta * ARM.drum) for y in runge_kutta(MACHINE, start, TIME, f, 2e-4)])


def test_steps_of_a_row_are_within_a_hundred_thousandth_of_a_radian(exact: np.ndarray) -> None:
    """In the midst of a motion of 23 deg, for 0.2 s; measured: 2.3e-6 rad."""
    start, f = moving()
    found = simulate(MACHINE, start, TIME, f)
    assert np.ptp(found.alpha, axis=0).max() > 0.3
    assert np.max(np.abs(found.alpha - exact[:, :3])) < 1e-5
    assert np.max(np.abs(found.theta * ARM.drum - exact[:, 3:])) < 1e-6


def test_halving_the_step_divides_the_error_by_four_at_least(exact: np.ndarray) -> None:
    """The pose of a step's middle is of order two, what is solved in it of order three."""
    start, f = moving()
    steps = MAX_STEP_S / np.array([1, 2, 4, 8])
    errors = [np.max(np.abs(simulate(MACHINE, start, TIME[:60], f, h).alpha[-1] - exact[59, :3])) for h in steps]
    orders = np.diff(-np.log2(errors))
    assert np.all((orders > 1.8) & (orders < 3.5)), orders


@pytest.mark.parametrize(
    "name", ["cable_hysteresis", "cable_creep", "cable_hardening", "pulley_friction", "joint_friction"]
)
def test_laws_with_memory_and_slopes_converge_to_the_same_motion(name: str) -> None:
    """Memories follow x', friction follows tension, joints rub: a wrong slope would still converge, but not as fast."""
    values = VALUES | {"km": np.full(4, 500.0), "tau": np.array([0.2]), "h": np.full(4, 2.0), "xh": np.array([2e-4])}
    values |= {
        "k2": np.full(4, 2e5),
        "nh": np.array([2.0]),
        "mu": np.full(4, 0.01),
        "ma": np.zeros(4),
        "vp": np.array([2e-3]),
        "wm": np.zeros(1),
        "vj": np.array([0.05]),
        "nj": np.array([2.7]),
    }
    values |= {"cj": np.full(3, 5e-3), "dj": np.full(3, 5e-3)}
    machine = Machine(ARM, (*MACHINE.names, name), values)
    start, f = moving(40)
    exact = runge_kutta(machine, start, TIME[:40], f, 2e-4)[-1]
    errors = [np.max(np.abs(simulate(machine, start, TIME[:40], f, h).alpha[-1] - exact.alpha)) for h in (2e-3, 5e-4)]
    assert errors[0] < 1e-4
    assert errors[1] < errors[0] / 6


def test_cables_that_rub_along_the_arm_hold_it_as_small_steps_say() -> None:
    """Joints come to rest within a row: steps are shortened by themselves. Without it the arm ends 0.01 rad elsewhere."""
    values = VALUES | {"mu": np.full(4, 0.01), "ma": np.full(4, 0.01), "vp": np.array([2e-3]), "wm": np.zeros(1)}
    machine = Machine(ARM, (*MACHINE.names, "pulley_friction"), values)
    start, f = moving(20)
    exact = runge_kutta(machine, start, TIME[:20], f, 2.5e-5)[-1].alpha
    without = simulate(replace(machine, values=values | {"ma": np.zeros(4)}), start, TIME[:20], f).alpha[-1]
    assert np.max(np.abs(simulate(machine, start, TIME[:20], f).alpha[-1] - exact)) < 1e-3
    assert np.max(np.abs(simulate(machine, start, TIME[:20], f, 1e-4).alpha[-1] - exact)) < 1e-5
    assert np.max(np.abs(without - exact)) > 1e-2


def test_slack_cables_come_back_taut_as_they_should() -> None:
    """Motors pushed back for 40 ms: a step errs more where a cable lets go or snaps taut, and less the smaller it is."""
    start, f = moving()
    f = np.where((np.arange(len(f)) < 20)[:, None], -100.0, f)
    exact = runge_kutta(MACHINE, start, TIME, f, 2e-4)
    found = [simulate(MACHINE, start, TIME, f, h) for h in (2e-3, 5e-4)]
    assert (found[0].tension.min(axis=0) == 0).any()
    errors = [np.max(np.abs(one.alpha - [y.alpha for y in exact])) for one in found]
    assert errors[0] < 5e-3
    assert errors[1] < errors[0] / 4


def test_stiffest_damping_needs_no_smaller_steps() -> None:
    """2000 N s/m is 80 times what an explicit step of a row could take; the motion is that of small steps within 1e-4 rad."""
    machine = replace(MACHINE, values=VALUES | {"ca": np.full(4, 2000.0)})
    start, f = moving()
    coarse, fine = (simulate(machine, start, TIME, f, h).alpha for h in (2e-3, 2.5e-4))
    assert np.max(np.abs(coarse - fine)) < 1e-4


def test_motors_that_are_led_move_the_arm_as_the_forces_that_led_them_there() -> None:
    """The motion under forces, its motors' angles given instead: the same angles of the arm, and the forces back."""
    start, f = moving()
    forced = simulate(MACHINE, start, TIME, f, 2.5e-4)
    turning = np.gradient(forced.theta_d, 0.002, axis=0)
    led = simulate_given_angles(MACHINE, start, TIME, (forced.theta, forced.theta_d, turning))
    np.testing.assert_allclose(led.alpha, forced.alpha, atol=1e-5)
    around = (forced.f[:-1] + forced.f[1:])[2:-2] / 2  # held from row to row: at a row, half of either
    np.testing.assert_allclose(led.f[3:-2], around, atol=0.02 * np.ptp(f))


def test_a_batch_of_arms_and_drives_moves_as_each_alone() -> None:
    heavy = replace(ARM, top_mass=ARM.top_mass * 1.5)
    soft = {**VALUES, "k": VALUES["k"] * 0.7}
    machines = (MACHINE, replace(MACHINE, arm=heavy, values=soft))
    alone = [simulate(machine, REST, TIME, forces()) for machine in machines]
    both = {name: np.stack([VALUES[name], soft[name]]) for name in VALUES}
    together = simulate(replace(MACHINE, arm=batch([ARM, heavy]), values=both), REST, TIME, forces())
    for k in range(2):
        np.testing.assert_allclose(together.alpha[k], alone[k].alpha, atol=1e-12)
        np.testing.assert_allclose(together.tension[k], alone[k].tension, atol=1e-8)


def test_a_batch_of_arms_may_start_from_one_state() -> None:
    arms = batch([ARM, replace(ARM, top_mass=ARM.top_mass * 1.2)])
    assert simulate(replace(MACHINE, arm=arms), REST, TIME[:3], forces()[:3]).alpha.shape == (2, 3, 3)


def test_windows_of_one_arm_are_a_batch_too() -> None:
    starts = State(*(np.stack([part, part + 0.01]) for part in (REST.alpha, REST.alpha_d, REST.theta, REST.theta_d)))
    f = np.stack([forces(), forces() + 1.0])
    both = simulate(MACHINE, starts, TIME, f)
    second = State(*(part[1] for part in (starts.alpha, starts.alpha_d, starts.theta, starts.theta_d)))
    np.testing.assert_allclose(both.alpha[1], simulate(MACHINE, second, TIME, f[1]).alpha, atol=1e-12)


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
