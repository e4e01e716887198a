"""Strict YAML: scalars by YAML 1.2, no duplicate or unknown keys, and all faults of a file in one refusal."""

import json
import re
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ConfigDict, ValidationError

from xneck_foundation.document_faults import described_faults
from xneck_foundation.errors import Refused
from xneck_foundation.input_file import check_input
from xneck_foundation.spelling import quoted

_MAX_BYTES = 1_000_000
"""largest file: ours are some kB, and as many bytes are parsed in seconds (docs/thresholds.md)"""
_MAX_DEPTH = 20
"""deepest nesting: ours are four deep (docs/thresholds.md)"""
_MAX_VALUES = 50_000
"""most keys and values: a covariance of 200 parameters has 40,000; as many take 1 to 3 s (docs/thresholds.md)"""
_MAX_DIGITS = 400
"""longest whole number: more than the largest that a computer reckons with has (docs/thresholds.md)"""


class Strict(BaseModel):
    """Base of everything read from YAML: frozen, no unknown keys, finite numbers, no text taken for a number."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=True)


M = TypeVar("M", bound=BaseModel)


class _Loader(yaml.SafeLoader):
    """YAML 1.2's idea of scalars; duplicate keys, aliases and tags refused."""

    depth = 0
    values = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        event = self.peek_event()
        if self.check_event(yaml.AliasEvent):
            raise _at(event, "aliases are not read")
        if event.tag is not None:
            raise _at(event, f"tags such as {quoted(event.tag)} are not read")
        if self.depth == _MAX_DEPTH:
            raise _at(event, f"nested more than {_MAX_DEPTH} deep")
        self.values += 1
        if self.values > _MAX_VALUES:
            raise _at(event, f"more than {_MAX_VALUES} keys and values")
        self.depth += 1
        node = super().compose_node(parent, index)
        self.depth -= 1
        return node

    def construct_mapping(self, node: Any, deep: bool = False) -> dict[Any, Any]:
        keys: set[Any] = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if not isinstance(key, str):
                raise _at(key_node, f"key {quoted(str(key))} is not text")
            if key in keys:
                raise _at(key_node, f"key {quoted(key)} stands twice")
            keys.add(key)
        return super().construct_mapping(node, deep)

    def construct_whole_number(self, node: Any) -> int:
        if len(node.value) > _MAX_DIGITS:
            raise _at(node, f"a number of {len(node.value)} digits")
        return int(node.value)


def _at(place: Any, problem: str) -> yaml.MarkedYAMLError:
    """An error at an event or a node."""
    return yaml.MarkedYAMLError(problem=problem, problem_mark=place.start_mark)


_Loader.add_constructor("tag:yaml.org,2002:int", _Loader.construct_whole_number)
# PyYAML's own resolvers read 1e-3 as text, 012 as 10, 1:30 as 90, on as True: replaced by YAML 1.2's core schema
_Loader.yaml_implicit_resolvers = {}
for _tag, _pattern, _first in (
    ("bool", r"true|True|TRUE|false|False|FALSE", "tTfF"),
    ("null", r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    ("int", r"[-+]?(0|[1-9][0-9]*)", "-+0123456789"),
    ("float", r"[-+]?(\.[0-9]+|(0|[1-9][0-9]*)(\.[0-9]*)?)([eE][-+]?[0-9]+)?", "-+.0123456789"),
    ("float", r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)", "-+."),
):
    _Loader.add_implicit_resolver(f"tag:yaml.org,2002:{_tag}", re.compile(f"^(?:{_pattern})$"), list(_first))


def load_yaml(path: str | Path) -> Any:
    """The document in `path`. Raises Refused where it is missing, too large, not YAML, or ambiguous."""
    return parse_yaml(read_text(Path(path)), path)


def parse_yaml(text: str, where: str | Path) -> Any:
    """The document in `text`; `where` names it in a refusal. Raises Refused as `load_yaml` does."""
    _check_length(text, where)
    try:
        return yaml.load(text, Loader=_Loader)
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else "?"
        problem = ", ".join(filter(None, (error.context, error.problem)))
        raise Refused(where, f"line {line}: {problem}", "correct the YAML there") from error
    except yaml.reader.ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        what = f"line {line}: a character that is not text, U+{error.character:04X}"
        raise Refused(where, what, "is this a text file?") from error


def read_text(path: Path) -> str:
    """A text file's content, refused by name where it is missing, a folder, huge or not UTF-8."""
    check_input(path)
    try:
        with path.open(encoding="utf-8") as stream:
            text = stream.read(_MAX_BYTES + 1)
    except (OSError, UnicodeDecodeError) as error:
        raise Refused(path, f"cannot be read ({getattr(error, 'strerror', None) or 'not UTF-8 text'})") from error
    _check_length(text, path)
    return text


def _check_length(text: str, where: str | Path) -> None:
    if len(text) > _MAX_BYTES:
        raise Refused(where, f"larger than {_MAX_BYTES // 1_000_000} MB", "is this the right file?")


def read_yaml(path: str | Path, kind: type[M], hint: str = "") -> M:
    """`path` as a `kind`; raises Refused with every fault and its key's path, and `hint` for what to do."""
    return validate_document(load_yaml(path), kind, path, hint)


def validate_document(document: Any, kind: type[M], where: str | Path, hint: str = "") -> M:
    """A loaded document as a `kind`; raises Refused with every fault, its path, what was found and what is expected."""
    if not isinstance(document, dict):
        raise Refused(where, f"expected keys and values, found {type(document).__name__}")
    try:
        # by JSON's rules a list may become a tuple and an integer a float, but text is never a number
        return kind.model_validate_json(json.dumps(document))
    except ValidationError as error:
        raise Refused(where, described_faults(error.errors(), kind, document), hint) from error
