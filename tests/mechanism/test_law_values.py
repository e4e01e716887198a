"""The numbers of every law, computed by hand: where a term saturates, halves, or has its reference."""

import math
from dataclasses import replace

import numpy as np
import pytest

from mechanism.arm import arm_of
from mechanism.description import read_neck
from mechanism.laws import LAWS, CableMotion, JointMotion, MotorMotion, Sliding
from tests.paths import NECK_FILE

ARM = arm_of(read_neck(NECK_FILE))
FAST = 1e9
"""rad/s: dry friction is whole to 1e-8 of it; its cm is none that could be a default"""


def of_cables(**values: float) -> dict[str, np.ndarray]:
    return {name: np.full(4, value) for name, value in values.items()}


def cable(x: float = 0.0, x_d: float = 0.0, travel_d: float = 0.0, length: float = 1.0) -> CableMotion:
    return CableMotion(np.full(4, x), np.full(4, x_d), np.full(4, length), ARM, np.full(4, travel_d))


def motor(theta_d: float, tension: float = 0.0, wrap: float = 0.0) -> MotorMotion:
    return MotorMotion(np.full(4, theta_d), np.full(4, tension), np.full(4, wrap))


def pull(name: str, values: dict[str, np.ndarray], at: CableMotion, z: float = 0.0) -> float:
    return _one(LAWS[name].pull(values, at, np.full((4, 1), z)))


def rate(name: str, values: dict[str, np.ndarray], at: CableMotion, z: float = 0.0) -> float:
    return _one(LAWS[name].memory_rate(values, at, np.full((4, 1), z)))


def friction(name: str, values: dict[str, np.ndarray], at: MotorMotion) -> float:
    return _one(LAWS[name].friction(values, at))


def _one(found: np.ndarray) -> float:
    assert len(found) == 4
    assert np.ptp(found) == 0
    return float(found.flat[0])


def test_dry_friction_is_half_where_the_arc_tangent_is_a_quarter_turn() -> None:
    """(48): atan(1) is pi/4, so fs/2 at theta' = 1/cm; whole at speed, and of the other sign the other way."""
    values = of_cables(fs=18.0, cm=0.25)
    assert friction("dry_friction", values, motor(4.0)) == pytest.approx(9.0, rel=1e-12)
    assert friction("dry_friction", values, motor(-4.0)) == pytest.approx(-9.0, rel=1e-12)
    assert friction("dry_friction", values, motor(FAST)) == pytest.approx(18.0, rel=1e-8)


def test_viscous_friction_is_in_proportion_to_the_motors_speed() -> None:
    assert friction("viscous_friction", of_cables(fv=0.03), motor(-70.0)) == pytest.approx(-2.1, rel=1e-12)


@pytest.mark.parametrize("ns", [1.0, 2.0, 40.0])
@pytest.mark.parametrize("way", [-1, 1])
def test_stribecks_friction_fades_as_its_power_says(ns: float, way: int) -> None:
    """At theta' = vs sqrt(ns) it has fallen to 2^-ns of fst, whatever ns; at vs with ns = 2 to (2/3)^2."""
    values = of_cables(fst=6.0, vs=20.0, ns=ns, cm=0.25)
    speed = way * 20.0 * math.sqrt(ns)
    dry = 2 / math.pi * math.atan(0.25 * speed)
    assert friction("stribeck_friction", values, motor(speed)) == pytest.approx(6.0 * 2**-ns * dry, rel=1e-12)
    if ns == 2.0:
        dry = 2 / math.pi * math.atan(5.0)
        assert friction("stribeck_friction", values, motor(20.0)) == pytest.approx(6.0 * 4 / 9 * dry, rel=1e-12)


