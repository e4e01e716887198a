"""Logs and angles that mean something else than their columns say, or that are unusual, as files: for tests and for docs/logs.md.

Each is made from one recording without fault by one change, in the way in which loggers, spreadsheets and wiring make it.
"""

import copy
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from mcap.writer import Writer
from numpy.typing import NDArray

from samples.generator.motion import LEVEL_N
from samples.generator.prescribed import Prescribed, World, prescribe
from samples.worlds.clock_worlds import NECK_FILE, NOISE_RAD

Array = NDArray[np.float64]
Table = Mapping[str, Array]

SECONDS = 30.0
SEED = 7
COUNTS = 2048
"""per turn of the motor, as neck.yaml says"""


@dataclass(frozen=True)
class Recording:
    """What a recording's files hold: neck.yaml as a mapping, columns of angles and log by name, `time` among them."""

    neck: dict[str, Any]
    angles: Table
    log: Table
    offset_s: float
    """of the log's clock against the camera's, in the middle of the video"""
    separator: str = ","
    text: Callable[[str], str] = field(default=lambda text: text)
    """of the finished log.csv"""
    topics: Mapping[str, tuple[tuple[str, Array, Array], ...]] | None = None
    """the log as MCAP: joints by topic, each with name, positions and efforts"""


@dataclass(frozen=True)
class WrongLog:
    """One change to a recording, what it is in words, and how it must end."""

    kind: str
    what: str
    make: Callable[[], Recording]
    ends: str
    """`accepted`, `warned` or `refused`"""
    words: str = ""
    """a regular expression that the sentence must match, with what is to be written"""
    slow: bool = False


def files_of(recording: Recording, folder: Path) -> tuple[Path, Path, Path]:
    """Writes neck.yaml, the angles and the log; their paths in this order."""
    neck, angles = folder / "neck.yaml", folder / "angles.csv"
    neck.write_text(yaml.safe_dump(recording.neck), encoding="utf-8")
    angles.write_text(_csv(recording.angles, ","), encoding="utf-8")
    if recording.topics is None:
        log = folder / "log.csv"
        log.write_text(recording.text(_csv(recording.log, recording.separator)), encoding="utf-8")
    else:
        log = folder / "log.mcap"
        _write_topics(log, recording.log["time"], recording.topics)
    return neck, angles, log


@cache
def made(log_hz: float = 500.0, frame_hz: float = 30.0, peak_deg: tuple[float, float] = (25.0, 32.0)) -> Prescribed:
    """Thirty seconds of dry friction and damped cables."""
    world = World(yaml.safe_load(NECK_FILE.read_text()))
    # cables that are pulled by turns stretch by more than a small motion winds
    level = LEVEL_N if peak_deg[1] > 10 else (LEVEL_N[0], 0.0)
    return prescribe(world, SECONDS, SEED, peak_deg=peak_deg, level_n=level, log_hz=log_hz, frame_hz=frame_hz)


def faultless(
    log_hz: float = 500.0, frame_hz: float = 30.0, every: int = 1, peak_deg: tuple[float, float] = (25.0, 32.0)
) -> Recording:
    """The recording without fault; every: of how many rows the logger keeps one."""
    p = made(log_hz, frame_hz, peak_deg)
    alpha = p.frame_alpha + np.random.default_rng(1).normal(0, NOISE_RAD, p.frame_alpha.shape)
    angles = {"time": p.frame_times} | _columns("alpha", alpha) | _columns("sigma", np.full(alpha.shape, NOISE_RAD))
    log = {"time": p.log_time} | _columns("theta", p.counted) | _columns("f", p.f)
    middle = (p.frame_times[0] + p.frame_times[-1]) / 2
    offset = p.clocks.offset_s + p.clocks.skew * (middle - p.clocks.middle_s)
    neck = yaml.safe_load(NECK_FILE.read_text())
    return Recording(neck, angles, {name: values[::every] for name, values in log.items()}, offset)


def _columns(stem: str, values: Array) -> dict[str, Array]:
    return {f"{stem}{k + 1}": values[:, k] for k in range(values.shape[1])}


def _csv(table: Table, separator: str) -> str:
    """The table as text with as many digits as numbers of this size have."""
    rows = zip(*(values.tolist() for values in table.values()), strict=True)
    lines = [separator.join(table), *(separator.join(f"{value:.13g}" for value in row) for row in rows)]
    return "\n".join(lines) + "\n"


