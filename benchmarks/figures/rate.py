"""A counted rate with its exact confidence interval."""

from collections.abc import Iterable
from dataclasses import dataclass

from scipy.stats import binomtest


@dataclass(frozen=True)
class Rate:
    """How many of how many."""

    count: int
    of: int

    @property
    def interval_percent(self) -> tuple[float, float]:
        """95 % interval after Clopper and Pearson, in per cent."""
        low, high = binomtest(self.count, self.of).proportion_ci(method="exact")
        return 100 * float(low), 100 * float(high)

    @property
    def text(self) -> str:
        """Such as `221 of 228`."""
        return f"{self.count} of {self.of}" if self.of else "none run yet"

    @property
    def interval(self) -> str:
        """Such as `94 to 99 %`."""
        if not self.of:
            return "-"
        low, high = self.interval_percent
        return f"{_percent(low)} to {_percent(high)} %"

    @property
    def percent(self) -> str:
        """Such as `97 %`."""
        return f"{_percent(100 * self.count / self.of)} %" if self.of else "-"


def rate(outcomes: Iterable[bool]) -> Rate:
    """Of outcomes that are true."""
    known = list(outcomes)
    return Rate(sum(known), len(known))


def _percent(value: float) -> str:
    """One digit after the point near 0 and near 100, where it tells."""
    return f"{value:.0f}" if 10 <= value <= 90 else f"{value:.1f}".removesuffix(".0")
