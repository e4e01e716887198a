"""JSON text that every reader takes: numbers that JSON cannot express become null."""

import json
import math
from typing import Any


def json_text(value: Any) -> str:
    """A value as JSON text; infinities and NaN become null."""
    return json.dumps(_plain(value), indent=2, ensure_ascii=False) + "\n"


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
