"""Laws that are hidden in arrays, and found: by their variable, form and numbers, in white noise and in noise that remembers."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

from discovery.discover import discover
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]
Signals = Mapping[str, Array]

TIME = np.arange(0.0, 60.0, 0.02)


def signals(seed: int) -> dict[str, Array]:
    """Motions of sums of sines."""
    rng = np.random.default_rng([71, seed])

    def sum_of_sines(size: float) -> Array:
        waves = zip(rng.uniform(0.3, 1, 4), rng.uniform(0.3, 5, 4), rng.uniform(0, 6, 4), strict=True)
        return size * np.sum([a * np.sin(w * TIME + p) for a, w, p in waves], axis=0)

    theta, alpha = sum_of_sines(8.0), sum_of_sines(0.3)
    return {
        "motor_angle": theta,
        "drum_angle": theta / 4.3,
        "motor_speed": np.gradient(theta, TIME),
        "force": 50 + sum_of_sines(12.0),
        "joint_angle": alpha,
        "joint_speed": np.gradient(alpha, TIME),
    }


def noise(seed: int, memory: float) -> Array:
    white = np.random.default_rng([72, seed]).normal(0, 0.3, len(TIME))
    return np.asarray(lfilter([1.0], [1.0, -memory], white))


def way(s: Signals) -> Array:
    return np.clip(s["motor_speed"] / 0.2, -1, 1)


HIDDEN: Mapping[str, tuple[Callable[[Signals], Array], set[str], set[str]]] = {
    "teeth": (lambda s: 0.5 * np.sin(7 * s["motor_angle"] + 0.3), {"motor_angle"}, {"harmonic"}),
    "eccentric drum": (lambda s: 0.9 * np.cos(s["drum_angle"]), {"drum_angle"}, {"harmonic"}),
    "stop": (lambda s: 4 * np.maximum(s["joint_angle"] - 0.1, 0), {"joint_angle"}, {"hinge"}),
    "bent hose": (
        lambda s: 40 * np.maximum(s["joint_angle"] + 0.05, 0) ** 3,
        {"joint_angle"},
        {"truncated power"},
    ),
    "detent": (lambda s: 0.5 * np.sin(19 * s["joint_angle"] + 1.0), {"joint_angle"}, {"wave"}),
    "free on both sides": (
        lambda s: 4 * np.sign(s["joint_angle"]) * np.maximum(np.abs(s["joint_angle"]) - 0.15, 0),
        {"joint_angle"},
        {"dead zone"},
    ),
    "rubs more one way": (
        lambda s: 1.2 * np.arctan(np.maximum(s["motor_speed"], 0) / 6),
        {"motor_speed"},
        {"saturating on one side"},
    ),
    "levels off slowly": (
        lambda s: 1.5 * s["motor_speed"] / (6 + np.abs(s["motor_speed"])),
        {"motor_speed"},
        {"saturating"},
    ),
    "warming": (
        lambda s: 1.5 * np.exp(-TIME / 20) * way(s),
        {"time", "motor_speed"},
        {"exponential"},
    ),
    "slip": (lambda s: 1.2 * np.heaviside(TIME - 0.37 * TIME[-1], 1.0), {"time"}, {"step"}),
    "rubs by force": (
        lambda s: 0.03 * s["force"] * way(s),
        {"force", "motor_speed"},
        {"polynomial", "power", "saturating"},
    ),
    "tight place": (
        lambda s: 1.5 * np.exp(-((np.angle(np.exp(1j * (s["motor_angle"] - 1))) / 0.4) ** 2)) * way(s),
        {"motor_angle", "motor_speed"},
        {"bump"},
    ),
    "air": (
        lambda s: 1.0 * s["joint_speed"] * np.abs(s["joint_speed"]),
        {"joint_speed"},
        {"power", "polynomial", "levelling off"},
    ),
    "by both": (lambda s: 0.1 * s["force"] * s["joint_angle"], {"force", "joint_angle"}, {"polynomial", "power"}),
}


@pytest.mark.parametrize("memory", [0.0, 0.7])
@pytest.mark.parametrize("name", HIDDEN)
def test_a_hidden_law_is_found_by_variable_and_form(name: str, memory: float) -> None:
    s = signals(1)
    law, follows, forms = HIDDEN[name]
    hidden = law(s)
    found = discover(hidden + noise(1, memory), s, TIME)
    assert [set(each.candidate.follows) for each in found.laws] == [follows]
    assert found.laws[0].form.name in forms
    # what is left is the noise, and little of the law
    own = noise(1, memory)
    assert np.std(found.residual_after - (own - own.mean())) < 0.2 * np.std(hidden)


def test_numbers_are_those_that_were_hidden() -> None:
    s = signals(2)
    found = discover(0.5 * np.sin(7 * s["motor_angle"] + 0.3) + noise(2, 0.0), s, TIME)
    numbers = {p.name: (p.value, p.sigma) for p in found.laws[0].parameters}
    for name, truth in {"cosine": 0.5 * np.sin(0.3), "sine": 0.5 * np.cos(0.3)}.items():
        value, sigma = numbers[name]
        assert abs(value - truth) < 4 * sigma
        # white noise of .3 in so many rows leaves this much
        assert sigma == pytest.approx(0.3 * np.sqrt(2 / len(TIME)), rel=0.5)
    assert numbers["count"] == (7.0, 0.0)


def test_the_time_of_a_step_is_told_to_a_few_rows() -> None:
    """Between knots that are 40 times as far apart."""
    s, when = signals(5), 0.6137 * TIME[-1]
    found = discover(np.where(when < TIME, 0.8, 0.0) + noise(5, 0.0), s, TIME)
    (law,) = found.laws
    numbers = {p.name: p for p in law.parameters}
    assert law.form.name == "step"
    assert abs(numbers["place"].value - when) < 0.15
    assert abs(numbers["height"].value - 0.8) < 4 * numbers["height"].sigma


def test_sigma_is_the_size_of_errors() -> None:
    """Of a hinge's slope and place, over 24 worlds: rms of error over sigma, which 48 numbers tell to 10 %."""
    off = []
    for seed in range(24):
        s = signals(100 + seed)
        place = float(np.quantile(s["joint_angle"], 0.6))
        target = 4 * np.maximum(s["joint_angle"] - place, 0) + noise(seed, 0.5)
        (law,) = discover(target, {"joint_angle": s["joint_angle"]}, TIME).laws
        if law.form.name == "hinge":
            numbers = {p.name: (p.value, p.sigma) for p in law.parameters}
            off += [(numbers[n][0] - truth) / numbers[n][1] for n, truth in (("slope", 4.0), ("place", place))]
    assert len(off) >= 36
    assert 0.75 < np.sqrt(np.mean(np.square(off))) < 1.3


