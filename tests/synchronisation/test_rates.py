"""Logs and cameras of other rates than 500 Hz and 30 Hz, through all of `synchronise`, from files as loggers leave them."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer

from identification.dataset.dataset import DataSet
from identification.dataset.series import Series, interpolated, numbered_columns
from mechanism.description import Neck, read_neck
from samples.generator.prescribed import Prescribed, World, prescribe
from samples.worlds.clock_worlds import NECK_FILE, NOISE_RAD, switched_light
from synchronisation.angles import Angles
from synchronisation.check.from_dataset import check_dataset
from synchronisation.encoder_log import read_log
from synchronisation.synchronise import synchronise
from xneck_foundation.strict_yaml import parse_yaml

NECK = read_neck(NECK_FILE)
TEXT = NECK_FILE.read_text()
RATES = [(50.0, 30.0), (200.0, 25.0), (1000.0, 60.0)]


@cache
def made(log_hz: float, frame_hz: float) -> Prescribed:
    """Thirty seconds of dry friction and damped cables."""
    return prescribe(World(parse_yaml(TEXT, "neck.yaml")), 30.0, 7, log_hz=log_hz, frame_hz=frame_hz)


def noisy_angles(p: Prescribed) -> Angles:
    alpha = p.frame_alpha + np.random.default_rng(1).normal(0, NOISE_RAD, p.frame_alpha.shape)
    return Angles(p.frame_times, alpha, np.full(alpha.shape, NOISE_RAD))


@cache
def synchronised(log_hz: float, frame_hz: float) -> DataSet:
    p = made(log_hz, frame_hz)
    log = Series(p.log_time, numbered_columns("theta", p.counted) | numbered_columns("f", p.f))
    return synchronise(NECK, TEXT, noisy_angles(p), log, {})


def test_motors_are_as_sure_as_the_steps_of_their_log() -> None:
    """Not as counts of neck.yaml would make them, which may be lines; the record says so."""
    p, as_described = made(200.0, 25.0), synchronised(200.0, 25.0)
    log = Series(p.log_time, numbered_columns("theta", p.counted) | numbered_columns("f", p.f))
    lines = NECK.with_({f"motors[{j}].counts": NECK.motors[j].counts // 4 for j in range(NECK.M)})
    data = synchronise(lines, TEXT, noisy_angles(p), log, {})
    for suffix in ("", "_d", "_dd"):
        np.testing.assert_allclose(
            data.state.matrix("sigma_theta", suffix), as_described.state.matrix("sigma_theta", suffix), rtol=1e-3
        )
    np.testing.assert_allclose(data.count_angles, NECK.count_angles, rtol=1e-4)
    (words,) = set(data.clock["warnings"]) - set(as_described.clock["warnings"])
    assert f"where neck.yaml has counts: {lines.motors[0].counts}" in words


@pytest.mark.parametrize(("log_hz", "frame_hz"), RATES)
def test_clock_state_and_check_hold_at_other_rates(log_hz: float, frame_hz: float) -> None:
    """The rates that are found are those of the generator. The limit of the offset is 0.05 ms at 30 Hz; errors of the state are of
    the size of their sigma. Fasquelle's series takes whole rows, as near to 31.25 Hz as they allow."""
    p, data = made(log_hz, frame_hz), synchronised(log_hz, frame_hz)
    assert np.mean(np.diff(data.state.time)) == pytest.approx(1 / log_hz, rel=1e-4)
    assert np.mean(np.diff(data.fasquelle.time)) == pytest.approx(round(log_hz / 31.25) / log_hz, rel=1e-4)
    assert data.clock["frame_period_s"] == pytest.approx(1 / frame_hz, rel=1e-3)
    assert (data.clock["log_rows_missing"], data.clock["log_gaps"], data.clock["slips"]) == (0, [], [])
    expected = p.clocks.offset_s + p.clocks.skew * (data.clock["camera_middle_s"] - p.clocks.middle_s)
    assert abs(data.clock["offset_s"] - expected) < 4 * data.clock["offset_sigma_s"] < 0.6e-3
    inner = slice(round(log_hz), -round(log_hz))
    true = interpolated(data.state.time, p.log_time, p.alpha)
    error = (data.state.matrix("alpha") - true)[inner]
    z = error / data.state.matrix("sigma_alpha")[inner]
    # a fused state of one recording errs along about five slow directions: 99 % of chi-square by its degrees of freedom
    assert 0.3 < np.sqrt(np.mean(z**2)) < 1.74
    assert np.sqrt(np.mean(error**2)) < 0.5 * NOISE_RAD
    of_motors = data.state.matrix("theta") - interpolated(data.state.time, p.log_time, p.theta)
    assert np.sqrt(np.mean((of_motors / data.state.matrix("sigma_theta"))[inner] ** 2)) < 1.5
    assert data.check["verdict"] == "consistent"