def _write_topics(path: Path, time: Array, topics: Mapping[str, tuple[tuple[str, Array, Array], ...]]) -> None:
    """JointState as JSON."""
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2")
        schema = writer.register_schema("sensor_msgs/JointState", "jsonschema", b"{}")
        channels = [writer.register_channel(topic, "json", schema) for topic in topics]
        for k, ns in enumerate(np.rint(time * 1e9).astype(int).tolist()):
            header = {"stamp": {"sec": ns // 10**9, "nanosec": ns % 10**9}}
            for channel, joints in zip(channels, topics.values(), strict=True):
                message = {
                    "header": header,
                    "name": [name for name, _, _ in joints],
                    "position": [float(position[k]) for _, position, _ in joints],
                    "effort": [float(effort[k]) for _, _, effort in joints],
                }
                writer.add_message(channel, ns, json.dumps(message).encode(), ns)
        writer.finish()


def _log(change: Callable[[dict[str, Array]], dict[str, Array]]) -> Callable[[], Recording]:
    """The faultless recording with its log's columns changed."""

    def make() -> Recording:
        recording = faultless()
        return replace(recording, log=change(dict(recording.log)))

    return make


def _scaled(stem: str, factor: float, *numbers: int) -> Callable[[], Recording]:
    """Columns `stem` of all motors, or of some by their numbers, in another unit."""
    return _log(
        lambda log: {name: values * factor if name in _named(stem, numbers) else values for name, values in log.items()}
    )


def _named(stem: str, numbers: tuple[int, ...]) -> set[str]:
    return {f"{stem}{j}" for j in numbers or (1, 2, 3, 4)}


def _changed(stem: str, change: Callable[[Array], Array], *numbers: int) -> Callable[[], Recording]:
    return _log(
        lambda log: {name: change(values) if name in _named(stem, numbers) else values for name, values in log.items()}
    )


def _time(change: Callable[[Array], Array]) -> Callable[[], Recording]:
    return _log(lambda log: log | {"time": change(log["time"])})


def _since_1970() -> Recording:
    recording = faultless()
    later = replace(recording, offset_s=recording.offset_s + 1.7e9)
    return replace(later, log={**recording.log, "time": np.round(recording.log["time"] + 1.7e9, 4)})


def _renamed(names: Mapping[str, str]) -> Callable[[], Recording]:
    return _log(lambda log: {names.get(name, name): values for name, values in log.items()})


def _written(change: Callable[[str], str], separator: str = ",") -> Callable[[], Recording]:
    return lambda: replace(faultless(), text=change, separator=separator)


def _angles(change: Callable[[dict[str, Array]], dict[str, Array]]) -> Callable[[], Recording]:
    def make() -> Recording:
        recording = faultless()
        return replace(recording, angles=change(dict(recording.angles)))

    return make


def _angles_scaled(stem: str, factor: float) -> Callable[[], Recording]:
    return _angles(lambda angles: {name: v * factor if name.startswith(stem) else v for name, v in angles.items()})


def _small_in_degrees() -> Recording:
    recording = faultless(peak_deg=(2.0, 2.6))
    angles = {name: np.degrees(v) if name.startswith("alpha") else v for name, v in recording.angles.items()}
    return replace(recording, angles=angles)


def _motors(log: Callable[[], Recording], **keys: Any) -> Callable[[], Recording]:
    """A recording whose neck.yaml says more of every motor."""

    def make() -> Recording:
        recording = log()
        neck = copy.deepcopy(recording.neck)
        for motor in neck["motors"]:
            motor.update(keys)
        return replace(recording, neck=neck)

    return make


def _topics(*named: tuple[str, tuple[str, ...], float], joints: tuple[str, ...] = ()) -> Callable[[], Recording]:
    """The log as MCAP: for each topic its name, its joints, and by how much its angles are changed; joints: as neck.yaml has them."""

    def make() -> Recording:
        recording = faultless()
        log, topics = recording.log, {}
        for topic, names, factor in named:
            motor = {name: j + 1 for j, name in enumerate(name for name in names if name.startswith("motor"))}
            zero = np.zeros_like(log["time"])
            topics[topic] = tuple(
                (name, factor * log[f"theta{motor[name]}"], log[f"f{motor[name]}"])
                if name in motor
                else (name, zero, zero)
                for name in names
            )
        neck = copy.deepcopy(recording.neck)
        for motor, joint in zip(neck["motors"], joints, strict=False):
            motor["joint"] = joint
        return replace(recording, topics=topics, neck=neck)

    return make


def _with_unit_row(text: str) -> str:
    header, rest = text.split("\n", 1)
    return f"{header}\ns{',rad' * 4}{',N' * 4}\n{rest}"


def _row(values: Array, row: int, value: float) -> Array:
    out = values.copy()
    out[row] = value
    return out


def _after(values: Array, row: int, change: Callable[[Array], Array]) -> Array:
    return np.concatenate([values[:row], change(values[row:])])


def _held(values: Array, first: int, last: int) -> Array:
    out = values.copy()
    out[first:last] = out[first]
    return out


def _without_rows(log: dict[str, Array], first: int, last: int) -> dict[str, Array]:
    return {name: np.delete(values, slice(first, last)) for name, values in log.items()}


def _bursts(time: Array) -> Array:
    """Stamps of a receiver that gets ten rows at once."""
    first = time[np.arange(len(time)) // 10 * 10]
    return first + 1e-6 * (np.arange(len(time)) % 10)


MOTORS = ("motor1", "motor2", "motor3", "motor4")
DEG, TURN, COUNT = np.degrees(1), 1 / (2 * np.pi), COUNTS / (2 * np.pi)
R, RD = 25.0, 0.010

WRONG_LOGS: tuple[WrongLog, ...] = (
    WrongLog("time", "in milliseconds", _time(lambda t: 1e3 * t), "refused", r"milliseconds.*0\.001"),
    WrongLog("time", "in microseconds", _time(lambda t: 1e6 * t), "refused", r"microseconds.*1e-06"),
    WrongLog("time", "in nanoseconds", _time(lambda t: 1e9 * t), "refused", r"nanoseconds.*1e-09"),
    WrongLog("time", "in seconds since 1970", _since_1970, "accepted"),
    WrongLog("time", "in milliseconds since 1970", _time(lambda t: 1e3 * t + 1.7e12), "refused", r"milliseconds.*0\.001"),
    WrongLog("time", "a number of each row", _time(lambda t: np.arange(len(t)) * 1.0), "refused", "rows"),
    WrongLog("time", "rounded to hundredths of a second", _time(lambda t: np.round(t, 2)), "refused", "digits"),
    WrongLog("time", "stamped when received, ten rows at once", _time(_bursts), "refused", "bursts"),
    WrongLog("theta", "in degrees", _scaled("theta", DEG), "refused", r"degrees.*motors\[\]\.theta_scale: 0\.0174533"),
    WrongLog("theta", "in turns", _scaled("theta", TURN), "refused", r"turns.*motors\[\]\.theta_scale: 6\.28319"),
    WrongLog("theta", "in counts", _scaled("theta", COUNT), "refused", r"counts.*motors\[\]\.theta_scale: 0\.00306796"),
    WrongLog("theta", "on the gear's other side", _scaled("theta", 1 / R), "refused", r"drum.*theta_scale: 25"),
    WrongLog("theta", "degrees of the drum", _scaled("theta", DEG / R), "refused", r"degrees of the drum.*theta_scale: 0\.436332"),
    WrongLog("theta", "metres of cable", _scaled("theta", RD / R), "refused", r"cable.*theta_scale: 2500"),
    WrongLog("theta", "millimetres of cable", _scaled("theta", 1e3 * RD / R), "refused", r"mm of cable.*theta_scale: 2\.5"),
    WrongLog("theta", "of motor 3 in degrees", _scaled("theta", DEG, 3), "refused", r"motors\[2\]\.theta_scale: 0\.0174533"),
    WrongLog("theta", "of motor 2 in counts", _scaled("theta", COUNT, 2), "refused", r"motors\[1\]\.theta_scale: 0\.00306796"),
    WrongLog("theta", "of motor 2 3.2 times too small", _scaled("theta", 1 / 3.2, 2), "refused", r"theta2.* 0\.3\d* times as far"),
    WrongLog("theta", "of motor 1 10 % too large", _scaled("theta", 1.1, 1), "accepted", "drum_radius"),
    WrongLog(
        "theta", "in rad, and theta_scale says degrees", _motors(faultless, theta_scale=float(np.radians(1.0))), "refused",
        r"motors\[\]\.theta_scale: 1\b",
    ),
    WrongLog("theta", "of motor 2 reversed", _scaled("theta", -1, 2), "refused", r"theta2 runs against.*theta_sign"),
    WrongLog("theta", "all reversed", _scaled("theta", -1), "refused", "all theta run against.*theta_sign"),
    WrongLog("theta", "all reversed and in degrees", _scaled("theta", -DEG), "refused", r"theta_scale: 0\.0174533|theta_sign"),
    WrongLog(
        "theta", "of motors 2 and 3 exchanged", _renamed({"theta2": "theta3", "theta3": "theta2"}), "refused", "theta2 and theta3 are swapped"
    ),
    WrongLog(
        "theta", "columns 2, 3, 1, 4", _renamed({"theta1": "theta2", "theta2": "theta3", "theta3": "theta1"}), "refused", "order 2, 3, 1, 4|order 3, 1, 2, 4"
    ),
    WrongLog("f", "reversed", _scaled("f", -1), "refused", r"motors\[\]\.f_scale: -1"),
    WrongLog("f", "of motor 2 reversed", _scaled("f", -1, 2), "refused", r"motors\[1\]\.f_scale: -1"),
    WrongLog("f", "in millinewtons", _scaled("f", 1e3), "refused", r"motors\[\]\.f_scale: 0\.001"),
    WrongLog("f", "in kilonewtons", _scaled("f", 1e-3), "refused", r"motors\[\]\.f_scale: 1000"),
    WrongLog("f", "the motor's torque", _scaled("f", RD / R), "refused", r"motors\[\]\.f_scale: 2500"),
    WrongLog("f", "the drum's torque", _scaled("f", RD), "refused", r"motors\[\]\.f_scale: 100"),
    WrongLog("f", "the torque of motor 3 alone", _scaled("f", RD / R, 3), "refused", r"motors\[2\]\.f_scale: 2500"),
    WrongLog("f", "zero", _scaled("f", 0), "refused", "f1, f2, f3, f4"),
    WrongLog("f", "of motor 4 zero", _scaled("f", 0, 4), "refused", "f4"),
    WrongLog("f", "constant", _changed("f", lambda f: np.full_like(f, 30.0)), "refused", "f1, f2, f3, f4"),
    WrongLog("f", "of motor 2 missing", _log(lambda log: {k: v for k, v in log.items() if k != "f2"}), "refused", "lacks the column f2"),
    WrongLog("f", "not logged", _log(lambda log: {k: v for k, v in log.items() if k[0] != "f"}), "warned", "no forces"),
    WrongLog(
        "counter", "of 16 bits that wraps",
        _motors(_changed("theta", lambda th: (np.rint(th * COUNT) * 16 + 32768) % 65536 - 32768), theta_scale=float(2 * np.pi / COUNTS / 16)),
        "warned", "wrap",
    ),
    WrongLog("counter", "wraps at 0 and 2 pi", _changed("theta", lambda th: th % (2 * np.pi)), "warned", "wrap"),
    WrongLog("counter", "wraps at -pi and pi", _changed("theta", lambda th: (th + np.pi) % (2 * np.pi) - np.pi), "warned", "wrap"),
    WrongLog("counter", "theta2 one sample of 1e6", _changed("theta", lambda th: _row(th, 7000, 1e6), 2), "warned", "theta2"),
    WrongLog("counter", "theta2 one sample of zero", _changed("theta", lambda th: _row(th, 7003, 0.0), 2), "warned", "theta2"),
    WrongLog("counter", "f3 one sample of 1e5", _changed("f", lambda f: _row(f, 7000, 1e5), 3), "warned", "f3"),
    WrongLog("counter", "a row of NaN", _changed("theta", lambda th: _row(th, 7000, np.nan)), "refused", "not a number in sample 7001"),
    WrongLog("counter", "a gap of 1 s", _log(lambda log: _without_rows(log, 7000, 7500)), "warned"),
    WrongLog(
        "counter", "theta2 slips by 2 mm", _changed("theta", lambda th: _after(th, 7000, lambda part: part + 0.002 * R / RD), 2), "warned", "cable 2"
    ),
    WrongLog("counter", "theta2 loses 1 % of its counts", _changed("theta", lambda th: th + 0.01 * np.cumsum(np.maximum(np.diff(th, prepend=th[:1]), 0)), 2), "accepted", "missed_counts|drum_radius"),
    WrongLog("counter", "theta3 is stuck", _changed("theta", lambda th: np.zeros_like(th), 3), "refused", "theta3"),
    WrongLog("counter", "theta3 is stuck for 5 s", _changed("theta", lambda th: _held(th, 6000, 8500), 3), "refused", "theta3"),
    WrongLog("header", "in capitals", _renamed({f"{s}{j}": f"{s.title()}{j}" for s in ("theta", "f") for j in range(1, 5)} | {"time": "Time"}), "refused", "Theta1"),
    WrongLog("header", "with spaces and units", _renamed({f"theta{j}": f"theta {j} [rad]" for j in range(1, 5)}), "refused", "theta 1"),
    WrongLog("header", "columns parted by semicolons", _written(lambda t: t, ";"), "refused", "semicolon"),
    WrongLog("header", "columns parted by tabs", _written(lambda t: t, "\t"), "refused", "tab"),
    WrongLog("header", "semicolons and decimal commas", _written(lambda t: t.replace(".", ","), ";"), "refused", "semicolon.*comma"),
    WrongLog("header", "a row of units below it", _written(_with_unit_row), "refused", "row 2.*unit"),
    WrongLog("header", "missing", _written(lambda t: t.split("\n", 1)[1]), "refused", "no header|header"),
    WrongLog("header", "further columns", _log(lambda log: log | {"current1": log["f1"], "state": log["f2"]}), "accepted"),
    WrongLog("header", "columns in another order", _log(lambda log: dict(reversed(log.items()))), "accepted"),
    WrongLog("header", "theta4 missing", _log(lambda log: {k: v for k, v in log.items() if k != "theta4"}), "refused", "lacks the column theta4"),
    WrongLog("header", "of five motors", _log(lambda log: log | {"theta5": log["theta1"], "f5": log["f1"]}), "refused", "theta5"),
    WrongLog("topics", "measured and commanded", _topics(("/joint_states", MOTORS, 1.0), ("/joint_command", MOTORS, 1.01)), "refused", r"joint_command.*motors\[0\]\.joint: /joint_states/motor1"),
    WrongLog(
        "topics", "the same, and neck.yaml says which",
        _topics(("/joint_states", MOTORS, 1.0), ("/joint_command", MOTORS, 1.01), joints=tuple(f"/joint_states/{m}" for m in MOTORS)), "accepted",
    ),
    WrongLog("topics", "a gripper among the motors", _topics(("/joint_states", ("gripper", *MOTORS), 1.0)), "refused", r"gripper.*motors\[\]\.joint"),
    WrongLog("topics", "the same, and neck.yaml names the motors", _topics(("/joint_states", ("gripper", *MOTORS), 1.0), joints=MOTORS), "accepted"),
    *(
        WrongLog("rate", f"{500 // every} Hz, one row of {every} kept", (lambda every=every: faultless(every=every)), ends, words)
        for every, ends, words in ((50, "refused", "10 rows.*at least 50"), (25, "refused", "20 rows.*at least 50"), (10, "warned", "one row of several"), (5, "warned", "one row of several"))
    ),
    *(WrongLog("rate", f"{hz} Hz", (lambda hz=hz: faultless(hz)), "accepted") for hz in (50.0, 100.0, 200.0, 1000.0)),
    *(WrongLog("camera", f"{hz} frames a second", (lambda hz=hz: faultless(500.0, hz)), "accepted") for hz in (5.0, 10.0, 15.0, 60.0, 120.0, 240.0)),
    WrongLog("angles", "in degrees", _angles_scaled("alpha", DEG), "refused", "degrees.*0.0174533"),
    WrongLog("angles", "in degrees, of a motion by less than 3", _small_in_degrees, "refused", "degrees.*0.0174533"),
    WrongLog("angles", "time in milliseconds", _angles_scaled("time", 1e3), "refused", r"milliseconds.*0\.001"),
    WrongLog("angles", "time in frames", _angles(lambda a: a | {"time": np.rint(a["time"] * 30)}), "refused", "frames"),
    WrongLog("angles", "of two joints", _angles(lambda a: {k: v for k, v in a.items() if k[-1] != "3"}), "refused", "alpha3"),
    WrongLog("angles", "of four joints", _angles(lambda a: a | {"alpha4": a["alpha1"]}), "refused", "alpha4"),
    WrongLog("angles", "mirrored", _angles_scaled("alpha", -1), "refused", "all theta run against.*mirrored"),
    WrongLog("angles", "sigma in degrees", _angles_scaled("sigma", DEG), "refused", "sigma.*degrees.*0.0174533"),
    WrongLog("angles", "sigma 20 times too large", _angles_scaled("sigma", 20), "warned", "sigma"),
)  # fmt: skip
"""every one of them, in the order of docs/logs.md"""
