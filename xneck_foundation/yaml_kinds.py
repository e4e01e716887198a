"""Which of our YAML files a document is, by a key that no other has, to name one that was given in the place of another."""

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class YamlKind:
    """One of the YAML files that commands read."""

    keys: tuple[str, ...]
    """each such a file has, and no other"""
    name: str
    file: str
    """as it is called where commands and documents speak of it"""


_KINDS = (
    YamlKind(("xneck_model",), "a model of `xneck identify`", "model.yaml"),
    YamlKind(("mechanisms",), "the description of an arm", "neck.yaml"),
    YamlKind(("camera_matrix", "cam0"), "the calibration of a camera", "camera.yaml"),
    YamlKind(("kind",), "a calibration board", "board.yaml"),
    YamlKind(("video", "angles"), "the list of a recording's files", "recording.yaml"),
)


def yaml_kind_of(keys: Collection[str]) -> YamlKind | None:
    """The kind of file whose keys these are; None where they tell none."""
    return next((kind for kind in _KINDS if any(key in keys for key in kind.keys)), None)


def given_instead(document: dict[str, Any], expected: Collection[str]) -> tuple[str, str] | None:
    """What to say where a document is one of our files, and the keys that were expected are those of another; else None."""
    found, wanted = yaml_kind_of(document), yaml_kind_of(expected)
    if found is None or wanted is None or any(key in document for key in wanted.keys):
        return None
    return f"is {found.name} ({found.file}), not {wanted.name}", f"give a {wanted.file} here"
