"""Values as YAML text that all readers of YAML 1.1 and 1.2 read alike."""

import math
from typing import Any


def flow(value: Any) -> str:
    """A value on one line, in flow style, that all YAML readers read alike."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {flow(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(flow(entry) for entry in value) + "]"
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"{value} has no place in a file")
        text = repr(value)  # the shortest text that reads back as the same number
        mantissa, e, exponent = text.partition("e")
        # readers of YAML 1.1 (ROS) take 5e-05 for text, but not 5.0e-05
        return f"{mantissa if '.' in mantissa else mantissa + '.0'}{e}{exponent}"
    if isinstance(value, int):
        return str(value)
    text = str(value).replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c.isprintable() else f"\\u{ord(c):04x}" for c in text) + '"'