def test_pulley_friction_is_eytelweins() -> None:
    """0.2 a radian over two turns and a half: e^pi - 1 = 22.14 times the tension to pull in, 1 - e^-pi = 0.957 to give way."""
    values = of_cables(mu=0.2, cm=0.25)
    wound_in = friction("pulley_friction", values, motor(FAST, 10.0, 5 * math.pi))
    given_way = friction("pulley_friction", values, motor(-FAST, 10.0, 5 * math.pi))
    assert wound_in == pytest.approx(10 * (math.exp(math.pi) - 1), rel=1e-7)
    assert given_way == pytest.approx(-10 * (1 - math.exp(-math.pi)), rel=1e-7)
    slowly = friction("pulley_friction", values, motor(4.0, 10.0, 5 * math.pi))
    assert slowly == pytest.approx(10 * (math.exp(math.pi / 2) - 1), rel=1e-12)


def test_along_the_arm_a_cable_loses_by_the_way_it_slides() -> None:
    """0.2 a radian over half a turn: e^-0.628 = 0.533 of the tension arrives where it is drawn in; half of the log at 0.53 vp."""
    values = of_cables(ma=0.2, vp=1e-3, wm=0.0)

    def loss(speed: float) -> float:
        at = Sliding(*np.full((3, 1, 4), [[[speed]], [[math.pi]], [[0.0]]]))
        return _one(LAWS["pulley_friction"].loss(values, at)[0])

    assert math.exp(-loss(1.0)) == pytest.approx(0.5335, rel=1e-4)
    assert loss(-1.0) == pytest.approx(-loss(1.0), rel=1e-12)
    half = 1e-3 * (2**2.7 - 1) ** (-1 / 2.7)
    assert loss(half) == pytest.approx(0.5 * loss(1.0), rel=1e-5)


@pytest.mark.parametrize(
    ("share", "wrap"),
    [(0.0, [1.0, 2.4, 4.1]), (0.5, [1.2, 2.45, 3.85]), (-0.5, [0.5, 1.9, 5.1]), (1.0, [1.4, 2.5, 3.6])],
)
def test_a_share_of_what_is_wound_slides_with_the_span_below_or_above(share: float, wrap: list[float]) -> None:
    """By hand, of three mechanisms with 1, 2 and 3 rad before their spans and 0.4, 0.5 and 0.6 behind: all of it stays 7.5."""
    at = Sliding(np.zeros((3, 1)), np.array([[1.0], [2.0], [3.0]]), np.array([[0.4], [0.5], [0.6]]))
    np.testing.assert_allclose(at.wrap(np.array([share]))[:, 0], wrap, rtol=1e-12)
    assert sum(wrap) == pytest.approx(7.5, rel=1e-12)


def test_a_linear_cable_is_a_spring_and_a_damper() -> None:
    values = of_cables(k=8e3, ca=60.0)
    assert pull("linear_cable", values, cable(0.004, -0.1)) == pytest.approx(32.0 - 6.0, rel=1e-12)


def test_youngs_modulus_is_over_the_cables_own_length_or_the_one_in_the_pose() -> None:
    """3 GPa times 1 mm and 1 MPa s times 2 mm/s, times section over length."""
    values = of_cables(E=3e9, c=1e6)
    at = cable(1e-3, 2e-3, length=0.7)
    per_length = ARM.section * (3e6 + 2e3)
    law = LAWS["youngs_modulus"].pull(values, at, np.zeros((4, 0)))
    np.testing.assert_allclose(law, per_length / ARM.cable_length, rtol=1e-12)
    in_pose = LAWS["youngs_modulus_in_pose"].pull(values, at, np.zeros((4, 0)))
    np.testing.assert_allclose(in_pose, per_length / 0.7, rtol=1e-12)


@pytest.mark.parametrize("power", [1.5, 2.0, 3.0])
def test_a_hardening_cables_powers_agree_at_five_millimetres(power: float) -> None:
    """k2 is the documented number, N/m^2: k2 (5 mm)^2 at 5 mm for every power, 2^nh times as much at 10 mm, none when slack."""
    values = of_cables(k2=2e5, nh=power)
    assert pull("cable_hardening", values, cable(5e-3)) == pytest.approx(5.0, rel=1e-12)
    assert pull("cable_hardening", values, cable(10e-3)) == pytest.approx(5.0 * 2**power, rel=1e-12)
    assert pull("cable_hardening", values, cable(-5e-3)) == 0.0


