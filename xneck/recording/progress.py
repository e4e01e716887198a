"""Who is told how far the stages of a recording have come."""

from collections.abc import Callable

StageProgress = Callable[[str], object]
"""called with a stage's name, which is its command's, as it begins"""


def no_progress(stage: str) -> None:
    """Tells nobody."""
