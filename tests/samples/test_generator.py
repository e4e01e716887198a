"""The sample recordings are what they claim: one motion, two clocks, true forces, and files that say the same.

Read against samples/truth.*, which only tests read, and against a short recording made anew.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from samples.generator.clocks import Clocks
from samples.generator.motors import dry_and_viscous, linear_cable, motors_of
from samples.generator.mujoco_arm import Load, MujocoArm
from samples.generator.recording import Hidden, Recording, record
from samples.generator.routes import lengths
from samples.generator.simulation import quantum, simulate
from samples.generator.statics import hold, holding_torque, pull_matrix
from samples.generator.truth import Truth, read_truth

SAMPLES = Path("samples")


@pytest.fixture(scope="module")
def neck() -> dict[str, Any]:
    return yaml.safe_load((SAMPLES / "recording" / "neck.yaml").read_text(encoding="utf-8"))


@pytest.fixture(scope="module", params=["recording", "held_out"])
def shipped(request: pytest.FixtureRequest) -> tuple[str, Truth]:
    return request.param, read_truth(SAMPLES, request.param)


@pytest.fixture(scope="module")
def short(neck: dict[str, Any]) -> Recording:
    """4 s made anew."""
    return record(neck, 4.0, [7])


def read_mcap(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time (T,), s, theta and f (T, M) of a log."""
    rows = []
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for schema, channel, message, joint in reader.iter_decoded_messages():
            assert (schema and schema.name, channel.topic) == ("sensor_msgs/msg/JointState", "/joint_states")
            ns = joint.header.stamp.sec * 1_000_000_000 + joint.header.stamp.nanosec
            assert ns == message.log_time == message.publish_time
            assert list(joint.name) == ["motor1", "motor2", "motor3", "motor4"]
            rows.append((ns * 1e-9, *joint.position, *joint.effort))
    table = np.array(rows)
    return table[:, 0], table[:, 1:5], table[:, 5:]


def test_log_is_what_the_encoders_counted(shipped: tuple[str, Truth], neck: dict[str, Any]) -> None:
    """500 Hz without a gap; theta in whole counts, within half a count of the truth; f in the drive's steps of 1 mN."""
    name, truth = shipped
    time, theta, f = read_mcap(SAMPLES / name / "log.mcap")
    np.testing.assert_allclose(time, truth.log_time, rtol=0, atol=1e-9)
    np.testing.assert_allclose(np.diff(time), 0.002, rtol=0, atol=1e-9)
    counts = theta / quantum(neck)
    np.testing.assert_allclose(counts, np.round(counts), rtol=0, atol=1e-6)
    error = (theta - truth.theta) / quantum(neck)
    assert np.abs(error).max() < 0.501, "rounding, not truncation (truth is kept to 1e-5 rad)"
    np.testing.assert_allclose(error[1000:-1000].std(axis=0), 1 / np.sqrt(12), rtol=0.05)
    np.testing.assert_allclose(f * 1000, np.round(f * 1000), rtol=0, atol=1e-6)
    assert f.min() > 0
    assert f.max() < 160


def test_text_log_says_the_same_as_mcap(neck: dict[str, Any]) -> None:
    """log.csv keeps counts apart, and forces and times to the digit."""
    time, theta, f = read_mcap(SAMPLES / "recording" / "log.mcap")
    path = SAMPLES / "recording" / "log.csv"
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    header = path.read_text(encoding="utf-8").splitlines()[0]
    assert header == "time,theta1,theta2,theta3,theta4,f1,f2,f3,f4"
    np.testing.assert_allclose(table[:, 0], time, rtol=0, atol=1e-9)
    np.testing.assert_allclose(table[:, 1:5] / quantum(neck), theta / quantum(neck), rtol=0, atol=0.05)
    np.testing.assert_allclose(table[:, 5:], f, rtol=0, atol=1e-9)


