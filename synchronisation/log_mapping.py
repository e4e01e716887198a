"""Which columns of an unknown log are the motors', as far as names and values tell, and what neck.yaml must say for it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from identification.dataset.series import Array
from mechanism.description import LogFormat, Motor, Neck
from synchronisation.column_meaning import Column, column_meaning
from synchronisation.column_units import ANGLE_SCALES, CABLE_SCALES, FORCE_SCALES, TIME_SCALES, TORQUE_SCALES
from synchronisation.csv_header import IS_DATASET, is_dataset, other_kind
from synchronisation.csv_table import CsvFormat
from synchronisation.log_contents import LogContents
from synchronisation.log_doubts import doubts_of_angles, doubts_of_forces, doubts_of_rate, late_stamps, missing_numbers
from synchronisation.motor_topic import LED
from synchronisation.row_order import rows_by_time
from synchronisation.time_column import doubts_of_times, nanoseconds_column, time_column
from synchronisation.time_stamps import check_stamped
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import listed

_PAUSE_STEPS = 20
"""times the median step, from which on a step is a pause that is named"""
_PULLING_SHARE = 0.9
"""share of rows in which a force must be negative, to be logged with the other sign: cables only pull"""


@dataclass(frozen=True)
class LogMapping:
    """The motors' columns, or joints of one topic, in the order of the motors."""

    angles: tuple[Column, ...]
    forces: tuple[Column, ...]
    """as many as angles, or none"""
    unscaled: tuple[Column, ...]
    """where there are no forces: as many currents as angles, or forces in a unit that is not known; no number makes them N"""
    time: Column | None
    """None where messages have stamps"""
    light: Column | None
    written: CsvFormat
    topic: str | None
    pushing: bool
    """whether nearly all forces are negative"""
    rate: float
    """rows a second, median"""
    seconds: float
    gaps: tuple[tuple[float, float], ...]
    """begin and length, s, of pauses"""
    repeated: int
    """rows with the time of the one before"""
    doubts: tuple[str, ...]
    """what nothing in the log says"""
    to_mend: tuple[str, ...]
    """what must be changed in the log before it can be read"""
    nanoseconds: Column | None = None
    """what is added to the time, where a stamp is parted in two"""

    @property
    def motors(self) -> int:
        """How many motors are mapped."""
        return len(self.angles)


def survey(contents: LogContents) -> tuple[tuple[str, tuple[Column, ...]], ...]:
    """What each column, or each topic's joints, likely mean: the topic (empty of a table), and its columns."""
    if not contents.topics:
        named = contents.columns.items()
        return (
            ("", tuple(column_meaning(name, values, None, contents.units.get(name, "")) for name, values in named)),
        )
    found = []
    for topic, channel in contents.topics.items():
        columns = [column_meaning(name, channel.position[:, k], "angle") for k, name in enumerate(channel.names)]
        if channel.effort is not None:
            columns += [_effort(name, channel.effort[:, k]) for k, name in enumerate(channel.names)]
        found.append((topic, tuple(columns)))
    return tuple(found)


def _effort(joint: str, values: Array) -> Column:
    """A joint's effort (T,): letters in a joint's name are no unit but of a force."""
    column = column_meaning(joint, values, "force")
    return column if _has_scale(column) else replace(column, unit=None, unit_by="")


def map_log(path: Path, contents: LogContents, motors: int | None) -> LogMapping:
    """The mapping that names and values suggest; motors: how many there are, where it is known.

    Raises Refused where no columns can be the motors' angles, or none is the time, and for joint angles and data sets of ours.
    """
    if is_dataset(contents.topics):
        raise Refused(path, *IS_DATASET)
    mapping = _of_topics(path, contents, motors) if contents.topics else _of_table(path, contents, motors)
    has_forces = mapping.forces or mapping.unscaled
    if not has_forces and (told := other_kind([mapping.angles[0].name], angles_expected=False)):
        raise Refused(path, *told)
    return mapping


def mapped_neck(neck: Neck, mapping: LogMapping) -> Neck:
    """The description with the mapping of a log of this arm in it."""
    log, motors = neck_keys(mapping, neck.motors)
    changed = tuple(m.model_copy(update=keys) for m, keys in zip(neck.motors, motors, strict=True))
    return neck.model_copy(update={"motors": changed, **({"log": LogFormat(**log)} if log else {})})


