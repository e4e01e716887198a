"""Strict YAML: scalars by YAML 1.2, no duplicate or unknown keys, and all faults of a file in one refusal."""

import json
import re
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ConfigDict, ValidationError

from xneck_foundation.errors import Refused
from xneck_foundation.input_file import check_input

_MAX_BYTES = 1_000_000
"""largest file: ours are some kB, and as many bytes are parsed in seconds (docs/thresholds.md)"""
_MAX_DEPTH = 20
"""deepest nesting: ours are four deep (docs/thresholds.md)"""


class Strict(BaseModel):
    """Base of everything read from YAML: frozen, no unknown keys, finite numbers, no text taken for a number."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=True)


M = TypeVar("M", bound=BaseModel)


class _Loader(yaml.SafeLoader):
    """YAML 1.2's idea of scalars, duplicate keys and aliases refused."""

    depth = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.AliasEvent):
            raise yaml.MarkedYAMLError(problem="aliases are not read", problem_mark=self.peek_event().start_mark)
        if self.depth == _MAX_DEPTH:
            where = self.peek_event().start_mark
            raise yaml.MarkedYAMLError(problem=f"nested more than {_MAX_DEPTH} deep", problem_mark=where)
        self.depth += 1
        node = super().compose_node(parent, index)
        self.depth -= 1
        return node

    def construct_mapping(self, node: Any, deep: bool = False) -> dict[Any, Any]:
        keys: set[Any] = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if not isinstance(key, str):
                raise yaml.MarkedYAMLError(problem=f"key {key!r} is not text", problem_mark=key_node.start_mark)
            if key in keys:
                raise yaml.MarkedYAMLError(problem=f"key {key!r} stands twice", problem_mark=key_node.start_mark)
            keys.add(key)
        return super().construct_mapping(node, deep)


# left out, as no key of ours needs them: bytes, dates, sets, pairs
_Loader.yaml_constructors = {
    tag: construct
    for tag, construct in yaml.SafeLoader.yaml_constructors.items()
    if tag is None or tag.rpartition(":")[2] in ("str", "int", "float", "bool", "null", "seq", "map")
}
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
    """The document in `text`; `where` names it in a refusal."""
    try:
        return yaml.load(text, Loader=_Loader)
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else "?"
        raise Refused(where, f"line {line}: {error.problem}", "correct the YAML there") from error
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise Refused(where, f"not YAML ({str(error).splitlines()[0]})") from error


def read_text(path: Path) -> str:
    """A text file's content, refused by name where it is missing, a folder, huge or not UTF-8."""
    check_input(path)
    try:
        if path.stat().st_size > _MAX_BYTES:
            raise Refused(path, f"larger than {_MAX_BYTES // 1_000_000} MB", "is this the right file?")
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise Refused(path, f"cannot be read ({getattr(error, 'strerror', None) or 'not UTF-8 text'})") from error


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
        raise Refused(where, "; ".join(_fault(e) for e in error.errors()), hint) from error


def _fault(error: Any) -> str:
    place = ""
    for part in error["loc"]:
        place += f"[{part}]" if isinstance(part, int) else (f".{part}" if place else str(part))
    place = place or "the file as a whole"
    if error["type"] == "missing":
        return f"{place}: missing"
    if error["type"] == "extra_forbidden":
        return f"{place}: unknown key"
    message = error["msg"].removeprefix("Value error, ")
    message = message.replace("Input should be", "expected")
    message = message[0].lower() + message[1:]
    found = error["input"]
    shown = "" if isinstance(found, dict | list | BaseModel) else f", found {found!r}"
    return f"{place}: {message}{shown}"
