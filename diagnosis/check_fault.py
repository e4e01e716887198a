"""How `xneck check`, which holds vision against cable lengths, speaks of a fault."""

from dataclasses import dataclass


@dataclass(frozen=True)
class CheckFault:
    """A fault as check names it; its size is in the unit that check gives it."""

    fix: str
    """what a person is told to do"""
    tolerance: float = 0.0
    """size up to which an arm counts as healthy: what a law that does not quite fit a healthy cable can pass for"""
    tolerance_with_baseline: float = 0.0
    """the same where a healthy recording of the arm is known: what no arm is built or kept better than"""
    of_one_moment: bool = False
    """whether the rest of the recording is usable"""
