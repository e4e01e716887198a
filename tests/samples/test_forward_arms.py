"""Arms integrated forward: geometry, energy and files of a generator that shares no code with what reads them."""

import ast
import json
import sys
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import yaml
from numpy.typing import NDArray

from mechanism import cable_lengths, dynamics
from mechanism.arm import Arm as ReadArm
from mechanism.arm import arm_of
from mechanism.description import read_neck
from mechanism.friction import dry
from samples.forward_arms.arms import Arm, Truth, make_arms
from samples.forward_arms.cables import NONE, WORDS, lengths, levers
from samples.forward_arms.drawing import built, drawn, neck
from samples.forward_arms.dynamics import equations
from samples.forward_arms.files import write_arm
from samples.forward_arms.forward import System
from samples.forward_arms.friction import friction
from samples.forward_arms.integration import rosenbrock_step, runge_step
from samples.forward_arms.joints import folded, placed
from samples.forward_arms.laws import Law, Payload, Snapshot, Tilt, ViscousFriction, gathered
from samples.forward_arms.plant import ROW, Plant, side_by_side
from samples.forward_arms.settings import Settings
from synchronisation.angles import read_angles
from synchronisation.encoder_log import read_log
from tests.paths import ROOT

Array = NDArray[np.float64]
ODD_ROUTES = (
    ("left",),
    ("strut_mirrored", "left"),
    ("right_through", "right"),
    ("left_through", "strut_mirrored", "left"),
    ("strut", "right_through", "right"),
)
SHORT = Settings(base="exact", seconds=3.6, step=1e-3, recordings=1, offset=(-0.1, 0.1))


def odd_plant(n: int = 3, base: str = "exact", seed: int = 5) -> Plant:
    """Unlike mechanisms with cables on every kind of route."""
    routes = tuple(r for r in ODD_ROUTES if len(r) <= n)
    settings = Settings(mechanisms=n, unlike=True, routes=routes, base="exact")
    made = drawn(settings, seed)
    changed = {"near": {"hyperbola": np.ones(made.M)}, "presliding": {"presliding": np.full(made.M, 0.05)}}
    return replace(made, **changed.get(base, {}))


def any_state(system: System, seed: int = 0) -> Array:
    """All angles and speeds unlike, cables taut or nearly so."""
    rng = np.random.default_rng(seed)
    y = np.zeros((system.size, system.plant.L.shape[1]))
    for rows, size in ((system.alpha, 0.6), (system.alpha_d, 4.0), (system.theta_d, 60.0), (system.bend, 0.9)):
        y[rows] = rng.uniform(-size, size, y[rows].shape)
    alpha = y[system.alpha]
    plant = system.plant
    wound = lengths(plant, folded(plant, alpha), alpha) - system.straight
    y[system.theta] = (rng.uniform(2e-3, 8e-3, wound.shape) - wound - plant.x0) / plant.travel
    return y


# --- geometry


def test_bars_and_diagonals_keep_their_lengths() -> None:
    plant = side_by_side([odd_plant()])
    alpha = np.random.default_rng(1).uniform(-1.2, 1.2, (3, 50))
    fold = folded(plant, alpha)
    place = placed(fold)
    half = plant.b / 2
    low_left, low_right = (place.middle[:-1] + s * half * place.along[:-1] for s in (-1, 1))
    high_left, high_right = (place.middle[1:] + s * half * place.along[1:] for s in (-1, 1))
    for a, b in ((low_left, high_right), (low_right, high_left)):
        np.testing.assert_allclose(np.abs(a - b), np.broadcast_to(plant.L, alpha.shape), rtol=1e-13)
    np.testing.assert_allclose(np.abs(high_left - low_left), fold.left, rtol=1e-13)
    np.testing.assert_allclose(np.abs(high_right - low_right), fold.right, rtol=1e-13)
    np.testing.assert_allclose(np.angle(place.along[1:] / place.along[:-1]), alpha, atol=1e-14)


