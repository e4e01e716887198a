"""A cable that goes slack."""

from diagnosis.check_fault import CheckFault
from diagnosis.effect import LawEffect, law_terms
from diagnosis.shown_by import ELONGATION


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
