"""Hidden effects of arms integrated forward: each by what it weighs, pulls or takes."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.ladder import OUTSIDE
from mechanism import cable_lengths
from samples.forward_arms.cables import lengths, levers, wraps, wraps_before_spans
from samples.forward_arms.dynamics import equations
from samples.forward_arms.forward import System
from samples.forward_arms.integration import rosenbrock_step
from samples.forward_arms.joints import folded, placed
from samples.forward_arms.laws import (
    Hardening,
    JointFriction,
    Law,
    Payload,
    PulleyFriction,
    RouteFriction,
    Snapshot,
    Stribeck,
    Tilt,
    ViscousFriction,
    gathered,
)
from samples.forward_arms.plant import Plant, side_by_side
from tests.samples.forward_arms.plants import any_state, odd_plant, read_arm

Array = NDArray[np.float64]


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


HARDENED_AT_M = 0.004
EVERY_LAW: tuple[Law, ...] = (
    Hardening(np.full(5, 0.15 * 8000.0 / HARDENED_AT_M**2)),
    Stribeck(peak=3.0, width=12.0),
    JointFriction(np.array([0.03, 0.02, 0.04]), width=0.1),
    PulleyFriction(mu=0.02),
    ViscousFriction(np.full(5, 0.02)),
)


def hiding(law: Law, columns: int = 20) -> System:
    """Copies of one arm with the law; cables may push."""
    plants = [odd_plant()] * columns
    return System(side_by_side(plants), gathered([[law]] * columns, plants), slack=False)


def snapshot(**values: Array) -> Snapshot:
    """Of what a law looks at."""
    return Snapshot(0.0, values)


@pytest.mark.parametrize("law", EVERY_LAW, ids=lambda law: type(law).__name__)
def test_laws_give_back_no_more_than_they_took(law: Law) -> None:
    """A hardening cable stores k3 x^4 / 4; all others only take, and energy grows by what motors give less all losses."""
    system = hiding(law)
    plant, e = system.plant, 1e-7
    y = any_state(system)
    f = np.random.default_rng(3).uniform(10, 60, (plant.M, 20))
    at = system.rates(0.0, y, f)

    def energy(y: Array) -> Array:
        fold = folded(plant, y[system.alpha])
        x = lengths(plant, fold, y[system.alpha]) - system.straight + plant.travel * y[system.theta] + plant.x0
        stored = law.cubic[:, None] * x**4 / 4 if isinstance(law, Hardening) else 0 * x
        return system.energy(y) + stored.sum(axis=0)

    grows = (energy(y + e * at.state_d) - energy(y - e * at.state_d)) / (2 * e)
    wound = plant.travel * y[system.theta_d]
    x_d = wound - np.einsum("imb,ib->mb", at.Z, y[system.alpha_d])
    bare = System(plant, slack=False).rates(0.0, y, f)
    resisted = (bare.state_d - at.state_d)[system.theta_d] * plant.motor_inertia / plant.travel
    rubbed = resisted - (at.tension - bare.tension)
    driven = np.einsum("ijb,jb->ib", at.equations.mass, at.alpha_dd - bare.alpha_dd)
    driven -= np.einsum("imb,mb->ib", at.Z, at.tension - bare.tension)
    lost = rubbed * wound
    braked = -driven * y[system.alpha_d]
    assert np.all(lost > -1e-9)
    assert np.all(braked > -1e-9)
    base = (f - at.friction.force) * wound - plant.damping * x_d**2
    np.testing.assert_allclose(grows, base.sum(axis=0) - lost.sum(axis=0) - braked.sum(axis=0), rtol=1e-5)
    changes = np.abs(at.tension - bare.tension).max() + lost.max() + braked.max()
    assert changes > 1e-3


def test_a_cable_hardens_with_the_cube_of_its_elongation_and_never_pushes() -> None:
    k = 8000.0
    law = Hardening(np.array([[0.15 * k / HARDENED_AT_M**2]]))
    x = HARDENED_AT_M * np.array([[1.0, 2.0, -1.0]])
    more = law.tension(snapshot(x=x))
    np.testing.assert_allclose(more / (k * x), [[0.15, 0.6, 0.0]], atol=1e-12)


def test_stribecks_peak_fades_and_turns_over() -> None:
    """Half of it is left at width sqrt(ln 2), nothing at five widths."""
    still = np.zeros((1, 1))
    speed = 12.0 * np.sqrt(np.log(2)) * np.array([[1.0, -1.0]])
    law = Stribeck(peak=3.0, width=12.0)
    expected = 1.5 * 2 / np.pi * np.arctan(0.5 * speed)
    np.testing.assert_allclose(law.motor(snapshot(theta_d=speed)), expected, rtol=1e-12)
    assert np.abs(law.motor(snapshot(theta_d=still + 60.0))).max() < 1e-9


def test_pulleys_take_what_the_capstan_takes() -> None:
    """exp(mu wrap) times the tension to wind in, and as many times less to give way; nothing where a cable is slack."""
    plant = side_by_side([odd_plant()])
    alpha = np.random.default_rng(6).uniform(-0.8, 0.8, (3, 20))
    wrap = wraps(plant, folded(plant, alpha), alpha)
    law, tension = PulleyFriction(0.02), np.full_like(wrap, 40.0)
    held = [
        1 + law.motor(snapshot(theta_d=np.full_like(wrap, speed), tension=tension, wrap=wrap)) / tension
        for speed in (1e9, -1e9)
    ]
    np.testing.assert_allclose(held[0], np.exp(0.02 * wrap), rtol=1e-6)
    np.testing.assert_allclose(held[0] * held[1], 1, rtol=1e-12)
    np.testing.assert_array_equal(law.motor(snapshot(theta_d=np.full_like(wrap, 9.0), tension=-tension, wrap=wrap)), 0)


def test_wraps_are_those_of_the_packages(tmp_path: Path) -> None:
    drawing, alpha = odd_plant(), np.random.default_rng(7).uniform(-0.8, 0.8, (3, 20))
    plant = side_by_side([drawing])
    fold, arm = folded(plant, alpha), read_arm(drawing, tmp_path)
    np.testing.assert_allclose(wraps(plant, fold, alpha).T, cable_lengths.wrap_angles(arm, alpha.T), atol=1e-12)
    before_spans = np.moveaxis(wraps_before_spans(plant, fold, alpha), -1, 0)
    before, above = np.split(cable_lengths.geometry_of_poses(arm, alpha.T).wraps, 2, axis=1)
    below = np.pad(above, ((0, 0), (1, 0), (0, 0)))[:, :-1]
    below[:, -1] += above[:, -1]
    np.testing.assert_allclose(before_spans, before + below, atol=1e-12)


def test_joint_friction_is_as_steep_as_it_says() -> None:
    law, e = JointFriction(np.array([[0.03], [0.02], [0.04]]), width=0.05), 1e-6
    speed = np.random.default_rng(8).uniform(-0.2, 0.2, (3, 20))
    one, other = (law.joint(snapshot(alpha_d=speed + s * e)) for s in (1, -1))
    slope = np.einsum("iib->ib", law.joint_damping(snapshot(alpha_d=speed)))
    np.testing.assert_allclose(slope, (other - one) / (2 * e), rtol=1e-6)


def test_a_cable_loses_power_on_its_pulleys_whichever_way_joints_turn() -> None:
    """In all of its spans together; a step is told of the slope, to the first order in what is lost."""
    plant = side_by_side([odd_plant()])
    rng, e = np.random.default_rng(9), 1e-7
    alpha, speed = rng.uniform(-0.8, 0.8, (2, 3, 20))
    fold = folded(plant, alpha)
    whole = {
        "wraps": wraps_before_spans(plant, fold, alpha),
        "Z": levers(plant, fold),
        "tension": rng.uniform(5, 80, (plant.M, 20)),
    }
    law = RouteFriction(np.full((plant.M, 1), 1e-4), 2e-3)

    def torque(alpha_d: Array) -> Array:
        return law.joint(snapshot(alpha_d=alpha_d, **whole))

    assert np.all(np.sum(torque(speed) * speed, axis=0) < 0)
    slopes = [(torque(speed - e * u) - torque(speed + e * u)) / (2 * e) for u in np.eye(3)[..., None]]
    told = law.joint_damping(snapshot(alpha_d=speed, **whole))
    np.testing.assert_allclose(told, np.stack(slopes, axis=1), rtol=0.01, atol=1e-3 * np.abs(told).max())


@dataclass(frozen=True)
class SteepJointFriction(JointFriction):
    """The same with a slope that no step is told of."""

    def joint_damping(self, s: Snapshot) -> Array:
        return np.zeros((len(s.alpha_d), *s.alpha_d.shape))


def test_steps_may_be_long_where_the_joints_friction_is_steep() -> None:
    def end(law: Law, h: float) -> Array:
        system = hiding(law, 2)
        y, f = any_state(system) * 0.3, np.full((system.plant.M, 2), 40.0)
        for _ in range(round(0.1 / h)):
            y, _, _ = rosenbrock_step(system, 0.0, y, f, h)
        return y[system.alpha]

    dry = np.full(3, 0.03)
    truth = end(JointFriction(dry, 0.05), 6.25e-5)
    told, untold = (np.abs(end(law(dry, 0.05), 5e-4) - truth).max() for law in (JointFriction, SteepJointFriction))
    assert told < 5e-5
    assert untold > 10 * told


@pytest.mark.parametrize("law", OUTSIDE.values(), ids=OUTSIDE)
def test_what_no_catalogue_holds_changes_the_motion(law: Law) -> None:
    """Of a state somewhere in the middle, after a while: what the arm does or what its encoders see."""
    system, bare = hiding(law), System(hiding(law).plant, slack=False)
    y = any_state(system)
    y[system.memory] = 0.5
    y[system.alpha][0] = 0.3
    f = np.random.default_rng(3).uniform(10, 60, (system.plant.M, 20))
    of_plain = y[: bare.size]
    rates, plain = system.rates(4.5, y, f).state_d[: bare.size], bare.rates(4.5, of_plain, f).state_d
    moves = bool(np.any(np.abs(rates - plain) > 1e-3 * np.abs(plain) + 1e-9))
    assert moves != np.any(system.encoder(4.5, y) != bare.encoder(4.5, of_plain))
