"""A recording without fault, and changes to it of the kind that loggers, spreadsheets and wiring make, as files."""

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

SECONDS = 20.0
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
    """Twenty seconds of dry friction and damped cables."""
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


def log_changed(change: Callable[[dict[str, Array]], dict[str, Array]]) -> Callable[[], Recording]:
    """The faultless recording with its log's columns changed."""

    def make() -> Recording:
        recording = faultless()
        return replace(recording, log=change(dict(recording.log)))

    return make


def scaled(stem: str, factor: float, *numbers: int) -> Callable[[], Recording]:
    """Columns `stem` of all motors, or of some by their numbers, in another unit."""
    return log_changed(
        lambda log: {name: values * factor if name in _named(stem, numbers) else values for name, values in log.items()}
    )


def _named(stem: str, numbers: tuple[int, ...]) -> set[str]:
    return {f"{stem}{j}" for j in numbers or (1, 2, 3, 4)}


def columns_changed(stem: str, change: Callable[[Array], Array], *numbers: int) -> Callable[[], Recording]:
    return log_changed(
        lambda log: {name: change(values) if name in _named(stem, numbers) else values for name, values in log.items()}
    )


def time_changed(change: Callable[[Array], Array]) -> Callable[[], Recording]:
    return log_changed(lambda log: log | {"time": change(log["time"])})


def since_1970() -> Recording:
    recording = faultless()
    later = replace(recording, offset_s=recording.offset_s + 1.7e9)
    return replace(later, log={**recording.log, "time": np.round(recording.log["time"] + 1.7e9, 4)})


def renamed(names: Mapping[str, str]) -> Callable[[], Recording]:
    return log_changed(lambda log: {names.get(name, name): values for name, values in log.items()})


def text_changed(change: Callable[[str], str], separator: str = ",") -> Callable[[], Recording]:
    return lambda: replace(faultless(), text=change, separator=separator)


def angles_changed(change: Callable[[dict[str, Array]], dict[str, Array]]) -> Callable[[], Recording]:
    def make() -> Recording:
        recording = faultless()
        return replace(recording, angles=change(dict(recording.angles)))

    return make


def angles_scaled(stem: str, factor: float) -> Callable[[], Recording]:
    return angles_changed(
        lambda angles: {name: v * factor if name.startswith(stem) else v for name, v in angles.items()}
    )


def small_in_degrees() -> Recording:
    recording = faultless(peak_deg=(2.0, 2.6))
    angles = {name: np.degrees(v) if name.startswith("alpha") else v for name, v in recording.angles.items()}
    return replace(recording, angles=angles)


def motors_saying(log: Callable[[], Recording], **keys: Any) -> Callable[[], Recording]:
    """A recording whose neck.yaml says more of every motor."""

    def make() -> Recording:
        recording = log()
        neck = copy.deepcopy(recording.neck)
        for motor in neck["motors"]:
            motor.update(keys)
        return replace(recording, neck=neck)

    return make


def as_topics(*named: tuple[str, tuple[str, ...], float], joints: tuple[str, ...] = ()) -> Callable[[], Recording]:
    """The log as MCAP: each topic with its joints, and a factor on its angles; joints: as neck.yaml has them."""

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


def with_unit_row(text: str) -> str:
    header, rest = text.split("\n", 1)
    return f"{header}\ns{',rad' * 4}{',N' * 4}\n{rest}"


def with_sample(values: Array, row: int, value: float) -> Array:
    out = values.copy()
    out[row] = value
    return out


def changed_after(values: Array, row: int, change: Callable[[Array], Array]) -> Array:
    return np.concatenate([values[:row], change(values[row:])])


def held(values: Array, first: int, last: int) -> Array:
    out = values.copy()
    out[first:last] = out[first]
    return out


def without_rows(log: dict[str, Array], first: int, last: int) -> dict[str, Array]:
    return {name: np.delete(values, slice(first, last)) for name, values in log.items()}


def in_hundredths(time: Array) -> Array:
    """Stamps with two digits behind the point."""
    return np.array([round(t, 2) for t in time.tolist()])


def in_bursts(time: Array) -> Array:
    """Stamps of a receiver that gets ten rows at once."""
    first = time[np.arange(len(time)) // 10 * 10]
    return first + 1e-6 * (np.arange(len(time)) % 10)