def test_chance_makes_no_law() -> None:
    """Of 15 recordings with nothing but noise: two or more would come by chance in 1 of 400 runs of such tests."""
    found = [seed for seed in range(15) if discover(noise(seed, (0, 0.5, 0.9)[seed % 3]), signals(seed), TIME).laws]
    assert len(found) <= 1


def test_two_laws_at_once() -> None:
    s = signals(3)
    target = 0.6 * np.sin(6 * s["motor_angle"]) + 4 * np.maximum(s["joint_angle"] - 0.1, 0)
    found = discover(target + noise(3, 0.0), s, TIME)
    assert {(law.form.name, law.candidate.follows) for law in found.laws} == {
        ("harmonic", ("motor_angle",)),
        ("hinge", ("joint_angle",)),
    }


@pytest.mark.parametrize("push", [1.0, 3.0])
def test_a_push_by_hand_is_no_law_and_its_time_is_told(push: float) -> None:
    """The smaller one leaves 1.17 times noise in all."""
    pushed = np.where((TIME > 31) & (TIME < 33), push, 0.0)
    found = discover(pushed + noise(4, 0.0), signals(4), TIME, noise=0.3)
    assert found.laws == ()
    assert found.something_remains
    first, last = found.busiest
    assert first < 33
    assert last > 31
    assert "no function of these variables" in found.words


def test_without_a_noise_nobody_says_that_something_remains() -> None:
    found = discover(noise(5, 0.9), signals(5), TIME)
    assert found.something_remains is None
    assert "not given" in found.words