@pytest.mark.parametrize(("log_hz", "frame_hz"), RATES)
def test_a_fault_is_named_at_other_rates(log_hz: float, frame_hz: float) -> None:
    """The drum of cable 2 is described 3 % too small."""
    data = synchronised(log_hz, frame_hz)
    motors = [m.model_copy(update={"rd": m.rd * (0.97 if j == 1 else 1)}) for j, m in enumerate(NECK.motors)]
    found = check_dataset(replace(data, neck=NECK.model_copy(update={"motors": tuple(motors)}))).faults[0]
    assert (found["fault"], found["where"]) == ("drum_radius", "cable 2")
    assert found["size"] == pytest.approx(0.03, abs=0.01)


def written_with_light(path: Path, p: Prescribed, led: np.ndarray, neck: Neck) -> None:
    """A JSON log whose joints stand in no order of the motors, the light between them and without a force."""
    names = ["motor3", "led", "motor1", "motor4", "motor2"]
    order = [2, 0, 3, 1]
    assert {m.joint for m in neck.motors} == {n for n in names if n != "led"}
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2")
        schema = writer.register_schema("sensor_msgs/msg/JointState", "jsonschema", b"{}")
        channel = writer.register_channel("/joint_states", "json", schema)
        rows = zip(p.log_time.tolist(), p.counted[:, order], p.f[:, order], led.tolist(), strict=True)
        for time, theta, f, on in rows:
            ns = round(time * 1e9)
            position = [theta[0], on, *theta[1:]]
            effort = [f[0], 0.0, *f[1:]]
            header = {"stamp": {"sec": ns // 10**9, "nanosec": ns % 10**9}}
            message = {"header": header, "name": names, "position": position, "effort": effort}
            writer.add_message(channel, ns, json.dumps(message).encode(), ns)
        writer.finish()


def test_the_led_of_an_mcap_is_a_joint_and_ties_the_clock(tmp_path: Path) -> None:
    """As the motors' log, at 200 Hz, and angles that hold the light of a 25 Hz camera; 0.1 ms is what a light is worth."""
    p = made(*RATES[1])
    exposure = 0.004
    light = switched_light(p.clocks, p.frame_times, 3, 60, exposure, p.log_time)
    named = tuple(m.model_copy(update={"joint": f"motor{j + 1}"}) for j, m in enumerate(NECK.motors))
    neck = NECK.model_copy(update={"motors": named})
    written_with_light(tmp_path / "log.mcap", p, light.led, neck)
    log = read_log(tmp_path / "log.mcap", neck)
    np.testing.assert_array_equal(log.columns["led"], light.led)
    np.testing.assert_allclose(log.matrix("theta"), p.counted)
    np.testing.assert_allclose(log.matrix("f"), p.f)
    angles = replace(noisy_angles(p), light=light.brightness, notes={"light": {"exposure_s": exposure, "later_s": 0.0}})
    clock = synchronise(neck, TEXT, angles, log, {}).clock
    assert clock["source"] == "light"
    assert clock["light_edges"] > 40
    expected = p.clocks.offset_s + p.clocks.skew * (clock["camera_middle_s"] - p.clocks.middle_s)
    assert abs(clock["offset_s"] - expected) < 0.2e-3
    assert abs(clock["offset_s"] - expected) < 4 * clock["offset_sigma_s"]
    # without names in neck.yaml, joints stand by their numbers, the light left out
    plain = read_log(tmp_path / "log.mcap", NECK)
    np.testing.assert_allclose(plain.matrix("theta"), p.counted)
