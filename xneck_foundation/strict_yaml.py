"""Strict YAML: scalars by YAML 1.2, no duplicate or unknown keys, and all faults of a file in one refusal.

What is alike may be said once: an anchor (`&motor`) names a value, an alias (`*motor`) stands for it, and a merge key
(`<<: *motor`) takes its keys over, of which others may be given beside it. A document counts with its aliases written out.
"""

import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ConfigDict, ValidationError

from xneck_foundation.document_faults import described_faults
from xneck_foundation.errors import Refused
from xneck_foundation.file_kind import known_kind
from xneck_foundation.input_file import check_input
from xneck_foundation.spelling import quoted
from xneck_foundation.yaml_kinds import given_instead

_MAX_BYTES = 1_000_000
"""largest file, and most characters of its values with aliases written out: ours are some kB, and as many bytes are parsed in
seconds (docs/thresholds.md)"""
_MAX_DEPTH = 20
"""deepest nesting: ours are four deep (docs/thresholds.md)"""
_MAX_VALUES = 50_000
"""most keys and values: a covariance of 200 parameters has 40,000; as many take 1 to 3 s (docs/thresholds.md)"""
_MAX_DIGITS = 400
"""longest whole number: more than the largest that a computer reckons with has (docs/thresholds.md)"""


_TEXT, _MERGE = "tag:yaml.org,2002:str", "tag:yaml.org,2002:merge"


class Strict(BaseModel):
    """Base of everything read from YAML: frozen, no unknown keys, finite numbers, no text taken for a number."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", allow_inf_nan=False, strict=True, use_attribute_docstrings=True
    )


M = TypeVar("M", bound=BaseModel)


@dataclass(frozen=True)
class _Size:
    """What a value comes to with its aliases written out."""

    values: int
    """keys and values in it, itself included"""
    characters: int
    depth: int
    """levels that it has, itself included"""


class _Loader(yaml.SafeLoader):
    """YAML 1.2's idea of scalars, aliases and merge keys; duplicate keys and tags refused."""

    def __init__(self, stream: str) -> None:
        super().__init__(stream)
        self.depth = self.values = self.characters = 0
        self.sizes: dict[yaml.Node, _Size] = {}
        """of every value that is complete"""

    def compose_node(self, parent: Any, index: Any) -> Any:
        event = self.peek_event()
        if self.check_event(yaml.AliasEvent):
            return self._compose_alias(event, parent, index)
        if event.tag is not None:
            raise _at(event, f"tags such as {quoted(event.tag)} are not read")
        values, characters = self.values, self.characters
        self._count(event, _Size(1, len(getattr(event, "value", "")), 1))
        self.depth += 1
        node: Any = super().compose_node(parent, index)
        self.depth -= 1
        deepest = max((self.sizes[child].depth for child in _children(node)), default=0)
        self.sizes[node] = _Size(self.values - values, self.characters - characters, deepest + 1)
        return node

    def _compose_alias(self, event: Any, parent: Any, index: Any) -> Any:
        """The value of an alias; it counts as if it were written out there."""
        node = super().compose_node(parent, index)
        if node not in self.sizes:
            raise _at(event, f"*{event.anchor} stands within what it stands for")
        self._count(event, self.sizes[node])
        return node

    def _count(self, event: Any, size: _Size) -> None:
        """Adds a value at an event to what the document comes to."""
        self.values += size.values
        self.characters += size.characters
        if self.depth + size.depth > _MAX_DEPTH:
            raise _at(event, f"nested more than {_MAX_DEPTH} deep")
        if self.values > _MAX_VALUES:
            raise _at(event, f"more than {_MAX_VALUES} keys and values")
        if self.characters > _MAX_BYTES:
            raise _at(event, f"more than {_MAX_BYTES} characters with aliases written out")

    def compose_mapping_node(self, anchor: Any) -> yaml.MappingNode:
        node = super().compose_mapping_node(anchor)
        keys: set[str] = set()
        for key, value in node.value:
            if key.tag not in (_TEXT, _MERGE):
                shown = key.value if isinstance(key, yaml.ScalarNode) else "that is none"
                raise _at(key, f"key {quoted(shown)} is not text")
            if key.value in keys:
                raise _at(key, f"key {quoted(key.value)} stands twice")
            if key.tag == _MERGE and not isinstance(value, yaml.MappingNode):
                raise _at(value, "<< takes over one group of keys, such as <<: *motor")
            keys.add(key.value)
        return node

    def construct_whole_number(self, node: Any) -> int:
        if len(node.value) > _MAX_DIGITS:
            raise _at(node, f"a number of {len(node.value)} digits")
        return int(node.value)


def _children(node: Any) -> list[Any]:
    """The values that are directly in a node, with keys."""
    if isinstance(node, yaml.ScalarNode):
        return []
    return [child for entry in node.value for child in (entry if isinstance(entry, tuple) else (entry,))]


def _at(place: Any, problem: str) -> yaml.MarkedYAMLError:
    """An error at an event or a node."""
    return yaml.MarkedYAMLError(problem=problem, problem_mark=place.start_mark)


_Loader.add_constructor("tag:yaml.org,2002:int", _Loader.construct_whole_number)
# PyYAML's own resolvers read 1e-3 as text, 012 as 10, 1:30 as 90, on as True: replaced by YAML 1.2's core schema
_Loader.yaml_implicit_resolvers = {}
for _tag, _pattern, _first in (
    ("merge", r"<<", "<"),
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
        do = "indent with spaces, not with tabs" if r"'\t'" in problem else "correct the YAML there"
        raise Refused(where, f"line {line}: {problem}", do) from error
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
    except UnicodeDecodeError as error:
        kind = known_kind(path)
        if kind is not None and not kind.is_text:
            raise Refused(path, f"is {kind.name}, and no text", "name the file that is meant, or its folder") from error
        raise Refused(path, "cannot be read (not UTF-8 text)", "save it as UTF-8") from error
    except OSError as error:
        raise Refused(path, f"cannot be read ({error.strerror})") from error
    _check_length(text, path)
    return text


def _check_length(text: str, where: str | Path) -> None:
    if len(text) > _MAX_BYTES:
        raise Refused(where, f"larger than {_MAX_BYTES // 1_000_000} MB", "is this the right file?")


def read_yaml(path: str | Path, kind: type[M], hint: str = "") -> M:
    """`path` as a `kind`; raises Refused with every fault and its key's path, and `hint` for what to do."""
    return validate_document(load_yaml(path), kind, path, hint)


def _kind_of(document: Any) -> str:
    """What a document is that has no keys, in words."""
    if document is None:
        return "nothing"
    return "a list" if isinstance(document, list) else "a single value"


def validate_document(document: Any, kind: type[M], where: str | Path, hint: str = "", written: bool = True) -> M:
    """A loaded document as a `kind`; raises Refused with every fault, its path, what was found and what is expected.

    written: whether a person wrote all of it; False where keys were set in one that was read.
    """
    if not isinstance(document, dict):
        raise Refused(where, f"expected keys and values, found {_kind_of(document)}", "is this the right file?")
    if told := given_instead(document, kind.model_fields):
        raise Refused(where, *told)
    try:
        # by JSON's rules a list may become a tuple and an integer a float, but text is never a number
        return kind.model_validate_json(json.dumps(document))
    except ValidationError as error:
        raise Refused(where, described_faults(error.errors(), kind, document, written), hint) from error
