"""An arm that is no longer the one identified is said to be, and one that is is not."""

import numpy as np
import pytest

from identification.dataset.series import Series
from identification.model_file import pose_machine
from observation import load_test
from observation.health import SETTLING_S, HealthMonitor, sentences, verdict
from observation.observed_log import observe_log
from tests.observation.arms import CHANGES, SEEDS, case, changed

ROWS = 5200
"""a window and what comes before it"""


def test_a_quiet_recording_is_said_to_be_as_identified() -> None:
    for seed in SEEDS:
        of = case(seed)
        seen = observe_log(of.neck, of.model, of.log.part(slice(0, ROWS)))
        assert verdict(seen.health) == "as identified"
        assert sentences(seen.health) == []
        assert seen.health.windows == 2  # the last one ends with the log
        assert seen.health.judged_to == of.log.time[ROWS - 1]


@pytest.mark.parametrize("name", sorted(CHANGES))
def test_a_changed_arm_is_named_with_its_time(name: str) -> None:
    of = changed(name)
    seen = observe_log(of.neck, of.model, of.log.part(slice(0, ROWS)))
    assert verdict(seen.health) == "changed"
    assert seen.health.findings[0].time == pytest.approx(of.log.time[0] + SETTLING_S, abs=0.01)
    assert "is not as identified" in sentences(seen.health)[0]


def test_a_short_log_is_not_judged() -> None:
    of = case(SEEDS[1])
    seen = observe_log(of.neck, of.model, of.log.part(slice(0, 100)))
    assert verdict(seen.health) == "cannot tell"


def test_a_cable_that_slips_is_named() -> None:
    """Its motor has wound in 3 mm that the cable did not follow."""
    of = case(SEEDS[1])
    log = of.log.part(slice(0, ROWS))
    drum = of.neck.motors[1].rd / of.neck.motors[1].R
    slipped = {**log.columns, "theta2": log.columns["theta2"] + np.where(log.time > log.time[1200], 3e-3 / drum, 0.0)}
    seen = observe_log(of.neck, of.model, Series(log.time, slipped))
    assert verdict(seen.health) == "changed"
    assert max(seen.health.findings, key=lambda found: found.ratio).motor == 2


def test_a_motor_counted_backwards_is_no_friction() -> None:
    """Nor are two that are exchanged: forces are missing that friction cannot make."""
    of = case(SEEDS[1])
    log = of.log.part(slice(0, ROWS))
    exchanged = {**log.columns, "theta1": log.columns["theta2"], "theta2": log.columns["theta1"]}
    backwards = {name: -c if name.startswith("theta") else c for name, c in log.columns.items()}
    for columns in (exchanged, backwards):
        health = observe_log(of.neck, of.model, Series(log.time, columns)).health
        assert verdict(health) == "changed"
        assert "the log does not fit this arm" in sentences(health)[0]
        assert not any("friction changed" in line for line in sentences(health))


def test_motors_counted_from_another_zero_are_asked_about_first() -> None:
    of = case(SEEDS[1])
    log = of.log.part(slice(0, ROWS))
    moved = {name: c + 3.0 if name.startswith("theta") else c for name, c in log.columns.items()}
    health = observe_log(of.neck, of.model, Series(log.time, moved)).health
    assert "every motor is off from the beginning on" in sentences(health)[0]
    assert "counted from another zero" in sentences(health)[0]


def test_what_changes_after_the_last_whole_window_is_named() -> None:
    """The last window ends with the log, and what it finds is later than what was judged before."""
    rng, time = np.random.default_rng(2), np.arange(0.0, 15.0, 0.01)
    monitor = HealthMonitor(np.ones(4), np.full(4, 15.0))
    for now in time:
        error = 0.3 * rng.standard_normal(4) + (8.0 if now > 13 else 0.0)
        monitor.add(float(now), error, np.full(4, 50.0 * np.sign(np.sin(3 * now))))
    assert verdict(monitor) == "as identified"
    monitor.end()
    assert verdict(monitor) == "changed"
    assert monitor.findings[0].time == pytest.approx(10.0, abs=0.02)
    assert monitor.judged_to == time[-1]


def test_a_load_is_weighed(monkeypatch: pytest.MonkeyPatch) -> None:
    """0.3 kg on the tip within 5 %, in a stretch of 8 s of lively motion; and none where none hangs there."""
    monkeypatch.setattr(load_test, "LOAD_STRETCH_S", 8.0)
    of = changed("load")
    (load, *_) = observe_log(of.neck, of.model, of.log.part(slice(0, ROWS))).health.loads
    assert load.mass == pytest.approx(0.3, rel=0.05)
    assert load.time == pytest.approx(of.log.time[0] + SETTLING_S, abs=0.2)
    quiet = case(SEEDS[1])
    assert not observe_log(quiet.neck, quiet.model, quiet.log.part(slice(0, ROWS))).health.loads


def test_what_friction_holds_at_rest_is_no_load(monkeypatch: pytest.MonkeyPatch) -> None:
    """Motors of a slow arm rest for most of the time, and friction holds there what 0.05 kg less would be."""
    monkeypatch.setattr(load_test, "LOAD_STRETCH_S", 8.0)
    of = case(SEEDS[1])
    machine, rng = pose_machine(of.model, of.neck), np.random.default_rng(4)
    time = np.arange(0.0, 8.0, 0.1)
    alpha = of.alpha[: 50 * len(time) : 50]
    theta = of.log.matrix("theta")[: 50 * len(time) : 50]
    rests = np.arange(len(time)) % 10 < 6
    direction = np.where(np.arange(len(time)) % 20 < 10, 1.0, -1.0)
    theta_d = np.where(rests, 0.0, 40.0 * direction)[:, None] * np.ones(of.neck.M)
    noise = 0.05 * rng.standard_normal(theta.shape)
    joints = load_test.JointRows(time, alpha, np.zeros_like(alpha), np.zeros_like(alpha))
    load = load_test.forces_of_load(machine, joints, theta)
    sigma = np.ones(of.neck.M)
    held = -0.05 * load * rests[:, None]
    assert not load_test.find_loads(machine, joints, theta, theta_d, held + noise, sigma)
    (found,) = load_test.find_loads(machine, joints, theta, theta_d, 0.3 * load + held + noise, sigma)
    assert found.mass == pytest.approx(0.3, abs=4 * found.sigma)


def test_why_nothing_is_said_is_told() -> None:
    """A log that is long enough and whose motors turn slowly is not called short; gaps are named."""
    of = case(SEEDS[1])
    time = np.arange(0.0, 12.0, 0.01)
    slow, still = (
        HealthMonitor(np.ones(of.neck.M), np.ones(of.neck.M)),
        HealthMonitor(np.ones(of.neck.M), np.ones(of.neck.M)),
    )
    for row, now in enumerate(time):
        slow.add(float(now), np.zeros(of.neck.M), np.full(of.neck.M, 3.0))
        if row % 500 == 499:
            still.restart()
        still.add(float(now), np.zeros(of.neck.M), np.full(of.neck.M, 50.0))
    assert sentences(slow) == [
        "in 1 window of 8 s no motor turns faster than 8 rad/s for 15 % of the time each way: nothing is said of the arm's health"
    ]
    assert sentences(still) == ["2 gaps of the log leave no stretch of 10 s: nothing is said of the arm's health"]
    assert sentences(HealthMonitor(np.ones(4), np.ones(4))) == [
        "the log has no stretch of 10 s: nothing is said of the arm's health"
    ]