def test_noise_alone_is_not_taken_for_a_push() -> None:
    """Nine recordings, a third of them with noise that lasts for ten rows."""
    for seed in range(9):
        made = noise(seed, (0, 0.5, 0.9)[seed % 3])
        assert not discover(made, signals(seed), TIME, noise=float(np.std(made))).something_remains


def test_the_curve_with_its_band_holds_the_truth() -> None:
    s = signals(6)
    found = discover(4 * np.maximum(s["joint_angle"] - 0.1, 0) + noise(6, 0.0), s, TIME)
    at = np.linspace(-0.3, 0.5, 30)
    value, sigma = found.laws[0].curve(at)
    assert np.all(np.abs(value - 4 * np.maximum(at - 0.1, 0)) < 4 * sigma + 1e-3)


def test_blocks_of_two_recordings_are_judged_apart() -> None:
    s = signals(7)
    both = {name: np.concatenate([v, v[::-1]]) for name, v in s.items()}
    time = np.concatenate([TIME, TIME + 100])
    blocks = np.repeat(np.arange(40), len(time) // 40)
    target = 0.5 * np.sin(5 * both["motor_angle"]) + np.concatenate([noise(7, 0.0), noise(8, 0.0)])
    (law,) = discover(target, both, time, blocks).laws
    assert dict(law.constants) == {"count": 5.0}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"target": np.zeros(7)}, "rows"),
        ({"variables": {"force": np.zeros(9)}}, "force has shape"),
        ({"variables": {"force": np.full(len(TIME), np.nan)}}, "force has numbers that are not finite"),
        ({"blocks": np.arange(len(TIME)) // 1000}, "3 blocks"),
        ({"variables": {"time": TIME + 1}}, "`time` is among the variables"),
        ({"time": TIME[::-1]}, "time goes back after row 0"),
        ({"variables": [np.zeros(len(TIME))]}, "variables are a list"),
        ({"variables": {"force": ["a"] * len(TIME)}}, "force is no array of numbers"),
        ({"target": np.zeros((2, len(TIME)))}, "one residual at a time"),
    ],
)
def test_arrays_that_cannot_be_used_are_refused(change: dict[str, object], said: str) -> None:
    given: dict[str, Any] = {"target": noise(9, 0.0), "variables": signals(9), "time": TIME, "blocks": None} | change
    if np.shape(given["target"]) == (7,):
        given |= {"variables": {}, "time": np.arange(7.0)}
    with pytest.raises(Refused, match=said):
        discover(**given)


def test_a_constant_variable_does_no_harm() -> None:
    s = signals(10) | {"ballast": np.full(len(TIME), 2.0)}
    (law,) = discover(0.5 * np.sin(7 * s["motor_angle"]) + noise(10, 0.0), s, TIME).laws
    assert law.candidate.follows == ("motor_angle",)


def test_a_law_that_acts_in_every_block_is_found_where_it_is_loudest_in_one() -> None:
    """Drag goes with the square of speed: beside one fast stretch the gains of all others seemed to be chance."""
    s, loud = signals(3), (TIME >= 20) & (TIME < 22)
    speed = np.where(loud, 3.0, 1.0) * s["joint_speed"]
    target = 0.5 * speed * np.abs(speed) + noise(3, 0.0)
    (law,) = discover(target, {"joint_speed": speed}, TIME).laws
    assert set(law.candidate.follows) == {"joint_speed"}
    pushed = noise(3, 0.0) + np.where(loud, 12.0, 0.0)
    assert not discover(pushed, {"joint_speed": s["joint_speed"], "joint_angle": s["joint_angle"]}, TIME).laws


@pytest.mark.parametrize("seed", [3, 4])
def test_what_is_the_same_under_any_force_does_not_follow_it(seed: int) -> None:
    """Dry friction as it turns over had been a force that levels off at once, times the sign of the speed."""
    s = signals(seed)
    found = discover(2 * way(s) + noise(seed, 0.0), {name: s[name] for name in ("force", "motor_speed")}, TIME)
    assert [law.candidate.follows for law in found.laws] == [("motor_speed",)]