def test_the_straight_pose_stands_upright_and_poses_mirror() -> None:
    plant = side_by_side([odd_plant()])
    straight = placed(folded(plant, np.zeros((3, 1))))
    height = np.cumsum(np.sqrt(plant.L**2 - plant.b**2), axis=0)
    np.testing.assert_allclose(straight.middle[1:], 1j * height, atol=1e-16)
    alpha = np.array([[0.4], [-0.7], [0.2]])
    one, other = (placed(folded(plant, s * alpha)).middle for s in (1, -1))
    np.testing.assert_allclose(other, -one.conj(), atol=1e-16)


@dataclass(frozen=True)
class Disc:
    """A pulley that a string goes around, counter-clockwise (+1) or clockwise (-1)."""

    centre: complex
    radius: float
    sense: int

    def at(self, angle: float) -> complex:
        return self.centre + self.radius * np.exp(1j * angle)

    def touched(self, seen_from: complex, leaving: bool) -> float:
        """Angle of the point at which a taut string to or from a point touches: the utmost that is seen from there."""
        side = self.sense if leaving else -self.sense
        towards = self.centre - seen_from

        best, width = 0.0, np.pi
        for _ in range(10):
            tried = best + np.linspace(-width, width, 121)
            points = self.centre + self.radius * np.exp(1j * tried)
            best = float(tried[np.argmax(side * np.angle((points - seen_from) / towards))])
            width /= 30
        return best


def string_length(discs: list[Disc], first: float, last: float | None) -> float:
    """From the point at angle `first` of the first disc to that at `last` of the last one, or to its centre."""
    total, arrived = 0.0, first
    for i, (here, there) in enumerate(pairwise(discs)):
        ends = last is None and i == len(discs) - 2
        target, leave, arrive = there.centre, 0.0, 0.0
        for _ in range(60):  # the two points of contact find each other
            leave = here.touched(target, leaving=True)
            arrive = 0.0 if ends else there.touched(here.at(leave), leaving=False)
            before, target = target, there.centre if ends else there.at(arrive)
            if abs(before - target) < 1e-13:
                break
        total += here.radius * ((here.sense * (leave - arrived)) % (2 * np.pi)) + abs(target - here.at(leave))
        arrived = arrive
    if last is not None:
        total += discs[-1].radius * ((discs[-1].sense * (last - arrived)) % (2 * np.pi))
    return total


@pytest.mark.parametrize("word", WORDS)
def test_cables_are_taut_strings(word: str) -> None:
    plant = odd_plant(1)
    alone = replace(plant, routes=np.full((1, plant.M), WORDS.index(word)))
    batch = side_by_side([alone])
    b, r = float(plant.b[0]), float(plant.r[0])
    for alpha in (-0.8, 0.0, 0.5):
        bend = np.array([[alpha]])
        fold = folded(batch, bend)
        place = placed(fold)
        corner = {(k, s): complex(place.middle[k, 0] + s * b / 2 * place.along[k, 0]) for k in (0, 1) for s in (-1, 1)}
        side = 1 if word in ("right", "right_through", "strut") else -1
        discs = [Disc(corner[0, side], r, side)]
        if "strut" in word:
            discs.append(Disc(corner[1, -side], r, -side))
        discs.append(Disc(corner[1, side], r, side))
        lowest = None if word in ("right", "left") else alpha - np.pi / 2
        expected = string_length(discs, -np.pi / 2, lowest)
        assert lengths(batch, fold, bend)[0, 0] == pytest.approx(expected, abs=1e-8)


def test_levers_are_how_lengths_change() -> None:
    plant = side_by_side([odd_plant()])
    alpha, e = np.random.default_rng(2).uniform(-0.8, 0.8, (3, 20)), 1e-6
    Z = levers(plant, folded(plant, alpha))
    for i in range(3):
        step = np.zeros_like(alpha)
        step[i] = e
        one, other = (lengths(plant, folded(plant, a), a) for a in (alpha + step, alpha - step))
        np.testing.assert_allclose(Z[i], -(one - other) / (2 * e), atol=1e-9)


