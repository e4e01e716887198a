"""What `discover` finds: laws, with what they leave of the residual."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from discovery.array_problem import columns_of
from discovery.found_law import FoundLaw
from xneck_foundation.one_line import indexed

Array = NDArray[np.float64]

MAX_UNEXPLAINED = 1.2
"""times noise: what laws may leave and still be all (docs/thresholds.md)"""
MAX_UNEXPLAINED_AT_ONCE = 2.5
"""times noise: what they may leave in a single block (docs/thresholds.md)"""


@dataclass(frozen=True)
class Discovery:
    """What a residual follows."""

    laws: tuple[FoundLaw, ...]
    before: float
    """RMS of the residual about its mean"""
    after: float
    """RMS of what the laws leave"""
    noise: float | None
    """RMS of what nothing could explain; None where it was not given: then nobody knows whether what is left is noise"""
    residual_after: Array = field(repr=False)
    """what the laws leave of the residual about its mean, (T,), in the target's unit"""
    busiest: tuple[float, float] = (0.0, 0.0)
    """begin and end, s, of the block in which most is left"""
    busiest_rms: float = 0.0
    """RMS of what is left there"""
    direction_width: float = 0.0
    """speed within which the direction's sign changes, in the unit of DIRECTION"""

    def values(self, variables: Mapping[str, ArrayLike], time: ArrayLike) -> Array:
        """What the laws make of variables (T,) at times (T,), s, of this recording or another, (T,)."""
        every = {name: np.asarray(v, dtype=float) for name, v in variables.items()}
        every["time"] = np.asarray(time, dtype=float)
        out = np.zeros(len(every["time"]))
        for law in self.laws:
            out += columns_of(law.candidate, law.function, every, self.direction_width) @ law.amounts
        return out

    @property
    def something_remains(self) -> bool | None:
        """Whether plainly more than noise is left, in all or for a while, which no function of these variables explains.

        None where the noise was not given."""
        if self.noise is None:
            return None
        in_all, at_once = MAX_UNEXPLAINED * self.noise, MAX_UNEXPLAINED_AT_ONCE * self.noise
        return self.after > in_all or self.busiest_rms > at_once

    @property
    def words(self) -> str:
        """For a person."""
        lines = [f"{law.words}: {law.equation}" for law in self.laws]
        for law, at in zip(self.laws, range(len(lines)), strict=True):
            numbers = ", ".join(f"{indexed(p.name, p.index)} = {p.value:.4g} +- {p.sigma:.2g}" for p in law.parameters)
            lines[at] += f"\n  {numbers}"
            if law.alike:
                lines[at] += f"\n  explains it as well: {'; '.join(other.words for other in law.alike[:3])}"
        level = "not given: what is left may be more than noise" if self.noise is None else f"{self.noise:.4g}"
        lines.append(f"residual {self.before:.4g} -> {self.after:.4g}, noise {level}")
        if self.something_remains:
            first, last = self.busiest
            lines.append(
                "something is left that no function of these variables explains, "
                f"most of it from {first:.1f} to {last:.1f} s"
            )
        if not self.laws:
            lines.append("no law was found")
        return "\n".join(lines)

    def as_json(self) -> dict[str, Any]:
        """Laws and residuals, ready for JSON."""
        return {
            "found_laws": [law.as_json() for law in self.laws],
            "before": self.before,
            "after": self.after,
            "noise": self.noise,
            "something_remains": self.something_remains,
            "busiest_s": list(self.busiest),
            "busiest_rms": self.busiest_rms,
        }