def test_clocks_tell_the_same_motion(shipped: tuple[str, Truth]) -> None:
    """Angles at the frames are those of the log at offset + skew: 10 us of clock would show (1.5 rad/s times 10 us)."""
    _, truth = shipped
    s = truth.scalars
    clocks = Clocks(s["offset_s"], s["skew"], s["middle_s"])
    assert s["middle_s"] == pytest.approx((truth.frame_times[0] + truth.frame_times[-1]) / 2)
    at = clocks.log_time(truth.frame_times)
    np.testing.assert_allclose(clocks.camera_time(at), truth.frame_times, rtol=0, atol=1e-9)
    from_log = np.stack([np.interp(at, truth.log_time, a) for a in truth.alpha.T], axis=-1)
    # linear interpolation over 2 ms: h^2 alpha'' / 8 with alpha'' up to 15 rad/s^2
    np.testing.assert_allclose(truth.frame_alpha, from_log, rtol=0, atol=1e-5)
    late = np.stack([np.interp(at + 1e-4, truth.log_time, a) for a in truth.alpha.T], axis=-1)
    assert np.abs(truth.frame_alpha - late).max() > 5e-5, "a clock off by 0.1 ms is seen by this test"
    before, after = at[0] - truth.log_time[0], truth.log_time[-1] - at[-1]
    assert 0.1 < before < 1.0
    assert 0.1 < after < 1.0
    assert 15e-6 <= abs(s["skew"]) <= 60e-6


def test_frames_jitter_and_some_are_missing(shipped: tuple[str, Truth]) -> None:
    """Nominally 30 Hz; stamps on the video's time base, jittering by under 2 ms, with gaps of whole frames."""
    _, truth = shipped
    ticks = truth.frame_times * 90_000
    np.testing.assert_allclose(ticks, np.round(ticks), rtol=0, atol=1e-5)
    steps = np.diff(truth.frame_times) * 30
    lost = np.round(steps) - 1
    assert 2 <= lost.sum() <= 12
    jitter = steps - np.round(steps)
    assert 0.2e-3 < jitter.std() / 30 < 1e-3
    assert np.abs(jitter).max() / 30 < 2.5e-3


def test_held_out_angles_are_the_truth_with_the_noise_they_state() -> None:
    """White noise of 0.05 deg: 599 x 3 values give its rms to 2 %, and no correlation from frame to frame."""
    truth = read_truth(SAMPLES, "held_out")
    table = np.loadtxt(SAMPLES / "held_out" / "angles.csv", delimiter=",", skiprows=1)
    np.testing.assert_allclose(table[:, 0], truth.frame_times, rtol=0, atol=1e-6)
    np.testing.assert_allclose(table[:, 4:], np.radians(0.05), rtol=0, atol=1e-6)
    noise = table[:, 1:4] - truth.frame_alpha
    assert noise.std() == pytest.approx(np.radians(0.05), rel=0.08)
    assert np.abs(noise.mean(axis=0)).max() < 4 * np.radians(0.05) / np.sqrt(len(noise))
    assert np.abs(np.sum(noise[1:] * noise[:-1], axis=0) / np.sum(noise**2, axis=0)).max() < 4 / np.sqrt(len(noise))


def test_recordings_begin_and_end_at_rest_and_move_between(shipped: tuple[str, Truth]) -> None:
    """Settled at both ends of the log; tensions in 15..120 N; every joint to 20 degrees and more; motors reverse often."""
    _, truth = shipped
    ends = np.r_[0:100, -100:0]
    assert np.abs(truth.alpha_d[:100]).max() < 5e-4, "settled before the log begins"
    assert np.abs(truth.alpha_d[-100:]).max() < 5e-3, "gears still creep within their friction"
    assert np.abs(truth.alpha[ends]).max() < np.radians(1)
    assert truth.tension.min() > 15
    assert truth.tension.max() < 120
    assert np.abs(truth.alpha).max(axis=0).min() > np.radians(20)
    assert np.abs(truth.alpha).max() < np.radians(40)
    speed = np.gradient(truth.theta, 0.002, axis=0)
    moving = np.where(np.abs(speed) > 5, np.sign(speed), 0)
    for column in moving.T:
        signs = column[column != 0]
        assert np.sum(np.diff(signs) != 0) > 20
    assert np.abs(speed).max() > 100