# --- dynamics, against energy and against the packages' own equations


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
            y, _ = (runge_step if step == "runge" else rosenbrock_step)(system, 0.0, y, f, h)
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


def read_arm(plant: Plant, folder: Path) -> ReadArm:
    (folder / "neck.yaml").write_text(yaml.safe_dump(neck(plant)), encoding="utf-8")
    return arm_of(read_neck(folder / "neck.yaml"))


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


# --- recordings


@pytest.fixture(scope="module")
def arms() -> list[Arm]:
    return list(make_arms([11, 12], SHORT))


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


def test_the_log_counts_at_its_rows_and_holds_its_forces_from_there_on(arms: list[Arm]) -> None:
    for arm in arms:
        recording, plant = arm.recordings[0], arm.plant
        t = recording.truth.within_log()
        rows = slice(None, None, t.per_row)
        np.testing.assert_allclose(t.time[rows], recording.time, atol=1e-12)
        assert recording.time[0] == pytest.approx(0, abs=1e-12)
        count = 2 * np.pi / plant.counts
        np.testing.assert_allclose(recording.theta / count, np.round(recording.theta / count), atol=1e-9)
        assert np.abs(recording.theta - t.theta[rows]).max() <= count.max() / 2 + 1e-12
        assert errors_of_hold(recording.f, t, plant, late=0) < 0.02
        assert errors_of_hold(recording.f, t, plant, late=1) > 0.1
        assert errors_of_hold(recording.f, t, plant, late=-1) > 0.1


def errors_of_hold(f: Array, t: Truth, plant: Plant, late: int) -> float:
    """rms over rows, N: what motors' momentum gains in a row, less force, friction and tension (Simpson's rule, two steps)."""
    speed, tension = t.theta_d, t.tension
    other = plant.dry * dry(speed) + tension
    mean = (other[0:-2:2] + 4 * other[1:-1:2] + other[2::2]) / 6
    gained = plant.motor_inertia / plant.travel * (speed[2::2] - speed[0:-2:2]) / ROW
    left = (gained + mean)[5:-5] - np.roll(f[:-1], late, axis=0)[5:-5]
    return float(np.sqrt(np.mean(left**2)))


def test_commands_may_come_late() -> None:
    settings = replace(SHORT, mechanisms=1, seconds=3.0, delay=ROW)
    arm = next(make_arms([3], settings))
    t = arm.recordings[0].truth.within_log()
    assert errors_of_hold(arm.recordings[0].f, t, arm.plant, late=1) < 0.02
    assert errors_of_hold(arm.recordings[0].f, t, arm.plant, late=0) > 0.1


def test_frames_are_means_over_exposures_on_their_own_clock(arms: list[Arm]) -> None:
    recording = arms[0].recordings[0]
    settings = replace(
        SHORT, exposure=(0.01, 0.01), offset=(0.3, 0.3), skew_ppm=(50.0, 50.0), noise_deg=0.1, dropped=0.3
    )
    film, t = recording.truth.filmed(settings, [1]), recording.truth
    np.testing.assert_allclose(film.log_time, 0.3 + (1 + 50e-6) * film.stamp, atol=1e-12)
    assert 0.15 < film.dropped / (film.dropped + len(film.stamp)) < 0.45
    fine = np.linspace(-0.005, 0.005, 401)
    for frame in (20, 60):
        expected = [np.interp(film.log_time[frame] + fine, t.time, t.alpha[:, i]).mean() for i in range(3)]
        np.testing.assert_allclose(film.mean[frame], expected, atol=2e-6)
    assert np.degrees(np.std(film.seen - film.mean)) == pytest.approx(0.1, rel=0.2)


def test_a_seed_is_an_arm() -> None:
    settings = replace(SHORT, mechanisms=1, seconds=0.3, step=ROW)
    one, again, other = (next(make_arms([seed], settings)) for seed in (7, 7, 8))
    np.testing.assert_array_equal(one.recordings[0].f, again.recordings[0].f)
    np.testing.assert_array_equal(one.recordings[0].film.seen, again.recordings[0].film.seen)
    assert one.plant.L[0] != other.plant.L[0]