def test_presliding_friction_follows_the_bend_in_place_of_the_speed() -> None:
    """At 4 rad/s dry friction of 1 N is (2/pi) atan 2; bristles bent by half are 0.5 N; they turn over within a few wp."""
    values = of_cables(fp=10.0, wp=0.05) | {"cm": np.array([0.5])}
    at = replace(motor(4.0), memory=np.full((4, 1), 0.5))
    expected = 10.0 * (0.5 - 2 / math.pi * math.atan(2.0))
    assert friction("presliding_friction", values, at) == pytest.approx(expected, rel=1e-12)
    turning = cable(travel_d=0.01 * ARM.drum[0])
    assert rate("presliding_friction", values, turning) == pytest.approx(0.2, rel=1e-12)
    assert rate("presliding_friction", values, turning, z=1.0) == pytest.approx(0.0, abs=1e-15)
    assert rate("presliding_friction", values, turning, z=-1.0) == pytest.approx(0.4, rel=1e-12)


def test_hysteresis_saturates_at_its_height() -> None:
    """z' = (x' - |x'| z) / xh: z = 1 - exp(-x/xh) on the way up, rest at 1; from there the other way twice as fast, to -1."""
    values = of_cables(h=3.0, xh=2e-4)
    assert pull("cable_hysteresis", values, cable(), z=0.5) == pytest.approx(1.5, rel=1e-12)
    assert rate("cable_hysteresis", values, cable(x_d=0.01)) == pytest.approx(50.0, rel=1e-12)
    assert rate("cable_hysteresis", values, cable(x_d=0.01), z=1.0) == 0.0
    assert rate("cable_hysteresis", values, cable(x_d=-0.01), z=1.0) == pytest.approx(-100.0, rel=1e-12)
    assert rate("cable_hysteresis", values, cable(x_d=-0.01), z=-1.0) == 0.0


def test_slack_takes_back_what_spring_and_damper_push() -> None:
    """A cable 1 mm too long that is let out by 0.1 m/s would push with 8 + 6 N; one that is wound in so fast that it pulls, not."""
    values = of_cables(k=8e3, ca=60.0, slack=1.0, xs=1e-6)
    assert pull("cable_slack", values, cable(-1e-3, -0.1)) == pytest.approx(14.0, rel=1e-12)
    assert pull("cable_slack", values, cable(-1e-3, 0.1)) == pytest.approx(2.0, rel=1e-12)
    assert pull("cable_slack", values, cable(-1e-3, 0.2)) == pytest.approx(0.0, abs=1e-12)
    assert pull("cable_slack", values | of_cables(slack=0.25), cable(-1e-3, -0.1)) == pytest.approx(3.5, rel=1e-12)


def test_a_cable_comes_taut_within_the_elongation_that_the_law_says() -> None:
    """8000 N/m times .5 mm are 4 N: log 2 of that where the linear cable pulls with nothing, log(1 + e^2) of it at 8 N, and
    log(1 + e^-2) of it where it would push with 8 N."""
    values = of_cables(k=8e3, ca=0.0, slack=1.0, xs=5e-4)
    for x, whole in ((0.0, 4 * 0.6931471805599453), (1e-3, 4 * 2.1269280110429727), (-1e-3, 4 * 0.12692801104297263)):
        assert 8e3 * x + pull("cable_slack", values, cable(x, 0.0)) == pytest.approx(whole, rel=1e-12)