def neck_keys(mapping: LogMapping, motors_as_described: Sequence[Motor]) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Keys of `log`, and those of each motor, that say what the log is; scales follow from gears, drums and encoders."""
    log: dict[str, Any] = {}
    if mapping.time is not None:
        log = {"time_column": mapping.time.name, "time_scale": TIME_SCALES.get(mapping.time.unit or "s", 1.0)}
        if mapping.nanoseconds is not None:
            log["nanoseconds_column"] = mapping.nanoseconds.name
        if mapping.written.separator != ",":
            log["separator"] = mapping.written.separator
        if mapping.written.decimal != ".":
            log["decimal"] = mapping.written.decimal
        if mapping.written.units_row:
            log["units_row"] = True
        if mapping.light is not None and mapping.light.name != LED:
            log["led_column"] = mapping.light.name
    motors = []
    for j, (angle, motor) in enumerate(zip(mapping.angles, motors_as_described, strict=True)):
        keys: dict[str, Any] = {}
        if mapping.topic is not None:
            keys["joint"] = f"/{mapping.topic}/{angle.name}"
        else:
            keys["theta_column"] = angle.name
        if angle.unit in ANGLE_SCALES:
            keys["theta_scale"] = _six(ANGLE_SCALES[angle.unit])
        elif angle.unit in CABLE_SCALES:
            keys["theta_scale"] = _six(CABLE_SCALES[angle.unit] * motor.R / motor.rd)
        elif angle.unit == "counts":
            keys["theta_scale"] = _six(2 * np.pi / motor.counts)
        if mapping.forces:
            force = mapping.forces[j]
            if mapping.topic is None:
                keys["f_column"] = force.name
            scale = _force_scale(force, motor.R / motor.rd)
            keys["f_scale"] = -scale if mapping.pushing else scale
        motors.append(keys)
    return log, motors


def scales_rest_on(mapping: LogMapping, motors: Sequence[Motor]) -> str:
    """On which numbers of the motors scales rest, so that they change with them; empty where on none."""
    told = []
    of_drums = {
        "f_scale": any(force.unit in TORQUE_SCALES for force in mapping.forces),
        "theta_scale": any(angle.unit in CABLE_SCALES for angle in mapping.angles),
    }
    pairs = dict.fromkeys(f"R {m.R:g}, rd {m.rd:g} m" for m in motors)
    told += [f"{key} is R / rd ({'; '.join(pairs)})" for key, is_so in of_drums.items() if is_so]
    if any(angle.unit == "counts" for angle in mapping.angles):
        told.append(f"theta_scale is 2 pi / counts ({', '.join(dict.fromkeys(str(m.counts) for m in motors))})")
    return f"{', '.join(told)}: change it with them" if told else ""


def _force_scale(force: Column, gear: float) -> float:
    if force.unit in TORQUE_SCALES:
        return _six(TORQUE_SCALES[force.unit] * gear)
    return _six(FORCE_SCALES[force.unit or "N"])


def _has_scale(column: Column) -> bool:
    """Whether a force's unit is known, or taken for N as none is said."""
    return column.unit is None or column.unit in FORCE_SCALES or column.unit in TORQUE_SCALES


def _six(value: float) -> float:
    return float(f"{value:.6g}")


