"""What a diagnosis should measure of a hidden effect: the truth in the diagnosis's own numbers, as the effect itself states it.

Laws of another form than the hidden one have no such numbers: joint friction (arctan against tanh), hysteresis (Maxwell's elements
against Dahl's), exponential hardening, the depth of slack. Nor has a clock's offset, part of which the clocks' fit takes away.
"""

import re
from collections.abc import Mapping
from typing import Any

from diagnosis.effect import Numbers
from diagnosis.effects import EFFECTS


def expected(hidden: Mapping[str, Any], truth: Mapping[str, Any]) -> Numbers:
    """True numbers of a `hidden` entry of the truth; none where the laws' forms differ, or no effect has its name."""
    if hidden["effect"] not in EFFECTS:
        return {}
    place = re.search(r"\d+$", hidden["where"])
    return EFFECTS[hidden["effect"]].true_numbers(hidden["parameters"], truth, int(place[0]) if place else None)