@pytest.mark.parametrize("way", [-1.0, 1.0])
def test_backlash_is_crossed_while_the_motor_travels_as_said(way: float) -> None:
    """The side goes from -1 to 1, by 2, while the motor travels pb times 2 play: 20 mm/s over 2 x 0.5 x 1 mm take 50 ms."""
    values = of_cables(k=8e3, ca=60.0, play=1e-3, pb=0.5)
    at = cable(travel_d=way * 0.02)
    side_d = rate("backlash", values, at, z=-way)
    assert side_d == pytest.approx(way * 2 / 0.05, rel=1e-12)
    # what is bounded forgets nothing: sums over a recording rest on it
    assert rate("backlash", values, at, z=0.3 * way) == side_d
    # from the far flank the drum lags on by half the play, and slower by half of 1 mm in 25 ms for the damper
    assert pull("backlash", values, at, z=-way) == pytest.approx(way * (8e3 * 5e-4 - 60.0 * 0.02), rel=1e-12)
    # halfway it is in the middle: the spring has its way, only the damper feels that the drum stands still
    assert pull("backlash", values, at, z=0.0) == pytest.approx(-way * 60.0 * 0.02, rel=1e-12)
    # on the flank there is nothing left to cross
    assert pull("backlash", values, at, z=way) == pytest.approx(-way * 8e3 * 5e-4, rel=1e-12)
    # a thousandth off the flank is on it, two thousandths are not
    assert pull("backlash", values, at, z=0.9995 * way) == pytest.approx(-way * 0.9995 * 4.0, rel=1e-12)
    assert pull("backlash", values, at, z=0.998 * way) == pytest.approx(-way * (0.998 * 4.0 + 1.2), rel=1e-12)


def test_without_play_the_crossing_is_ten_micrometres_long() -> None:
    assert rate("backlash", of_cables(play=0.0, pb=0.5), cable(travel_d=0.02)) == pytest.approx(2000.0, rel=1e-12)
    assert LAWS["backlash"].memory_bound == 1.0


def test_creep_is_a_spring_and_a_dashpot_in_line() -> None:
    values = of_cables(km=500.0, tau=4.0)
    assert pull("cable_creep", values, cable(), z=7.0) == 7.0
    assert rate("cable_creep", values, cable(x_d=0.02), z=7.0) == pytest.approx(10.0 - 1.75, rel=1e-12)


def test_a_toe_takes_away_k_xt_in_the_end() -> None:
    values = of_cables(k=8e3, xt=1e-3)
    assert pull("cable_toe", values, cable(2e-3)) == pytest.approx(8.0 * (math.exp(-2.0) - 1), rel=1e-12)
    assert pull("cable_toe", values, cable(-2e-3)) == 0.0
    assert pull("cable_toe", of_cables(k=8e3, xt=0.0), cable(2e-3)) == pytest.approx(-8e3 * 1e-9, rel=1e-9)


def test_joint_friction_at_its_width() -> None:
    """s = 1: cj / 2^(1/nj); a viscous part beside it."""
    values = {"cj": np.full(3, 0.02), "dj": np.full(3, 0.1), "vj": np.array([0.05]), "nj": np.array([2.0])}
    found = LAWS["joint_friction"].resistance(values, JointMotion(np.zeros(3), np.full(3, -0.05)))
    np.testing.assert_allclose(found, -(0.02 / math.sqrt(2) + 0.005), rtol=1e-12)


def test_what_acts_where_the_log_says_otherwise() -> None:
    """10 % too much said, 3 N too much said, and a lag of 4 ms: after one row of 2 ms a third of a step."""
    f = np.array([[0.0] * 4, [22.0] * 4, [22.0] * 4])
    gain, offset = LAWS["actuator_gain"], LAWS["actuator_offset"]
    np.testing.assert_allclose(gain.acting_force(of_cables(g=0.1), f, 0.002)[1], 20.0, rtol=1e-12)
    np.testing.assert_allclose(gain.commanded_force(of_cables(g=0.1), f, 0.002)[1], 24.2, rtol=1e-12)
    np.testing.assert_allclose(offset.acting_force(of_cables(fo=3.0), f, 0.002)[1], 19.0, rtol=1e-12)
    np.testing.assert_allclose(offset.commanded_force(of_cables(fo=3.0), f, 0.002)[1], 25.0, rtol=1e-12)
    late = LAWS["actuator_lag"].acting_force({"taul": np.array([0.004])}, f, 0.002)
    expected = [0.0, 22 / 3, 22 * 5 / 9]
    np.testing.assert_allclose(late, np.outer(expected, np.ones(4)), rtol=1e-12)
    told = LAWS["actuator_lag"].commanded_force({"taul": np.array([0.004])}, late, 0.002)
    np.testing.assert_allclose(told, f, atol=1e-12)


