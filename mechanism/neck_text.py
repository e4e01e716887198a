"""An arm as the text of a neck.yaml, for instance with its markers where a recording showed them to be."""

from typing import Any

from mechanism.description import Neck
from xneck_foundation.yaml_text import flow


def neck_text(neck: Neck, comment: str = "") -> str:
    """neck.yaml with every key that was given, to full precision; `comment` (any number of lines) goes on top."""
    keys = neck.model_dump(mode="json", exclude_unset=True, exclude_none=True)
    lines = [f"# {line}".rstrip() for line in comment.splitlines()]
    for key, value in keys.items():
        if key == "markers":
            lines.append("markers:")
            lines += [f"  {k}: {flow(v)}" for k, v in value.items() if k != "on_bars"]
            lines += ["  on_bars:", *_entries(value["on_bars"], "    ")]
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            lines += [f"{key}:", *_entries(value, "  ")]
        else:
            lines.append(f"{key}: {flow(value)}")
    return "\n".join(lines) + "\n"


def _entries(values: list[dict[str, Any]], indent: str) -> list[str]:
    return [f"{indent}- {flow(value)}" for value in values]
