"""A cable that goes slack."""

import numpy as np

from diagnosis.check_fault import CheckFault
from diagnosis.effect import LawEffect, Placement, law_terms
from diagnosis.linearisation import RecordingLinearisation
from diagnosis.shown_by import ELONGATION

_REACHED_SHARE = 0.01
"""of a recording's time"""


class CableSlack(LawEffect):
    """A cable that goes slack."""

    name = "cable_slack"
    words = "a cable goes slack at times"
    place = "cable"
    shown_by = ELONGATION
    law = "cable_slack"
    terms = law_terms("cable_slack", "slack")
    shape_terms = law_terms("cable_slack", "xs")
    start_shapes = tuple({"xs": v} for v in (2e-5, 5e-4))
    from_vision = True
    in_full = True
    check_fault = CheckFault(
        fix="raise the least tension; leave the time around it out",
        tolerance=1e-4,
        tolerance_with_baseline=5e-5,
        of_one_moment=True,
    )
    order = 18

    def is_reached(self, recording: RecordingLinearisation, where: Placement) -> bool:
        """Whether a cable is stretched by less than that over which it comes taut, for a hundredth of the time."""
        cables = list(where.columns)
        least = np.quantile(recording.motor_signals.x[:, cables] + recording.x0[cables], _REACHED_SHARE, axis=0)
        return bool(np.any(least < np.broadcast_to(recording.values["xs"], recording.x0.shape)[cables]))
