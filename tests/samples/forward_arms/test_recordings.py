"""What a log and a camera have of a motion, and which arm a seed is."""

import ast
import sys
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from mechanism.friction import dry
from samples.forward_arms.arms import Arm, Truth, make_arms
from samples.forward_arms.drawing import built, drawn
from samples.forward_arms.laws import RouteFriction
from samples.forward_arms.plant import ROW, Plant
from samples.forward_arms.settings import Settings
from tests.paths import ROOT
from tests.samples.forward_arms.plants import SHORT

Array = NDArray[np.float64]


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


def test_steps_of_a_row_go_where_steps_of_a_quarter_of_it_go() -> None:
    """Until a count that rounds the other way moves the motors by less than itself: joints differ by .001 deg, of noise of .01."""

    def joints(per_row: int) -> Array:
        settings = replace(SHORT, base="presliding", seconds=2.0, step=ROW / per_row)
        t = next(make_arms([21], settings)).recordings[0].truth.within_log()
        return t.alpha[:: t.per_row]

    apart = np.degrees(joints(1) - joints(4))
    assert 0 < np.sqrt(np.mean(apart**2)) < 1e-3


def test_arms_do_not_chatter_where_friction_turns_over_within_a_step() -> None:
    """Steps of a row beside steps of a quarter: without shorter ones in their place joints' speeds differ by .4 rad/s."""

    def speeds(per_row: int) -> Array:
        settings = Settings(
            base="exact", drawing_off=1.0, seconds=0.5, recordings=1, offset=(0.0, 0.0), step=ROW / per_row
        )
        rubbing = [RouteFriction(np.full(4, 0.012), width=3e-4)]
        t = next(make_arms([1710], settings, [rubbing])).recordings[0].truth.within_log()
        return t.alpha_d[:: t.per_row]

    assert np.sqrt(np.mean((speeds(1) - speeds(4)) ** 2)) < 0.01


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