def test_a_lag_of_nothing_is_none_and_each_of_a_batch_has_its_own() -> None:
    f = np.random.default_rng(0).normal(50, 9, (6, 4))
    law = LAWS["actuator_lag"]
    np.testing.assert_allclose(law.acting_force({"taul": np.zeros(1)}, f, 0.002), f, rtol=1e-12)
    of_motors = {"taul": np.array([0.0, 0.004, 0.004, 0.02])}
    for j, lag in enumerate(of_motors["taul"]):
        alone = law.acting_force({"taul": np.array([lag])}, f, 0.002)[:, j]
        np.testing.assert_allclose(law.acting_force(of_motors, f, 0.002)[:, j], alone, rtol=1e-12)
    both = law.acting_force({"taul": np.array([0.003, 0.02])[:, None, None]}, f, 0.002)
    assert both.shape == (2, 6, 4)
    for k, lag in enumerate((0.003, 0.02)):
        np.testing.assert_allclose(both[k], law.acting_force({"taul": np.array([lag])}, f, 0.002), rtol=1e-12)


ARMS = {
    "g": (-0.3, 0.3),
    "taul": (0.0, 0.05),
    "fo": (-200.0, 200.0),
    "play": (0.0, 5e-3),
    "pb": (0.2, 2.0),
    "km": (0.0, 2e5),
    "tau": (0.2, 50.0),
    "fs": (0.0, 500.0),
    "cm": (0.05, 10.0),
    "k2": (0.0, 2e8),
    "nh": (1.5, 5.0),
    "h": (0.0, 200.0),
    "xh": (5e-5, 5e-3),
    "cj": (0.0, 2.0),
    "dj": (0.0, 2.0),
    "vj": (0.01, 0.5),
    "nj": (1.0, 5.0),
    "k": (50.0, 1e6),
    "ca": (0.0, 10000.0),
    "mu": (0.0, 0.1),
    "ma": (0.0, 0.1),
    "vp": (3e-4, 5e-3),
    "wm": (-1.0, 1.0),
    "slack": (0.0, 1.0),
    "xs": (5e-6, 9e-4),
    "fst": (0.0, 200.0),
    "fp": (0.0, 500.0),
    "wp": (0.005, 0.5),
    "vs": (3.0, 100.0),
    "ns": (0.7, 20.0),
    "xt": (0.0, 5e-3),
    "fv": (0.0, 2.0),
    "E": (5e8, 3e11),
    "c": (0.0, 5e9),
    "z0": (-3000.0, 3000.0),
    "bend0": (-1.0, 1.0),
    "loop0": (-1.0, 1.0),
}
"""what motors, cables and joints from a workshop have: least and most, in the terms' units"""


@pytest.mark.parametrize("name", LAWS)
def test_terms_may_be_what_arms_have_and_not_much_else(name: str) -> None:
    """Ranges hold it and not ten times as much. What is never below nothing stays so. A change is a part of what there may be."""
    start = LAWS[name].memory_start
    for term in (*LAWS[name].terms, *([start] if start else [])):
        least, most = ARMS[term.name]
        assert term.low <= least < most <= term.high
        assert term.high <= 10 * most
        assert (term.low == 0) == (least == 0)
        assert (term.low < 0) == (least < 0)
        assert least / 10 <= term.low or least < 0
        assert term.low >= 10 * least or least >= 0
        assert most / 1000 <= term.size <= 0.6 * most or term.name == "slack"