def test_files_are_what_xneck_reads(arms: list[Arm], tmp_path: Path) -> None:
    write_arm(arms[0], tmp_path, replace(SHORT, sigma_columns=True))
    folder, recording = tmp_path / "rec01", arms[0].recordings[0]
    described = read_neck(folder / "neck.yaml")
    log = read_log(folder / "log.csv", described)
    np.testing.assert_allclose(log.matrix("theta"), recording.theta, atol=1e-8)
    np.testing.assert_allclose(log.matrix("f"), recording.f, atol=1e-8)
    angles = read_angles(folder / "alpha.csv", 3)
    np.testing.assert_allclose(angles.alpha, recording.film.seen, atol=1e-8)
    np.testing.assert_allclose(angles.sigma, recording.film.noise, atol=1e-8)
    truth = json.loads((tmp_path / "truth.json").read_text(encoding="utf-8"))
    assert truth["recordings"]["rec01"]["offset"] == recording.film.offset
    assert truth["true"]["stiffness"] == list(arms[0].plant.stiffness)
    with np.load(tmp_path / "truth_rec01.npz") as fine:
        assert fine["alpha_ddot"].dtype == np.float64
        np.testing.assert_array_equal(fine["time"][:: arms[0].recordings[0].truth.per_row], recording.time)
        np.testing.assert_array_equal(fine["frame_alpha_mean"], recording.film.mean)


# --- hidden effects


def test_a_payload_weighs_and_is_inert_where_it_hangs() -> None:
    plant = odd_plant()
    load, at = 0.08, 0.01
    bare, loaded = side_by_side([plant]), side_by_side([Payload(load, at).altered(plant)])
    alpha, e = np.array([[0.3], [-0.5], [0.4]]), 1e-6

    def point(a: Array) -> complex:
        place = placed(folded(bare, a))
        return complex(place.middle[-1, 0] + at * place.along[-1, 0])

    slope: NDArray[np.complex128] = np.array(
        [(point(alpha + e * d[:, None]) - point(alpha - e * d[:, None])) / (2 * e) for d in np.eye(3)]
    )
    fold = folded(bare, alpha)
    with_load, without = (equations(p, fold, placed(fold), np.zeros((3, 1))) for p in (loaded, bare))
    inertia = load * (slope[:, None] * slope[None, :].conj()).real
    np.testing.assert_allclose((with_load.mass - without.mass)[..., 0], inertia, atol=1e-10)
    np.testing.assert_allclose((with_load.rest - without.rest)[:, 0], 9.81 * load * slope.imag, atol=1e-8)


def test_a_base_that_leans_left_makes_the_arm_fall_left() -> None:
    plant, angle = odd_plant(), 0.02
    leaning = side_by_side([Tilt(angle).altered(plant)])
    fold = folded(leaning, np.zeros((3, 1)))
    place = placed(fold)
    rest = equations(leaning, fold, place, np.zeros((3, 1))).rest
    weighed = plant.bar_mass * (place.middle[1:, 0] + plant.bar_com)
    weighed = weighed + plant.diagonal_mass * (place.middle[1:, 0] + place.middle[:-1, 0])
    slope = (placed(folded(leaning, np.array([[1e-6], [0], [0]]))).middle[-1, 0] - place.middle[-1, 0]) / 1e-6
    assert slope.real < 0  # joint 1 turns the arm to the left for alpha > 0
    assert rest[0, 0] < -9.81 * angle * weighed.imag.sum() / 2  # and there it is pulled


@dataclass(frozen=True)
class Settling(Law):
    """Tension that settles with time, a joint's drag, and an encoder that is off: one of each hook."""

    share: float
    off: float

    def memory_rows(self, plant: Plant) -> int:
        return plant.M

    def tension(self, s: Snapshot) -> Array:
        return -s.memory

    def memory_d(self, s: Snapshot) -> Array:
        return self.share * s.tension - s.memory

    def joint(self, s: Snapshot) -> Array:
        return -self.share * s.alpha_d

    def encoder(self, time: float, theta: Array) -> Array:
        return theta + self.off


