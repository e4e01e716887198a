"""What makes a cause worth a name, and by how little two of them differ that data cannot tell apart.

The loss is the sum of squares of whitened residuals: noise alone makes about as much as there are rows.
"""

MIN_LOSS_SHARE = 0.08
"""of the loss: what a cause must take away at least (docs/thresholds.md)"""
MIN_EXPLAINED = 0.6
"""of the loss beyond noise: what all causes together take away at least, else none is named (docs/thresholds.md)"""
MIN_EXPLAINED_NEXT = 0.1
"""of what still stands above noise: what a cause takes away at least (docs/thresholds.md)"""
SINGLE_PLACE_SHARE = 0.95
"""of what an effect explains everywhere: a place that explains as much has it alone (docs/thresholds.md)"""
SIMPLER_SHARE = 0.1
"""of the gain: by so much less, fewer numbers are worth as much (docs/thresholds.md)"""
TIE_BY_CHANCE = 6.0
"""of the loss: causes whose fits differ by less may both be the one, by chance (docs/thresholds.md)"""


def tie_tolerance(loss: float, gain: float) -> float:
    """Of the loss with a cause, and what the cause takes: how much more another one may leave that explains as much.

    Forms of laws are not known better than to MIN_LOSS_SHARE of what is left, nor to SIMPLER_SHARE of what they explain."""
    return max(TIE_BY_CHANCE, min(MIN_LOSS_SHARE * loss, SIMPLER_SHARE * gain))