def _of_table(path: Path, contents: LogContents, motors: int | None) -> LogMapping:
    ((_, columns),) = survey(contents)
    time = time_column(path, columns, contents)
    angles = _group(columns, "angle", motors, prefer_commanded=False)
    if not angles:
        raise Refused(path, *_no_angles(columns, motors))
    if not any(np.isfinite(contents.columns[c.name]).any() for c in angles):
        what = f"{listed(c.name for c in angles)} hold no numbers"
        raise Refused(path, what, "is it what the controller wrote?")
    scaled = [c for c in columns if c.kind != "force" or _has_scale(c)]
    forces = _group(scaled, "force", len(angles), prefer_commanded=True)
    unscaled: tuple[Column, ...] = ()
    if not forces:
        of_kinds = (_group(columns, kind, len(angles), prefer_commanded=True) for kind in ("force", "current"))
        unscaled = next(filter(None, of_kinds), ())
    angles = _by_letters(angles)
    forces, unscaled = _beside(angles, forces), _beside(angles, unscaled)
    light = next((c for c in columns if c.kind == "light" and {c.low, c.high} <= {0.0, 1.0}), None)
    nanoseconds = nanoseconds_column(columns, contents, time)
    stamps = contents.columns[time.name] * TIME_SCALES.get(time.unit or "s", 1.0)
    if nanoseconds is not None:
        stamps = stamps + TIME_SCALES["ns"] * contents.columns[nanoseconds.name]
    values = np.column_stack([contents.columns[c.name] for c in forces]) if forces else np.empty((0, 0))
    written = replace(contents.written, time_column=time.name)
    mapping = _mapping(stamps, angles, (forces, unscaled), values, time, light, written, None)
    to_mend = (*mapping.to_mend, *missing_numbers(contents, (*angles, *forces)))
    doubts = (*doubts_of_times(columns, contents, time), *_doubts_of_order(angles), *mapping.doubts)
    return replace(mapping, to_mend=to_mend, nanoseconds=nanoseconds, doubts=doubts)


def _of_topics(path: Path, contents: LogContents, motors: int | None) -> LogMapping:
    """The topic with as many joints as motors, or the one with most rows."""
    found = dict(survey(contents))
    sizes = {topic: len(set(channel.names) - {LED}) for topic, channel in contents.topics.items()}
    fitting = [topic for topic in found if motors is None or sizes[topic] >= motors]
    if not fitting:
        held = listed((f"/{topic} has {count}" for topic, count in sizes.items()), "; ")
        raise Refused(path, f"no topic has {motors} joints ({held})", "is it this arm's neck.yaml?")
    measured = [t for t in fitting if not column_meaning(t, np.empty(0)).commanded] or fitting
    topic = max(measured, key=lambda t: (sizes[t] == motors, len(contents.topics[t].time)))
    channel = contents.topics[topic]
    check_stamped(channel.time, str(path), topic)
    columns = found[topic]
    joints = tuple(c for c in columns if c.kind == "angle" and c.name != LED)
    angles = _group(joints, "angle", motors, prefer_commanded=False) or joints[: motors or len(joints)]
    by_name = {c.name: c for c in columns if c.kind == "force"}
    forces = tuple(by_name[a.name] for a in angles if a.name in by_name)
    values = np.empty((0, 0))
    if channel.effort is not None:
        values = channel.effort[:, [channel.names.index(c.name) for c in forces]]
    mapping = _mapping(channel.time, angles, (forces, ()), values, None, None, CsvFormat(), topic)
    elsewhere = [f"/{other} holds efforts" for other in _topics_with_efforts(contents, topic)]
    elsewhere += [f"/{other} cannot be read: {fault}" for other, fault in contents.faults.items()]
    if mapping.forces or not elsewhere:
        return mapping
    said = f"forces: /{topic} holds none, but {listed(elsewhere, '; ')}"
    do = "one topic must hold both: write position and effort of each motor into one JointState, or a CSV"
    return replace(mapping, doubts=(*mapping.doubts[:-1], f"{said}; {do}"))


def _topics_with_efforts(contents: LogContents, topic: str) -> list[str]:
    """Other topics that hold as many efforts as this one has joints, at least."""
    joints = len(contents.topics[topic].names)
    others = {
        name: channel for name, channel in contents.topics.items() if name != topic and len(channel.names) >= joints
    }
    return [name for name, channel in others.items() if channel.effort is not None]


