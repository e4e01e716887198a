"""Which topic of a file holds the motors: the one with their joints, by names that neck.yaml gives, or by how many there are."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import numpy as np

from identification.dataset.series import Series, numbered_columns
from identification.files.joint_state import unreadable_topic
from identification.files.joint_state_channel import JointStateChannel
from mechanism.description import Neck
from synchronisation.csv_header import IS_DATASET, is_dataset, other_kind
from synchronisation.time_stamps import check_stamped
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import listed

LED = "led"
"""column of a log, or joint of an MCAP, that says whether the light was on"""
_NUMBERED = re.compile(r"(?P<before>.*?)(?P<number>\d+)(?P<after>\D*)")
"""a name with the last number in it"""
_SHOWN = 60
"""characters of joints' names that are shown"""
_NO_FAULTS: Mapping[str, str] = MappingProxyType({})


def motor_channel(
    logs: Mapping[str, JointStateChannel], neck: Neck, path: Path, faults: Mapping[str, str] = _NO_FAULTS
) -> Series:
    """Columns theta, f and led as logged, from the one topic that holds the motors: by their joints' names, or by their number.

    faults: what is wrong with each topic that could not be read. Raises Refused where no topic holds the motors, or several do."""
    if is_dataset(logs):
        raise Refused(path, *IS_DATASET)
    joints = [motor.joint for motor in neck.motors if motor.joint is not None]
    topics = {joint: topic for joint in joints for topic in (*logs, *faults) if joint.startswith(f"/{topic}/")}
    for topic in topics.values():
        if topic in faults:
            raise Refused(path, *unreadable_topic(topic, faults[topic]))
    names = [joint.removeprefix(f"/{topics[joint]}/") if joint in topics else joint for joint in joints]
    if joints:
        fitting = {
            topic: log
            for topic, log in logs.items()
            if set(names) <= set(log.names) and all(topics.get(joint, topic) == topic for joint in joints)
        }
    else:
        fitting = {topic: log for topic, log in logs.items() if len(set(log.names) - {LED}) == neck.M}
    if len(fitting) != 1:
        raise Refused(path, *_not_one_channel(logs, faults, fitting, joints, neck.M))
    topic, log = next(iter(fitting.items()))
    check_stamped(log.time, str(path), topic)
    order = [log.names.index(name) for name in names or _by_number([name for name in log.names if name != LED])]
    force = {} if log.effort is None or np.isnan(log.effort).all() else numbered_columns("f", log.effort[:, order])
    light = {LED: log.position[:, log.names.index(LED)]} if LED in log.names else {}
    return Series(log.time, numbered_columns("theta", log.position[:, order]) | force | light)


def _by_number(names: Sequence[str]) -> list[str]:
    """Names of motors in the order of their numbers, where only these tell them apart; else as they stand."""
    parts = [_NUMBERED.fullmatch(name) for name in names]
    if not all(parts):
        return list(names)
    numbers = [int(part["number"]) for part in parts if part]
    called = {(part["before"], part["after"]) for part in parts if part}
    counted = sorted(numbers) in (list(range(len(names))), list(range(1, len(names) + 1)))
    return (
        [name for _, name in sorted(zip(numbers, names, strict=True))] if counted and len(called) == 1 else list(names)
    )


def _not_one_channel(
    logs: Mapping[str, JointStateChannel],
    faults: Mapping[str, str],
    fitting: Mapping[str, JointStateChannel],
    joints: list[str],
    motors: int,
) -> tuple[str, str]:
    """The refusal where none or several of a file's channels hold the motors, with what to write into neck.yaml."""
    held = listed(
        [
            *(f"/{topic} has {listed(log.names, limit=_SHOWN)}" for topic, log in logs.items()),
            *(f"/{topic} cannot be read: {fault}" for topic, fault in faults.items()),
        ],
        "; ",
    )
    expected = f"joints {listed(joints, limit=_SHOWN)}" if joints else f"{motors} joints"
    count = f"{len(fitting)} channels" if fitting else "no channel"
    what = f"{count} with {expected} ({held})"
    names = {name for log in logs.values() for name in log.names}
    if not fitting and (told := other_kind(names, angles_expected=False)):
        return told
    if not fitting and _spread_over_topics(logs, joints, motors):
        return f"its motors are spread over several topics ({held})", "put them into one topic, or write a CSV"
    if not fitting:
        return what, "write the name that each motor has there into neck.yaml, motors[].joint"
    topic, log = next(iter(fitting.items()))
    name = joints[0] if joints else next(name for name in log.names if name != LED)
    return (
        what,
        f"say in neck.yaml which one was measured, for every motor: motors[0].joint: /{topic}/{name}, and so on",
    )


def _spread_over_topics(logs: Mapping[str, JointStateChannel], joints: list[str], motors: int) -> bool:
    """Whether several channels together hold the joints that are named, or as many as there are motors, and none holds all."""
    held = [(topic, name) for topic, log in logs.items() for name in set(log.names) - {LED}]
    if joints:
        return set(joints) <= {called for topic, name in held for called in (name, f"/{topic}/{name}")}
    return len(logs) > 1 and len(held) == motors
