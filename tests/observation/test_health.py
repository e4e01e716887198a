"""An arm that is no longer the one identified is said to be, and one that is is not."""

from collections.abc import Callable

import numpy as np
import pytest

from identification.dataset.series import Series, numbered_columns
from identification.model_file import pose_machine
from observation import load_test
from observation.health import SETTLING_S, HealthMonitor, sentences, verdict
from observation.observed_log import observe_log
from tests.observation.arms import CHANGES, SEEDS, case, changed
from xneck_foundation.errors import Refused

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


def changed_columns(log: Series, stem: str, by: Callable[[np.ndarray], np.ndarray]) -> Series:
    return Series(log.time, {**log.columns, **numbered_columns(stem, by(log.matrix(stem)))})


@pytest.mark.parametrize(
    "wrong",
    [
        lambda log: changed_columns(log, "theta", lambda theta: theta + 3.0),
        lambda log: changed_columns(log, "f", lambda f: f / 2500),
    ],
    ids=["another zero", "forces in N m"],
)
def test_a_log_that_does_not_fit_from_its_beginning_is_doubted_first(wrong: Callable[[Series], Series]) -> None:
    """What its angles are worth nobody knows then: no cause is named before, and no sigma is told."""
    of = case(SEEDS[1])
    seen = observe_log(of.neck, of.model, wrong(of.log.part(slice(0, ROWS))))
    first, *others = sentences(seen.health)
    for asked in ("the log does not fit this arm", "from another zero", "is f in N on the cable", "not to be used"):
        assert asked in first
    assert not any("a cable slipped" in line for line in others)
    assert np.isnan(seen.series.matrix("sigma_alpha")).all()
    assert np.isnan(seen.as_json()["sigma_alpha_rms_rad"]).all()


def monitored(error: Callable[[float, float], np.ndarray]) -> HealthMonitor:
    """20 s of motors with 15 N of friction, whose unmodelled force is a function of time and direction, N; 1 N was left."""
    monitor = HealthMonitor(np.ones(4), np.full(4, 15.0))
    for now in np.arange(0.0, 20.0, 0.01).tolist():
        direction = float(np.sign(np.sin(3 * now)))
        monitor.add(now, error(now, direction), np.full(4, 50.0 * direction))
    monitor.end()
    return monitor


def test_exchanged_motors_of_alike_friction_are_doubted_and_a_slip_is_not() -> None:
    """Two whose forces and angles are exchanged together miss the difference of their tensions, from the beginning on."""
    exchanged = monitored(lambda now, direction: np.array([-5.0, 6.0, 0.0, 0.0]))
    assert exchanged.doubted_from == -np.inf
    assert "are motors exchanged" in sentences(exchanged)[0]
    for error in ([5.0, 0.0, 0.0, 0.0], [2.0, -2.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]):
        assert monitored(lambda now, direction, error=error: np.array(error)).doubted_from == np.inf
    friction = monitored(lambda now, direction: np.full(4, 5.0 * direction))
    assert (verdict(friction), friction.doubted) == ("changed", None)


def test_sigma_is_known_up_to_where_a_log_no_longer_fits() -> None:
    monitor = monitored(lambda now, direction: np.full(4, 40.0 if now > 12 else 0.0))
    assert monitor.foreign
    assert monitor.doubted_from == pytest.approx(10.0, abs=0.02)


@pytest.mark.parametrize(
    ("by", "says"),
    [
        (np.negative, r"f1, f2, f3, f4 would push on cables .*sign of f"),
        (np.zeros_like, "f1, f2, f3, f4 stay at 0 N in every row while motors turn"),
        (lambda f: np.full_like(f, 50.0), "f1, f2, f3, f4 stay at 50 N in every row while motors turn"),
        (lambda f: f * [1, 1, 0, 1], "f3 stays at 0 N in every row while motors turn"),
    ],
    ids=["negative", "zero", "constant", "one zero"],
)
def test_forces_that_can_be_none_on_the_cables_are_refused(by: Callable[[np.ndarray], np.ndarray], says: str) -> None:
    of = case(SEEDS[1])
    with pytest.raises(Refused, match=says):
        observe_log(of.neck, of.model, changed_columns(of.log.part(slice(0, ROWS)), "f", by))


def test_constant_forces_may_hold_an_arm_at_rest() -> None:
    of = case(SEEDS[1])
    row = of.log.part(slice(0, 1))
    columns = {name: np.full(200, float(column[0])) for name, column in row.columns.items()}
    seen = observe_log(of.neck, of.model, Series(np.arange(200) / 500.0, columns))
    assert np.isfinite(seen.series.matrix("sigma_alpha")).all()


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
