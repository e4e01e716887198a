"""Energy, steps and friction of arms integrated forward, and the equations of the packages that they close."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from mechanism import cable_lengths, dynamics
from samples.forward_arms.arms import Arm
from samples.forward_arms.drawing import drawn
from samples.forward_arms.forward import System
from samples.forward_arms.friction import friction
from samples.forward_arms.integration import rosenbrock_step, runge_step
from samples.forward_arms.plant import side_by_side
from samples.forward_arms.settings import Settings
from tests.samples.forward_arms.plants import any_state, odd_plant, read_arm

Array = NDArray[np.float64]


@pytest.mark.parametrize("base", ["exact", "near", "presliding"])
def test_energy_grows_by_what_motors_give_and_losses_take(base: str) -> None:
    plants = [odd_plant(base=base, seed=s) for s in (1, 2, 3)]
    system = System(side_by_side([replace(p, viscous=np.full(p.M, 0.02)) for p in plants]), slack=False)
    y = any_state(system)
    plant, f = system.plant, np.random.default_rng(3).uniform(10, 60, (system.plant.M, 3))
    at = system.rates(0.0, y, f)
    e = 1e-7
    grows = (system.energy(y + e * at.state_d) - system.energy(y - e * at.state_d)) / (2 * e)
    x_d = plant.travel * y[system.theta_d] - np.einsum("imb,ib->mb", at.Z, y[system.alpha_d])
    given = f * plant.travel * y[system.theta_d]
    lost = at.friction.force * plant.travel * y[system.theta_d] + plant.damping * x_d**2
    np.testing.assert_allclose(grows, (given - lost).sum(axis=0), rtol=1e-6)


def test_energy_is_kept_over_time_and_halved_steps_err_sixteen_times_less() -> None:
    n = 2
    quiet = [replace(odd_plant(n, seed=s), dry=np.zeros(3), damping=np.zeros(3)) for s in (1, 2)]
    system = System(side_by_side(quiet), slack=False)
    start = any_state(system) * 0.3
    f = np.full((3, 2), 30.0)

    def error(h: float) -> Array:
        y = start
        for _ in range(round(0.2 / h)):
            y, _ = runge_step(system, 0.0, y, f, h)
        work = np.sum(f * system.plant.travel * (y[system.theta] - start[system.theta]), axis=0)
        return np.abs(system.energy(y) - system.energy(start) - work) / system.energy(start)

    coarse, fine = error(4e-4), error(2e-4)
    assert np.all(fine < 1e-6)
    assert np.all(fine < coarse / 16)


@pytest.mark.parametrize("damping", [20.0, 800.0])
def test_the_implicit_step_goes_where_the_explicit_one_goes(damping: float) -> None:
    system = System(side_by_side([replace(odd_plant(2, seed=s), damping=np.full(3, damping)) for s in (1, 2)]))
    f = np.full((3, 2), 40.0)
    start = any_state(system) * 0.3
    for _ in range(40):  # what is fast has died out
        start, _ = runge_step(system, 0.0, start, f, 5e-5)

    def end(step: object, h: float) -> Array:
        y = start
        for _ in range(round(0.02 / h)):
            y = (runge_step if step == "runge" else rosenbrock_step)(system, 0.0, y, f, h)[0]
        return y[system.alpha]

    truth = end("runge", 5e-5)
    errors = [np.abs(end("rosenbrock", h) - truth).max() for h in (1e-3, 5e-4, 2.5e-4)]
    assert errors[1] < 5e-7  # of the step that recordings have; 0.005 deg are 9e-5
    assert errors[2] < errors[0] / 16  # third order would be 64, second 16


@pytest.mark.parametrize("base", ["exact", "near", "presliding"])
def test_friction_slopes_are_those_of_its_force(base: str) -> None:
    plant, e = side_by_side([odd_plant(base=base)]), 1e-6
    speed = np.random.default_rng(4).uniform(-8, 8, (plant.M, 40))
    bend = np.random.default_rng(5).uniform(-0.9, 0.9, speed.shape)
    at = friction(plant, speed, bend)
    for by, step in (("speed", (e, 0.0)), ("bend", (0.0, e))):
        one, other = (friction(plant, speed + s * step[0], bend + s * step[1]) for s in (1, -1))
        for value in ("force", "bend_d"):
            slope = (getattr(one, value) - getattr(other, value)) / (2 * e)
            np.testing.assert_allclose(getattr(at, f"{value}_by_{by}"), slope, rtol=1e-5, atol=1e-6)


def test_bases_differ_where_motors_turn_over_only() -> None:
    fast, still = np.full((5, 1), 150.0), np.zeros((5, 1))
    for base, size in (("exact", 0.01), ("near", 0.01), ("presliding", 0.0)):
        plant = side_by_side([odd_plant(base=base)])
        np.testing.assert_allclose(friction(plant, fast, still + 1).force, plant.dry, rtol=size + 1e-12)
    exact, near = (friction(side_by_side([odd_plant(base=b)]), fast / 150, still).force for b in ("exact", "near"))
    assert np.all(near > 1.2 * exact)


@pytest.mark.parametrize("n", [1, 3, 6])
def test_states_close_the_equations_of_the_packages(n: int, tmp_path: Path) -> None:
    drawing = odd_plant(n) if n < 6 else drawn(Settings(mechanisms=6, unlike=True), 4)
    arm = read_arm(drawing, tmp_path)
    system = System(side_by_side([drawing] * 8))
    y = any_state(system)
    at = system.rates(0.0, y, np.full((drawing.M, 8), 30.0))
    alpha, alpha_d = y[system.alpha].T, y[system.alpha_d].T
    k = dynamics.terms(arm, alpha, alpha_d)
    pulled = np.einsum("bij,bj->bi", cable_lengths.Z(arm, alpha), at.tension.T)
    left = np.einsum("bij,bj->bi", k.M, at.alpha_dd.T) + k.c + k.g - pulled
    assert np.abs(left).max() < 1e-12


def test_true_motions_close_the_equations_of_the_packages(arms: list[Arm], tmp_path: Path) -> None:
    for made in arms:
        arm, t = read_arm(made.drawing, tmp_path), made.recordings[0].truth
        k = dynamics.terms(arm, t.alpha, t.alpha_d)
        Z = cable_lengths.Z(arm, t.alpha)
        left = np.einsum("tij,tj->ti", k.M, t.alpha_dd) + k.c + k.g - np.einsum("tij,tj->ti", Z, t.tension)
        assert np.abs(left).max() < 1e-12
        straight = cable_lengths.lengths(arm, np.zeros(3))
        x = cable_lengths.lengths(arm, t.alpha) - straight + made.plant.travel * t.theta + made.plant.x0
        x_d = made.plant.travel * t.theta_d - np.einsum("tij,ti->tj", Z, t.alpha_d)
        elastic = made.plant.stiffness * x + made.plant.damping * x_d
        np.testing.assert_allclose(t.tension, np.maximum(elastic, 0), atol=1e-9)
        assert np.degrees(np.abs(t.alpha)).max() > 10
        assert t.tension.min() > 5
        # speeds are those of the angles
        h = t.time[1] - t.time[0]
        slope = (t.alpha[2:] - t.alpha[:-2]) / (2 * h)
        assert np.abs(slope - t.alpha_d[1:-1]).max() < 1e-3
