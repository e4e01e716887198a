"""What is measured together: worlds with known truth, how a verdict on them is judged, and the thresholds that decide it."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from benchmarks.thresholds.outcome import Outcome
from benchmarks.thresholds.threshold import Threshold


class World(Protocol):
    """Anything with a name, which says what is hidden in it."""

    @property
    def name(self) -> str: ...


@dataclass(frozen=True)
class Room:
    """Worlds are asked for with a folder in which they keep what takes long to make."""

    name: str
    worlds: Callable[[Path], Sequence[Any]]
    judged: Callable[[Any], Outcome]
    thresholds: Callable[[], Sequence[Threshold]]
    kept: Callable[[], AbstractContextManager[Callable[[], None] | None]] = nullcontext
    """entered for each world: what thresholds do not change is computed once in it; gives what to call before each judgement"""
