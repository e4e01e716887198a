"""JSON text that every reader takes, and records read back from it.

Numbers that JSON cannot express become null, what does not print becomes an escape.
"""

import json
import math
import re
from pathlib import Path
from typing import Any

from xneck_foundation.authorship import JSON_KEY, written_by_xneck

_NOT_ASCII = re.compile(r"[^\n\x20-\x7e]")


def json_text(value: Any) -> str:
    """A value as JSON text; infinities and NaN become null, and characters that do not print are escaped."""
    text = json.dumps(_plain(value), indent=2, ensure_ascii=False) + "\n"
    return _NOT_ASCII.sub(lambda found: found[0] if found[0].isprintable() else json.dumps(found[0])[1:-1], text)


def json_line(value: Any) -> str:
    """A value as JSON on one line; infinities and NaN become null, and characters beyond ASCII are escaped."""
    return json.dumps(_plain(value))


def read_record(path: Path) -> dict[str, Any]:
    """A record that xneck wrote, as it was before it was marked. Raises OSError, or ValueError where a file is not as written."""
    if not written_by_xneck(path):
        raise ValueError(f"{path} is not as xneck wrote it")
    record = json.loads(path.read_text(encoding="utf-8"))
    record.pop(JSON_KEY)
    return record


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