def _mapping(
    stamps: Array,
    angles: tuple[Column, ...],
    forces_and_unscaled: tuple[tuple[Column, ...], tuple[Column, ...]],
    values: Array,
    time: Column | None,
    light: Column | None,
    written: CsvFormat,
    topic: str | None,
) -> LogMapping:
    forces, unscaled = forces_and_unscaled
    stamps = stamps[rows_by_time(stamps)]
    steps = np.diff(stamps)
    step = float(np.median(steps[steps > 0])) if np.any(steps > 0) else np.nan
    pauses = np.flatnonzero(steps > _PAUSE_STEPS * step)
    # a joint's force that was never logged is all NaN
    if values.size and np.isnan(values).all():
        forces = ()
    pushing = bool(forces) and float(np.mean(values < 0)) > _PULLING_SHARE
    return LogMapping(
        angles=angles,
        forces=forces,
        unscaled=unscaled,
        time=time,
        light=light,
        written=written,
        topic=topic,
        pushing=pushing,
        rate=1 / step,
        seconds=float(stamps[-1] - stamps[0]),
        gaps=tuple((float(stamps[k] - stamps[0]), float(steps[k])) for k in pauses),
        repeated=int(np.sum(steps == 0)),
        doubts=(*doubts_of_rate(1 / step), *doubts_of_angles(angles, time), *doubts_of_forces(forces, unscaled)),
        to_mend=tuple(late_stamps(stamps)),
    )


def _group(columns: Sequence[Column], kind: str, motors: int | None, prefer_commanded: bool) -> tuple[Column, ...]:
    """Columns of one kind whose names differ in a number alone, as many as motors: those commanded or not, then the plainest.

    `theta1` is thought to be the motor's angle before `theta1_x`, and `f1` its command before `f1_meas`."""
    groups: dict[str, list[Column]] = {}
    for column in columns:
        if column.kind == kind:
            groups.setdefault(column.stem, []).append(column)
    numbered = [
        g for g in groups.values() if len({c.number for c in g}) == len(g) and None not in {c.number for c in g}
    ]
    alone = [c for g in groups.values() for c in g if len(g) == 1]
    candidates = [sorted(g, key=lambda c: c.number or 0) for g in numbered]
    if len(alone) > 1:  # left_pos, right_pos: names without numbers, in the file's order
        candidates.append(sorted(alone, key=list(columns).index))
    fitting = [g for g in candidates if motors is None or len(g) == motors]
    if not fitting:
        return ()

    def fitness(group: list[Column]) -> tuple[bool, bool, int, int]:
        first = group[0]
        unlike = first.measured if prefer_commanded else first.commanded
        return first.commanded == prefer_commanded, not unlike, len(group), -len(first.stem.split())

    return tuple(max(fitting, key=fitness))


def _doubts_of_order(angles: Sequence[Column]) -> tuple[str, ...]:
    """That nothing says which motor is which, where columns have no numbers."""
    labels = _labels(angles)
    return (f"which motor is which: {listed(labels)} are taken for 1 to {len(labels)}",) if labels else ()


def _labels(columns: Sequence[Column]) -> list[str]:
    """What tells each of several columns from the others, where no number does: the words of its name that not all have."""
    words = [set(column.stem.split()) for column in columns]
    common = set[str].intersection(*words) if words else set[str]()
    labels = [" ".join(sorted(of_column - common)) for of_column in words]
    return labels if len(set(labels)) == len(labels) and all(c.number is None for c in columns) else []


def _by_letters(columns: tuple[Column, ...]) -> tuple[Column, ...]:
    """Columns that one letter each tells apart in the order of the letters, as numbers are; others as they are."""
    labels = _labels(columns)
    if not labels or any(len(label) != 1 for label in labels):
        return columns
    return tuple(columns[k] for k in np.argsort(labels))


def _beside(angles: Sequence[Column], others: tuple[Column, ...]) -> tuple[Column, ...]:
    """Columns that the same words tell apart as the motors' angles, each beside its own; others as they are."""
    of_angles, of_others = _labels(angles), _labels(others)
    if not of_angles or sorted(of_angles) != sorted(of_others):
        return others
    return tuple(others[of_others.index(label)] for label in of_angles)


def _no_angles(columns: Sequence[Column], motors: int | None) -> tuple[str, str]:
    if told := other_kind([c.name for c in columns], angles_expected=False):
        return told
    wanted = f"{motors} motors" if motors else "motors"
    angles = [c.name for c in columns if c.kind == "angle"]
    seen = f"only {listed(angles)}" if angles else f"columns are {listed(c.name for c in columns)}"
    return (
        f"no columns look like the angles of {wanted}; {seen}",
        "name them in neck.yaml: motors[].theta_column, f_column",
    )
