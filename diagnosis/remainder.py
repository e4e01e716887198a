"""What nothing named explains: of every equation its residual before and after, beside what noise alone leaves."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from diagnosis.noise_excess import NoiseExcess
from diagnosis.signature_record import channel_names

MAX_REMAINDER = 1.5
"""times noise: what a cause may leave of any equation and still be all that is wrong (docs/thresholds.md)"""


@dataclass(frozen=True)
class Remainder:
    """Of one equation, RMS."""

    equation: str
    unit: str
    before: float
    after: float
    noise_floor: float
    held_out: bool
    """whether of recordings that were not fitted"""

    @property
    def ratio(self) -> float:
        """What is left, over noise."""
        return self.after / self.noise_floor

    def as_json(self) -> dict[str, Any]:
        """The contract's record."""
        return {
            "equation": self.equation,
            "unit": self.unit,
            "before": self.before,
            "after": self.after,
            "noise_floor": self.noise_floor,
            "held_out": self.held_out,
        }


def remainders(before: NoiseExcess, after: NoiseExcess, motors: int, held_out: bool) -> tuple[Remainder, ...]:
    """The motors' equations before the arm's; before and after on the same recordings."""
    names = channel_names(motors, len(after.rms) - motors)
    return tuple(
        Remainder(
            equation=name,
            unit="N" if j < motors else "N m",
            before=float(old),
            after=float(new),
            noise_floor=float(floor),
            held_out=held_out,
        )
        for j, (name, old, new, floor) in enumerate(zip(names, before.rms, after.rms, after.floor, strict=True))
    )


def leaves_plainly_more(excess: NoiseExcess) -> bool:
    """Whether more than MAX_REMAINDER times noise is left of some equation."""
    return bool(excess.ratio.max() >= MAX_REMAINDER)


def plainly_left(left: Sequence[Remainder]) -> tuple[Remainder, ...]:
    """Those that stand above noise by more than MAX_REMAINDER, the largest first."""
    return tuple(sorted((r for r in left if r.ratio > MAX_REMAINDER), key=lambda r: -r.ratio))
