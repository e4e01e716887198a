"""The JSON schema of a YAML file, which editors take to complete keys, to show what they mean, and to mark what is wrong."""

from typing import Any

from pydantic import TypeAdapter
from pydantic.json_schema import GenerateJsonSchema


class _Schema(GenerateJsonSchema):
    """Without the titles that only repeat the keys, and with each description on one line."""

    def field_title_should_be_set(self, schema: Any) -> bool:
        return False


def json_schema(kind: Any, title: str) -> dict[str, Any]:
    """The schema of what is read as `kind`: a model or a union of models, whose docstrings are its descriptions.

    It holds what can be said of each value by itself. What values must be together is checked when the file is read.
    """
    schema = TypeAdapter(kind).json_schema(schema_generator=_Schema)
    return {"$schema": GenerateJsonSchema.schema_dialect, **_on_one_line(schema), "title": title}


def _on_one_line(value: Any) -> Any:
    if isinstance(value, dict):
        return {
            key: " ".join(part.split()) if key == "description" and isinstance(part, str) else _on_one_line(part)
            for key, part in value.items()
        }
    return [_on_one_line(part) for part in value] if isinstance(value, list) else value