def test_truth_obeys_motors_and_cables(shipped: tuple[str, Truth], neck: dict[str, Any]) -> None:
    """Logged f, true theta and alpha satisfy (41), (43), (53) with the hidden k, ca and fs: the signs are the project's.

    theta' and theta'' come from differences of theta as kept (4e-6 rad) over ticks in which friction turns: the motor
    equation holds to 0.6 N at single ticks, but without bias, to 0.03 N in the mean of 0.1 s.
    """
    name, truth = shipped
    _, _, f = read_mcap(SAMPLES / name / "log.mcap")
    hidden = truth.scalars["hidden"]
    drum, inertia = 0.010 / 25, 5.0e-6
    x0 = np.array([cable["x0"] for cable in neck["cables"]])
    x = lengths(neck, truth.alpha) - lengths(neck, np.zeros(3)) + drum * truth.theta + x0
    theta_d = np.gradient(truth.theta, 0.002, axis=0)
    x_d = drum * theta_d - np.einsum("tnm,tn->tm", pull_matrix(neck, truth.alpha), truth.alpha_d)
    tension = np.array(hidden["k"]) * x + np.array(hidden["ca"]) * x_d
    np.testing.assert_allclose(truth.tension, tension, rtol=0, atol=0.01)
    friction = np.array(hidden["fs"]) * 2 / np.pi * np.arctan(0.5 * theta_d)
    held = (f[1:-1] + f[:-2]) / 2  # a second difference at a tick sees the commands before and after it
    missing = held - (friction + truth.tension)[1:-1] - inertia / drum * np.diff(truth.theta, 2, axis=0) / 0.002**2
    mean = np.apply_along_axis(lambda y: np.convolve(y, np.full(50, 0.02), "valid"), 0, missing)
    assert np.abs(missing).max() < 1.0
    assert np.abs(mean).max() < 0.05


def test_same_seed_same_recording(short: Recording, neck: dict[str, Any]) -> None:
    """Another run of the same seed gives the same bits, another seed another motion."""
    again = record(neck, 4.0, [7])
    np.testing.assert_array_equal(short.run.f, again.run.f)
    np.testing.assert_array_equal(short.frame_times, again.frame_times)
    np.testing.assert_array_equal(short.alpha_at(1.5), again.alpha_at(1.5))


def test_payload_is_in_the_truth(shipped: tuple[str, Truth], neck: dict[str, Any]) -> None:
    """What the described arm's weight and springs leave of Z t is 0.1 kg on the tip, and inertia.

    Inertia is fitted as constant (M changes by some per cent over the motion), which limits the payload; seen: 0.4 %.
    """
    _, truth = shipped
    alpha = truth.alpha[::10]
    torque = np.einsum("tnm,tm->tn", pull_matrix(neck, alpha), truth.tension[::10])
    described = holding_torque(neck, alpha)
    loaded = yaml.safe_load(yaml.safe_dump(neck))
    loaded["mechanisms"][-1]["top"]["mass"] += 1.0
    per_kg = holding_torque(loaded, alpha) - described
    for i in range(3):
        columns = np.column_stack([per_kg[:, i], truth.alpha_dd[::10]])
        payload = np.linalg.lstsq(columns, torque[:, i] - described[:, i], rcond=None)[0][0]
        assert payload == pytest.approx(truth.scalars["hidden"]["load"]["payload_kg"], rel=0.02)


def test_energy_of_the_generators_arm(neck: dict[str, Any]) -> None:
    """Without friction and damping, the motors' work is stored; semi-implicit Euler strays by little, and half for h/2."""
    motors = motors_of(neck, dry_and_viscous(np.zeros(4), np.zeros(4)), linear_cable(np.array(Hidden().k), np.zeros(4)))

    class Waves:
        def command(self, sample: int, theta: np.ndarray) -> np.ndarray:
            return 40 + 20 * np.sin(2 * np.pi * sample / 500 * np.array([1.1, 1.7, 1.4, 0.9]))

    strays = []
    for step in (2e-4, 1e-4):
        run = simulate(neck, MujocoArm(neck, step, Load()), motors, Waves(), np.zeros(4), 400, 0)
        inertia = np.array([m["Ia"] for m in neck["motors"]])
        elastic = np.sum(np.array(Hidden().k) * np.maximum(run.x, 0) ** 2 + inertia * run.theta_d**2, axis=-1) / 2
        energy = run.arm_energy + elastic
        work = np.cumsum(np.sum(run.f[:-1] * motors.drum * np.diff(run.theta, axis=0), axis=-1))
        assert np.ptp(work) > 0.1
        strays.append(np.abs(energy[1:] - energy[0] - work).max())
    assert strays[1] < 1e-3 * np.ptp(work)
    assert strays[1] < 0.6 * strays[0]


def test_planned_tensions_hold_the_described_arm(neck: dict[str, Any]) -> None:
    """Z t = g at any pose and level, and the level is kept where it does no work (the null space of Z)."""
    alpha = np.random.default_rng(1).uniform(-0.5, 0.5, (20, 3))
    low, high = (hold(neck, alpha, np.full((20, 4), level)) for level in (40.0, 80.0))
    for held in (low, high):
        balance = np.einsum("tnm,tm->tn", pull_matrix(neck, alpha), held.tension)
        np.testing.assert_allclose(balance, held.torque, rtol=0, atol=1e-12)
    assert (high.tension - low.tension).mean() > 30
