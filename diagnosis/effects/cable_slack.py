"""A cable that goes slack."""

import numpy as np

from diagnosis.check_fault import CheckFault
from diagnosis.effect import LawEffect, Placement, law_terms
from diagnosis.linearisation import RecordingLinearisation
from diagnosis.shown_by import ELONGATION

_REACHED_SHARE = 0.01
"""of a recording's time"""
_SLACK_TENSION_SHARE = 0.05
"""of a cable's median tension: what counts as none (docs/thresholds.md)"""


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
        """Whether a cable is unstretched for a hundredth of the time, by the tension that its motor shows.

        Elongations do not tell: a law that turns over little by little takes another pre-elongation with it."""
        cables = list(where.columns)
        forces = recording.motor_forces
        tension = (forces.drive - recording.signals.inertial - forces.friction)[:, cables]
        unstretched = (
            np.log(2) * np.broadcast_to(recording.values["k"] * recording.values["xs"], recording.x0.shape)[cables]
        )
        none = np.maximum(unstretched, _SLACK_TENSION_SHARE * np.median(tension, axis=0))
        return bool(np.any(np.quantile(tension, _REACHED_SHARE, axis=0) < none))
