"""A number that decides a verdict, and the values at which it is tried."""

import importlib
from dataclasses import dataclass
from typing import Any

HALF, TWICE = "half", "twice"


@dataclass(frozen=True)
class Threshold:
    """A module's constant; half and twice of a share near one are of what it lacks of one, of a ratio above one of its excess."""

    module: str
    name: str
    half: Any
    twice: Any

    @property
    def label(self) -> str:
        """Such as `diagnosis.noise_excess.ABOVE_NOISE_RATIO`."""
        return f"{self.module}.{self.name}"

    @property
    def tried(self) -> tuple[tuple[str, Any], ...]:
        """Which of both, and the value."""
        return (HALF, self.half), (TWICE, self.twice)


def scaled(module: str, *names: str) -> list[Threshold]:
    """Constants, numbers or mappings and tuples of them, at half and at twice their values; counts stay whole.

    A constant that is the default of an argument cannot be tried: its value was bound when the function was made."""
    values = vars(importlib.import_module(module))
    return [Threshold(module, name, _times(values[name], 0.5), _times(values[name], 2)) for name in names]


def _times(value: Any, factor: float) -> Any:
    if isinstance(value, dict):
        return {key: _times(entry, factor) for key, entry in value.items()}
    if isinstance(value, tuple):
        return tuple(_times(entry, factor) for entry in value)
    if isinstance(value, int):
        return max(1, int(value * factor))
    return value * factor
