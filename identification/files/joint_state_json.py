"""sensor_msgs/JointState as JSON: every field is checked for what it is, as nothing in JSON's bytes says it."""

import json
import math
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from identification.files.joint_state_channel import (
    NANOSECONDS,
    STAMP_SECONDS,
    JointStateChannel,
    check_lengths,
    check_names,
    order_of,
)

_SHOWN = 40
"""characters of a value that is not what it should be"""
_KINDS = {
    type(None): "null",
    bool: "true or false",
    float: "a number",
    str: "a text",
    list: "a list",
    dict: "an object",
}


def decode_json(messages: Sequence[bytes], before: int) -> JointStateChannel:
    """Messages of one channel, of which `before` came earlier. Raises ValueError with the number of the message that is none."""
    names: tuple[str, ...] = ()
    times, positions, efforts = [], [], []
    for number, message in enumerate(messages, start=before + 1):
        try:
            row = _parsed(message)
            found = _names(row)
            names = names or found
            order = order_of(names, found)
            values = {word: _numbers(row, word) for word in ("position", "velocity", "effort")}
            check_lengths(len(names), {word: len(of) for word, of in values.items()})
            times.append(_stamp(row))
        except ValueError as error:
            raise ValueError(f"message {number}: {error}") from error
        positions.append([values["position"][k] for k in order])
        efforts.append([values["effort"][k] for k in order] if values["effort"] else [np.nan] * len(names))
    effort = np.array(efforts)
    return JointStateChannel(names, np.array(times), np.array(positions), None if np.isnan(effort).all() else effort)


def _parsed(message: bytes) -> dict[str, Any]:
    """A message's object; its numbers are floats, so that one of a million digits takes no longer than its bytes."""
    try:
        row = json.loads(
            message.decode("utf-8"), parse_int=float, parse_constant=_no_number, object_pairs_hook=_distinct
        )
    except UnicodeDecodeError as error:
        raise ValueError("is not UTF-8 text") from error
    except json.JSONDecodeError as error:
        raise ValueError(f"is not JSON ({error.msg} at character {error.pos + 1})") from error
    except RecursionError as error:
        raise ValueError("is nested too deep") from error
    if not isinstance(row, dict):
        raise ValueError(f"is {_kind(row)}, expected an object with header, name and position")
    return row


def _no_number(word: str) -> float:
    raise ValueError(f"{word} is no number in JSON")


def _distinct(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        key, _ = Counter(key for key, _ in pairs).most_common(1)[0]
        raise ValueError(f"key {key!r} stands twice")
    return found


def _names(row: dict[str, Any]) -> tuple[str, ...]:
    if "name" not in row:
        raise ValueError("has no name")
    names = _list(row, "name")
    for i, name in enumerate(names):
        if not isinstance(name, str):
            raise ValueError(f"name[{i}] is {_kind(name)}, expected a text")
    check_names(names)
    return tuple(names)


def _numbers(row: dict[str, Any], word: str) -> list[float]:
    """The list of that name; empty where it is left out."""
    values = _list(row, word) if word in row else []
    for i, value in enumerate(values):
        _finite(value, f"{word}[{i}]")
    return values


def _list(row: dict[str, Any], word: str) -> list[Any]:
    if not isinstance(row[word], list):
        raise ValueError(f"{word} is {_kind(row[word])}, expected a list")
    return row[word]


def _stamp(row: dict[str, Any]) -> float:
    """The header's stamp, s; its nanoseconds may be called nsec, as some bridges to JSON do."""
    stamp = _object(_object(row, "header", ""), "stamp", "header ")
    fraction = "nsec" if "nsec" in stamp and "nanosec" not in stamp else "nanosec"
    seconds, rest = (_whole(stamp, word) for word in ("sec", fraction))
    if not -STAMP_SECONDS <= seconds < STAMP_SECONDS:
        raise ValueError(f"header.stamp.sec is {seconds:.15g}, expected within +-{STAMP_SECONDS}")
    if not 0 <= rest < NANOSECONDS:
        raise ValueError(f"header.stamp.{fraction} is {rest:.15g}, expected 0 to {NANOSECONDS - 1}")
    return (seconds * NANOSECONDS + rest) / NANOSECONDS


def _object(holder: dict[str, Any], word: str, where: str) -> dict[str, Any]:
    if word not in holder:
        raise ValueError(f"{where}has no {word}")
    if not isinstance(holder[word], dict):
        raise ValueError(f"{word} is {_kind(holder[word])}, expected an object")
    return holder[word]


def _whole(stamp: dict[str, Any], word: str) -> int:
    if word not in stamp:
        raise ValueError(f"header.stamp has no {word}")
    value = _finite(stamp[word], f"header.stamp.{word}")
    if not value.is_integer():
        raise ValueError(f"header.stamp.{word} is {value:g}, expected a whole number")
    return int(value)


def _finite(value: Any, place: str) -> float:
    if not isinstance(value, float):
        raise ValueError(f"{place} is {_kind(value)}, expected a number")
    if not math.isfinite(value):
        raise ValueError(f"{place} is too large for a number")
    return value


def _kind(value: Any) -> str:
    """What a value is, with the value where it is short."""
    return f"the text {value!r}" if isinstance(value, str) and len(value) <= _SHOWN else _KINDS[type(value)]