def test_laws_act_on_their_own_arms_only() -> None:
    plants = [odd_plant(seed=s) for s in (1, 2, 3)]
    fv = np.linspace(0.01, 0.05, plants[0].M)
    laws = [[ViscousFriction(fv)], [], [Settling(0.1, 1.0), ViscousFriction(2 * fv)]]
    bare, hiding = System(side_by_side(plants)), System(side_by_side(plants), gathered(laws, plants))
    plain = any_state(bare)
    y = np.zeros((hiding.size, 3))
    y[: bare.size] = plain
    y[hiding.memory, 2] = 3.0
    f = np.full((plants[0].M, 3), 40.0)
    before, after = bare.rates(0.0, plain, f), hiding.rates(0.0, y, f)
    gain = bare.plant.travel / bare.plant.motor_inertia
    slowed = (after.state_d - np.vstack([before.state_d, np.zeros((plants[0].M, 3))]))[bare.theta_d] / gain
    speed = plain[bare.theta_d]
    np.testing.assert_allclose(slowed[:, 0], -fv * speed[:, 0], atol=1e-9)
    np.testing.assert_array_equal(slowed[:, 1], 0)
    np.testing.assert_allclose(
        before.tension[:, 2] - after.tension[:, 2], np.minimum(3.0, before.tension[:, 2]), atol=1e-9
    )
    np.testing.assert_array_equal(after.state_d[hiding.memory][:, :2], 0)
    untaut = before.tension[:, 2] > 0
    np.testing.assert_allclose(
        after.state_d[hiding.memory][untaut, 2], 0.1 * before.tension[untaut, 2] - 3.0, atol=1e-9
    )
    moved = hiding.encoder(0.0, y) - bare.encoder(0.0, plain)
    np.testing.assert_array_equal(moved[:, :2], 0)
    np.testing.assert_allclose(moved[:, 2], 1.0, atol=2 * np.pi / 2048)


def test_effects_of_a_seed_are_in_its_arm_and_its_truth(tmp_path: Path) -> None:
    settings = replace(
        SHORT, mechanisms=1, seconds=0.2, step=ROW, laws=lambda seed: [Payload(0.05)] if seed == 2 else []
    )
    plain, hiding = make_arms([1, 2], settings)
    assert plain.laws == ()
    assert hiding.plant.bar_mass[0] == pytest.approx(hiding.drawing.bar_mass[0] + 0.05)
    write_arm(hiding, tmp_path, settings)
    truth = json.loads((tmp_path / "truth.json").read_text(encoding="utf-8"))
    assert truth["hidden"] == [{"law": "Payload", "mass": 0.05, "at": 0.0}]
    described = read_neck(tmp_path / "rec01" / "neck.yaml")
    assert described.mechanisms[0].top.mass == pytest.approx(hiding.drawing.bar_mass[0])


def test_an_arm_may_differ_from_its_drawing() -> None:
    settings, off = replace(SHORT, drawing_off=1.0), []
    for seed in range(20):
        drawing = drawn(settings, seed)
        made = built(drawing, settings, seed)
        off.append(made.spring_left / drawing.spring_left - 1)
        assert np.all(made.spring_left != made.spring_right)
        assert built(drawing, SHORT, seed) is drawing
    assert 0.03 < np.std(off) < 0.07


def test_the_generator_knows_no_package_of_the_project() -> None:
    allowed = {"numpy", "scipy", "yaml"} | set(sys.stdlib_module_names)
    for path in (ROOT / "samples" / "forward_arms").glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            for name in names:
                assert name.split(".")[0] in allowed or name.startswith("samples.forward_arms"), (path.name, name)


def test_cables_that_do_not_reach_have_no_lever() -> None:
    plant = odd_plant()
    Z = levers(side_by_side([plant]), folded(side_by_side([plant]), np.zeros((3, 1))))[..., 0]
    assert np.all((Z == 0) >= (plant.routes == NONE))
    assert np.all(Z[plant.routes == NONE] == 0)
